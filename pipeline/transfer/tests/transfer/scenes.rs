//! Scenes and points for the tests.

use glam::{Vec2, Vec3};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, LoadOptions, Material, Scene, load};
use rrf_trace::{SurfacePoint, Tracer};
use rrf_transfer::RowPoint;

/// A scene of the repository without its lamp.
pub fn file(name: &str) -> Scene {
    let path = format!("{}/../../scenes/{name}", env!("CARGO_MANIFEST_DIR"));
    load(path.as_ref(), &LoadOptions::default())
        .unwrap()
        .unlit()
}

pub fn cornell() -> Scene {
    file("cornell-box/scene.pbrt")
}

/// A closed room between the corners, of one Lambert material, walls of 2 triangles each, normals
/// inward.
pub fn room(low: Vec3, high: Vec3, albedo: Vec3) -> Scene {
    let mut scene = Scene {
        materials: vec![Material::lambert("wall", albedo)],
        objects: vec!["room".into()],
        ..Scene::default()
    };
    for i in 0..8 {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high } else { low }[axis];
        scene.positions.push(Vec3::new(pick(0), pick(1), pick(2)));
        scene.normals.push(Vec3::ZERO);
        scene.uvs.push(Vec2::ZERO);
    }
    for [a, b, c, d] in [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ] {
        for triangle in [[a, c, b], [a, d, c]] {
            scene.triangles.push(triangle);
            scene.triangle_material.push(0);
            scene.triangle_light.push(INVALID);
            scene.triangle_object.push(0);
        }
    }
    scene
}

/// The middle of the Cornell box.
pub const MIDDLE: Vec3 = Vec3::new(0.0, 1.0, 0.0);

/// Points of the surface that look into the room, uniform by area, and viewers near its middle.
pub fn points(tracer: &Tracer, middle: Vec3, count: usize, seed: u64) -> Vec<RowPoint> {
    let stream = Stream::new(seed, Stage::Test, 0);
    let mut found = Vec::new();
    for i in 0.. {
        if found.len() == count {
            break;
        }
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        let viewer =
            (middle + Vec3::new(w[0], w[1], w[2]) * 0.8 - 0.4 - point.position).normalize();
        if is_open(tracer, &point, viewer) {
            found.push(RowPoint { point, viewer });
        }
    }
    found
}

/// Whether a point sees far enough toward its viewer not to be sealed under a box.
fn is_open(tracer: &Tracer, point: &SurfacePoint, viewer: Vec3) -> bool {
    let mut rays = rrf_trace::Rays::default();
    let origin = tracer.lift(point.triangle, point.position, viewer);
    rays.push(origin, viewer, 0.3);
    let mut blocked = Vec::new();
    tracer.occluded(&rays, &mut blocked);
    !blocked[0] && point.normal.dot(viewer).abs() > 0.05
}
