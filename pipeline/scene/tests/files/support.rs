//! What tests of several formats need.

use crate::glb::Glb;
use rrf_scene::{Scene, Warning};
use serde_json::json;
use std::path::Path;

/// A triangle at the origin, so that there is a surface.
pub fn some_triangle(glb: &mut Glb) {
    let positions = glb.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let attributes = json!({ "POSITION": positions });
    glb.place(json!({ "attributes": attributes }), json!({}));
}

/// A file of the repository.
pub fn repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

/// The warnings, without the one that every scene without lights gets.
pub fn notes(scene: &Scene) -> Vec<&Warning> {
    let is_common = |w: &&Warning| w.message.contains("no lights of its own");
    scene.warnings.iter().filter(|w| !is_common(w)).collect()
}

/// Whether a warning's message contains `part`.
pub fn warns(scene: &Scene, part: &str) -> bool {
    scene
        .warnings
        .iter()
        .any(|warning| warning.message.contains(part))
}

/// Cross product of a triangle's edges: its geometric normal times twice its area.
pub fn edge_cross(scene: &Scene, triangle: usize) -> glam::Vec3 {
    let [a, b, c] = scene.triangles[triangle].map(|v| scene.positions[v as usize]);
    (b - a).cross(c - a)
}
