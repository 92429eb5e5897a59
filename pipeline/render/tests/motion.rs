//! A light that moves slowly: what the nets show changes with it, and nothing else changes.

#![allow(clippy::unwrap_used)]

use glam::{Vec2, Vec3};
use rrf_field::Field;
use rrf_field::columns;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_render::{Frame, Lights, Part, RenderOptions, View, render};
use rrf_scene::{INVALID, Material, PointLight, Scene};
use rrf_trace::Tracer;

/// How far the light goes from frame to frame.
const STEP: f32 = 1e-3;

/// A grey floor.
fn scene() -> Scene {
    let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]];
    Scene {
        positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        normals: vec![Vec3::ZERO; 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_material: vec![0; 2],
        triangle_light: vec![INVALID; 2],
        triangle_object: vec![0; 2],
        materials: vec![Material::lambert("grey", Vec3::splat(0.6))],
        ..Scene::default()
    }
}

/// The nets of two neighbouring cells, which differ a little.
fn model(cell: u32, weights_of: u32) -> CellModel {
    let inputs: Vec<u8> = vec![0, 1, 9, 10, 11, 18, 19, 20, 21];
    let shape = Shape {
        sizes: vec![inputs.len(), 8, 3],
    };
    CellModel {
        cell,
        kind: Kind::Net,
        input_offset: vec![0.0; inputs.len()],
        input_scale: vec![1.0; inputs.len()],
        weights: (0..shape.weights())
            .map(|k| (k as f32 * 1.7).sin() + 0.02 * weights_of as f32)
            .collect(),
        inputs,
        shape,
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: true,
    }
}

/// Two cells, parted by the light's x at 0.
fn field() -> Field {
    let mut tree = Tree::single();
    tree.split(0, columns::L, 0.0, 1);
    Field::new(tree, vec![model(0, 0), model(1, 1)]).unwrap()
}

fn place(step: i32) -> Vec3 {
    // the crossing lies half-way between two frames
    Vec3::new((step as f32 + 0.5) * STEP, 0.2, 1.5)
}

/// Indirect frames of the floor under lights at each of the places.
fn frames(field: &Field, places: impl Iterator<Item = Vec3>) -> Vec<Frame> {
    let scene = scene();
    let tracer = Tracer::new(&scene).unwrap();
    let eye = Vec3::new(0.0, -2.5, 0.9);
    let view = View::look_at(eye, Vec3::ZERO, Vec3::Z, 40.0, [40, 30]);
    let options = RenderOptions {
        part: Part::Indirect,
        ..RenderOptions::default()
    };
    let frame = |position| {
        let light = PointLight {
            position,
            intensity: Vec3::ONE,
        };
        let lights = Lights {
            points: vec![light],
            area: false,
            ..Lights::default()
        };
        render(&tracer, field, &view, &lights, &options).unwrap()
    };
    places.map(frame).collect()
}

/// Root mean square of a combination of frames' red channels, weights in time order.
fn rms(frames: &[Frame], weights: &[f64]) -> f64 {
    let count = frames[0].full.len();
    let value = |pixel: usize| {
        let terms = frames.iter().zip(weights);
        terms
            .map(|(frame, w)| w * f64::from(frame.full[pixel].x))
            .sum::<f64>()
    };
    ((0..count).map(|pixel| value(pixel).powi(2)).sum::<f64>() / count as f64).sqrt()
}

/// Noise of each frame's own would make second differences sqrt(6) sigma, first ones sqrt(2)
/// sigma: a ratio of 1.73 where nothing moves, and at least that of the noise where something
/// does. What is smooth over a length L has the ratio STEP / L: with L of at least 2 cm, which is
/// far shorter than anything these nets know, 0.05.
#[test]
fn a_slow_light_does_not_flicker() {
    let frames = frames(&field(), (-20..20).map(place));
    for side in [&frames[..20], &frames[20..]] {
        for three in side.windows(3) {
            let first = rms(&three[..2], &[-1.0, 1.0]);
            let second = rms(three, &[1.0, -2.0, 1.0]);
            assert!(first > 0.0);
            assert!(second < 0.05 * first, "{second} against {first}");
        }
    }
}

/// Where the light crosses into the other cell, the picture jumps by what the two nets differ by
/// there, give or take the step itself: at most what the steps before and after change.
#[test]
fn a_crossing_jumps_by_the_difference_of_the_nets() {
    let crossing = frames(&field(), (-2..2).map(place));
    let step = |k: usize| rms(&crossing[k..k + 2], &[-1.0, 1.0]);
    let both: Vec<Frame> = (0..2)
        .flat_map(|net| {
            let alone = Field::new(Tree::single(), vec![model(0, net)]).unwrap();
            frames(&alone, [Vec3::new(0.0, 0.2, 1.5)].into_iter())
        })
        .collect();
    let difference = rms(&both, &[-1.0, 1.0]);
    let (before, jump, after) = (step(0), step(1), step(2));
    assert!(jump > 3.0 * before.max(after), "{before} {jump} {after}");
    assert!(
        (jump - difference).abs() <= before + after,
        "{jump} against {difference}"
    );
    assert!(crossing[1].cell != crossing[2].cell);
}
