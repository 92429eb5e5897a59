//! Whole texts, read as `load` reads them.

mod cornell;
mod errors;
mod files;
mod lights;
mod materials;
mod media;
mod orientation;
mod robust;
mod shapes;
mod skies;

use super::reader::Reader;
use crate::validate::validate;
use crate::{Scene, SceneError};
use glam::Vec3;
use std::path::Path;

/// Reads a text without a file.
fn read_bytes(bytes: &[u8]) -> Result<Scene, SceneError> {
    let path = Path::new("scene.pbrt");
    let mut reader = Reader::new(path);
    match reader.main_text(path, bytes) {
        Ok(()) => validate(reader.finish()),
        Err(fault) => Err(reader.files.error(fault)),
    }
}

/// A version 4 scene of a world's text.
fn world_v4(world: &str) -> Result<Scene, SceneError> {
    read_bytes(format!("Film \"rgb\"\nWorldBegin\n{world}").as_bytes())
}

/// A version 3 scene of a world's text.
fn world_v3(world: &str) -> Result<Scene, SceneError> {
    read_bytes(format!("Film \"image\"\nWorldBegin\n{world}\nWorldEnd").as_bytes())
}

/// A triangle in z = 0 that faces +z.
const TRIANGLE: &str = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";

/// The unit geometric normal of a triangle.
fn normal(scene: &Scene, triangle: usize) -> Vec3 {
    let [a, b, c] = scene.corners(triangle).unwrap();
    (b - a).cross(c - a).normalize()
}

/// All warnings in one text.
fn warnings(scene: &Scene) -> String {
    let lines: Vec<String> = scene
        .warnings
        .iter()
        .map(|w| format!("{}: {}", w.place, w.message))
        .collect();
    lines.join("\n")
}

/// The place and words of a syntax error.
fn syntax(result: Result<Scene, SceneError>) -> (u32, u32, String) {
    match result {
        Err(SceneError::Syntax {
            line,
            column,
            message,
            ..
        }) => (line, column, message),
        other => panic!("no syntax error but {other:?}"),
    }
}
