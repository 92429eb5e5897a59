//! glTF and OBJ files, read.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod cases;
mod glb;
mod gltf_geometry;
mod gltf_lights;
mod gltf_materials;
mod gltf_scenes;
mod obj_files;
mod odd_glass;
mod skies;
mod support;
