//! The plan of a round, and the tasks that follow from it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    rrf_fuzz::plan_json(bytes);
});
