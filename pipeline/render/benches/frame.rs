//! Frames of the Cornell box, 512x512, on all cores: the whole frame and its parts, by nets of
//! 12-20-10-3 over 64 cells (their weights are arbitrary: time does not depend on them).

#![allow(clippy::unwrap_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use rrf_field::Field;
use rrf_field::columns;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_render::{Lights, Part, RenderOptions, View, render};
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use std::path::Path;

fn model(cell: u32) -> CellModel {
    let shape = Shape {
        sizes: vec![columns::GEOMETRY, 20, 10, 3],
    };
    let wave = |i: usize| (i as f32 * 0.73 + cell as f32).sin() * 0.4;
    CellModel {
        cell,
        kind: Kind::Net,
        inputs: (0..columns::GEOMETRY as u8).collect(),
        input_offset: vec![0.0; columns::GEOMETRY],
        input_scale: vec![1.0; columns::GEOMETRY],
        weights: (0..shape.weights()).map(wave).collect(),
        shape,
        output_scale: [0.1; 3],
        output_offset: [0.1; 3],
        divide_base: false,
        exponential: false,
    }
}

/// 64 cells: four halvings of the room in turn along x, y, z, then two of the light's y.
fn field() -> Field {
    let mut tree = Tree::single();
    let mut leaves = vec![(0, [-1.0f32, 0.0, -1.0, 1.0], [1.0f32, 2.0, 1.0, 2.0])];
    for axis in [0, 1, 2, 0, 3, 3] {
        let column = [columns::P, columns::P + 1, columns::P + 2, columns::L + 1][axis];
        let split = |(node, low, high): (usize, [f32; 4], [f32; 4])| {
            let middle = 0.5 * (low[axis] + high[axis]);
            let cell = tree.cells() as u32;
            let [left, right] = tree.split(node, column, middle, cell);
            let (mut below, mut above) = (high, low);
            below[axis] = middle;
            above[axis] = middle;
            [(left, low, below), (right, above, high)]
        };
        leaves = leaves.into_iter().flat_map(split).collect();
    }
    let models = (0..tree.cells() as u32).map(model).collect();
    Field::new(tree, models).unwrap()
}

fn frames(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
    let scene = rrf_scene::load(&path, &rrf_scene::LoadOptions::default()).unwrap();
    let mut view = View::from(&scene.cameras[0]);
    (view.width, view.height) = (512, 512);
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene).unwrap();
    let field = field();
    let lights = |count: usize| Lights {
        points: (0..count)
            .map(|k| PointLight {
                position: Vec3::new(0.08 * k as f32 - 0.6, 1.4 + 0.02 * k as f32, 0.1),
                intensity: Vec3::ONE,
            })
            .collect(),
        area: false,
        ..Lights::default()
    };
    let mut group = criterion.benchmark_group("cornell box 512x512");
    group
        .throughput(Throughput::Elements(512 * 512))
        .sample_size(20);
    for (name, part, count) in [
        ("full, 1 light", Part::Full, 1),
        ("camera rays only", Part::Direct, 0),
        ("direct, 1 light", Part::Direct, 1),
        ("indirect, 1 light", Part::Indirect, 1),
        ("full, 16 lights", Part::Full, 16),
    ] {
        let (lights, options) = (
            lights(count),
            RenderOptions {
                part,
                ..RenderOptions::default()
            },
        );
        group.bench_function(name, |b| {
            b.iter(|| render(&tracer, &field, &view, &lights, &options).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
