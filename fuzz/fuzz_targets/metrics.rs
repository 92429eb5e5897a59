//! The metrics of a model.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    rrf_fuzz::model("metrics", bytes);
});
