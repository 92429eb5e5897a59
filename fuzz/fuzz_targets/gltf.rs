//! The glTF import; an input that begins like the binary form is read as one.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rrf_fuzz::gltf(bytes));
