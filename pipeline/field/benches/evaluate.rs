//! Evaluation of 12-20-10-3 nets at the 262,144 pixels of a 512x512 picture, tile by tile on
//! one core: the batched field against the scalar net, for one cell, for 64 cells, with derived
//! inputs and for 16 lights.

#![allow(clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rrf_field::columns::{self, Columns};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::{self, Shape};
use rrf_field::tree::Tree;
use rrf_field::{Field, Light, Workspace};
use rrf_sampling::{Dimensions, Stage, Stream};
use std::hint::black_box;

const ROWS: usize = 262_144;

/// Numbers in [-1, 1).
struct Numbers(Dimensions);

impl Numbers {
    fn new(seed: u64) -> Numbers {
        Numbers(Stream::new(seed, Stage::Test, 0).dimensions(0))
    }

    fn next(&mut self) -> f32 {
        2.0 * self.0.next_f32() - 1.0
    }
}

/// The pixels of a 512x512 picture of a bowl, in tiles of 64x64, one light.
fn tiles() -> Vec<Columns> {
    let tile = |t: usize| {
        let mut rows = Columns::default();
        for pixel in 0..64 * 64 {
            let x = (t % 8 * 64 + pixel % 64) as f32 / 256.0 - 1.0;
            let y = (t / 8 * 64 + pixel / 64) as f32 / 256.0 - 1.0;
            let z = 0.4 * (x * x + y * y) - 0.4;
            let length = (0.64 * (x * x + y * y) + 1.0).sqrt();
            let n = [-0.8 * x / length, -0.8 * y / length, 1.0 / length];
            rows.push([
                x, y, z, n[0], n[1], n[2], 0.0, 0.0, 1.0, 0.2, 0.3, 0.9, 0.5, 0.5, 0.5, 0.5, 0.0,
                0.5,
            ]);
        }
        rows
    };
    (0..64).map(tile).collect()
}

fn model(cell: u32, inputs: Vec<u8>, numbers: &mut Numbers) -> CellModel {
    let shape = Shape {
        sizes: vec![inputs.len(), 20, 10, 3],
    };
    CellModel {
        cell,
        kind: Kind::Net,
        input_offset: inputs.iter().map(|_| 0.1 * numbers.next()).collect(),
        input_scale: inputs.iter().map(|_| 1.0 + 0.1 * numbers.next()).collect(),
        weights: (0..shape.weights()).map(|_| 0.7 * numbers.next()).collect(),
        inputs,
        shape,
        output_scale: [0.3; 3],
        output_offset: [0.1; 3],
        divide_base: false,
        exponential: false,
    }
}

/// A field of 2^`levels` cells, split in turn along x, y, z of the point.
fn field(levels: u32, inputs: &[u8]) -> Field {
    let mut tree = Tree::single();
    let mut leaves = vec![(0usize, [-1.0f32; 3], [1.0f32; 3])];
    for level in 0..levels as usize {
        let axis = level % 3;
        let mut next = Vec::new();
        for (node, low, high) in leaves {
            let middle = 0.5 * (low[axis] + high[axis]);
            let cells = tree.cells() as u32;
            let [left, right] = tree.split(node, columns::P + axis, middle, cells);
            let (mut left_high, mut right_low) = (high, low);
            left_high[axis] = middle;
            right_low[axis] = middle;
            next.extend([(left, low, left_high), (right, right_low, high)]);
        }
        leaves = next;
    }
    let mut numbers = Numbers::new(2);
    let models = (0..tree.cells() as u32)
        .map(|cell| model(cell, inputs.to_vec(), &mut numbers))
        .collect();
    Field::new(tree, models).expect("the benchmark's field is valid")
}

fn evaluate(criterion: &mut Criterion) {
    let tiles = tiles();
    let geometry: Vec<u8> = (0..columns::GEOMETRY as u8).collect();
    let derived: Vec<u8> = (0..columns::GEOMETRY as u8).chain(18..25).collect();
    let (mut out, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
    let lights = |count: usize| -> Vec<Light> {
        let mut numbers = Numbers::new(3);
        let mut light = || Light {
            position: std::array::from_fn(|_| numbers.next()),
            intensity: [1.0; 3],
        };
        (0..count).map(|_| light()).collect()
    };

    let mut group = criterion.benchmark_group("evaluate");
    group
        .throughput(Throughput::Elements(ROWS as u64))
        .sample_size(20);
    for (name, levels, inputs) in [
        ("batched, 1 cell", 0, &geometry),
        ("batched, 64 cells", 6, &geometry),
        ("batched, 64 cells, 19 inputs", 6, &derived),
    ] {
        let field = field(levels, inputs);
        group.bench_function(name, |b| {
            b.iter(|| {
                for rows in &tiles {
                    field
                        .evaluate(black_box(rows), &mut out, &mut cells)
                        .expect("valid rows");
                }
            });
        });
        for count in [1, 16] {
            let lit = field.under(&lights(count));
            let mut work = Workspace::default();
            group.bench_function(format!("{name}, {count} lights at once"), |b| {
                b.iter(|| {
                    for rows in &tiles {
                        lit.evaluate(black_box(rows), &mut work, &mut out, &mut cells, None)
                            .expect("valid rows");
                    }
                });
            });
        }
    }
    let field_64 = field(6, &geometry);
    group.bench_function("cells only, 64 cells", |b| {
        b.iter(|| {
            for rows in &tiles {
                field_64
                    .cells(black_box(rows), &mut cells)
                    .expect("valid rows");
            }
        });
    });

    let rows = &tiles[0];
    let one = model(0, geometry, &mut Numbers::new(2));
    let weights: Vec<f64> = one.weights.iter().map(|&w| f64::from(w)).collect();
    const SCALAR: usize = 4096;
    group
        .throughput(Throughput::Elements(SCALAR as u64))
        .sample_size(20);
    group.bench_function("scalar f64 (4096 rows)", |b| {
        b.iter(|| {
            let mut sum = 0.0;
            for r in 0..SCALAR {
                let x: Vec<f64> = rows.row(r)[..12].iter().map(|&x| f64::from(x)).collect();
                sum += net::evaluate(&one.shape, &weights, &x)[0];
            }
            sum
        });
    });
    group.finish();
}

criterion_group!(benches, evaluate);
criterion_main!(benches);
