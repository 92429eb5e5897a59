//! The OBJ import with its material library.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rrf_fuzz::obj(bytes));
