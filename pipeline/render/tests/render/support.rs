//! Scenes, views, lights and a field that is a known function.

use glam::{Vec2, Vec3};
use rrf_field::Field;
use rrf_field::columns::{self};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_render::{Lights, OFF_CENTRE, PathOptions, View};
use rrf_scene::{INVALID, Material, PointLight, Scene};

pub const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);

/// A Lambert square of side 4 in z = 0, and if asked a small one above its right half at z = 0.5.
pub fn floor(blocker: bool) -> Scene {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut positions: Vec<Vec3> = corners
        .map(|(x, y)| Vec3::new(2.0 * x, 2.0 * y, 0.0))
        .to_vec();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    if blocker {
        positions.extend(corners.map(|(x, y)| Vec3::new(0.5 + 0.2 * x, 0.2 * y, 0.5)));
        triangles.extend([[4, 5, 6], [4, 6, 7]]);
    }
    let count = triangles.len();
    Scene {
        normals: vec![Vec3::ZERO; positions.len()],
        uvs: vec![Vec2::ZERO; positions.len()],
        positions,
        triangle_material: vec![0; count],
        triangle_light: vec![INVALID; count],
        triangle_object: vec![0; count],
        triangles,
        materials: vec![Material::lambert("floor", ALBEDO)],
        ..Scene::default()
    }
}

/// A camera above the origin that looks down; image x is world x, image y is world -y.
pub fn above(size: [u32; 2]) -> View {
    View::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 30.0, size)
}

/// Where the ray nearest to image position (x, y) meets z = 0.
pub fn on_floor(view: &View, x: f32, y: f32) -> Vec3 {
    let d = view.direction(x + OFF_CENTRE[0], y + OFF_CENTRE[1]);
    view.eye - d * (view.eye.z / d.z)
}

pub fn point(position: [f32; 3], intensity: [f32; 3]) -> PointLight {
    PointLight {
        position: position.into(),
        intensity: intensity.into(),
    }
}

pub fn paths(spp: u32, aa: u32, seed: u64) -> PathOptions {
    PathOptions { spp, aa, seed }
}

pub fn lights(points: Vec<PointLight>) -> Lights {
    Lights {
        points,
        area: false,
        ..Lights::default()
    }
}

/// Nets without hidden layers: Φ = (1, p_x, l_x) left of x = 0, (1, p_x, l_x + 10) right of it.
pub fn linear_field() -> Field {
    let mut tree = Tree::single();
    tree.split(0, columns::P, 0.0, 1);
    let model = |cell: u32, offset: f32| CellModel {
        cell,
        kind: Kind::Net,
        inputs: vec![columns::P as u8, columns::L as u8],
        input_offset: vec![0.0; 2],
        input_scale: vec![1.0; 2],
        shape: Shape { sizes: vec![2, 3] },
        weights: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, offset, 0.0, 1.0],
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: false,
    };
    Field::new(tree, vec![model(0, 0.0), model(1, 10.0)]).unwrap()
}

pub fn close(a: Vec3, b: Vec3) -> bool {
    // A dozen roundings of single precision.
    (a - b)
        .abs()
        .cmple(12.0 * f32::EPSILON * b.abs().max(Vec3::splat(1e-3)))
        .all()
}
