//! A part of the samples, whole and batch by batch.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    rrf_fuzz::part(bytes);
});
