//! Whole texts, read through the public entry.

use crate::{LoadOptions, Scene, SceneError, load};
use glam::Vec3;
use std::path::Path;

fn cornell_path() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt")
}

#[test]
fn cornell_box() {
    let scene = load(&cornell_path(), &LoadOptions::default()).unwrap();
    assert_eq!(scene.triangles.len(), 36);
    println!("{:#?}", scene.warnings);
    println!("{:#?}", scene.cameras);
    println!("{:?}", scene.area_lights);
    println!("{:?}", scene.materials);
}
