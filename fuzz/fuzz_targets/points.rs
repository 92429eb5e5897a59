//! A table of points, Parquet or Arrow by its ending.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    rrf_fuzz::points(bytes);
});
