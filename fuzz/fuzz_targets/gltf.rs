//! The glTF import, text form.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    rrf_fuzz::scene("scene.gltf", bytes);
});
