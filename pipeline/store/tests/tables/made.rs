//! Tables made from a counter, for tests and for the fixture that the Python checks read.

use rrf_field::columns::{COUNT, Columns};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::{Domain, Tree};
use rrf_metrics::estimate::SquareError;
use rrf_sampling::hash::hash;
use rrf_store::manifest::{FORMAT, RunFacts, RunManifest};
use rrf_store::model::{CellMetrics, FitStep, ModelTree, Seams, Spread};
use rrf_store::samples::SampleTable;

/// A number in [0, 1) from a counter.
pub fn unit(counter: u64) -> f32 {
    rrf_sampling::unit((hash(0, counter + 1) >> 32) as u32)
}

pub fn manifest() -> RunManifest {
    RunManifest {
        format: FORMAT,
        created_by: "rrf 0.1.0".into(),
        scene: "scenes/room.pbrt".into(),
        scene_hash: "0123456789abcdef".repeat(4),
        seed: u64::MAX - 1,
        light_box: [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6],
        config: serde_json::json!({ "target": 0.05, "paths": 128 }),
        kernels: None,
    }
}

pub fn facts() -> RunFacts {
    manifest().facts()
}

/// A direction of unit length with z up.
fn direction(counter: u64) -> [f32; 3] {
    let z = 0.1 + 0.9 * unit(counter);
    let phi = std::f32::consts::TAU * unit(counter + 1);
    let r = (1.0 - z * z).sqrt();
    [r * phi.cos(), r * phi.sin(), z]
}

pub fn row(counter: u64) -> [f32; COUNT] {
    let u = |d| unit(counter * 64 + d);
    let v = direction(counter * 64 + 8);
    let (p, l) = ([u(0), u(1), 0.0], [u(2), u(3), 1.0 + u(4)]);
    let a = [0.63, 0.065, 0.05, 0.5 * u(5), 0.0, 0.5];
    let mut row = [0.0; COUNT];
    for c in 0..3 {
        (row[c], row[3 + c], row[6 + c], row[9 + c]) = (p[c], [0.0, 0.0, 1.0][c], v[c], l[c]);
    }
    row[12..].copy_from_slice(&a);
    row
}

pub fn samples(cell_id: u32, first: u64, rows: u64) -> SampleTable {
    let mut table = SampleTable {
        cell_id,
        ..SampleTable::default()
    };
    let mut columns = Columns::default();
    for index in first..first + rows {
        table.index.push(index);
        columns.push(row(index));
        table
            .material
            .push(if index % 7 == 0 { u32::MAX } else { 3 });
        for (h, half) in table.halves.iter_mut().enumerate() {
            let y = |c: u64| unit(index * 64 + 32 + 4 * h as u64 + c);
            half.push([y(0), y(1), 0.1 * y(2)]);
        }
        table.paths.push(128);
    }
    table.columns = columns;
    table
}

pub fn tree() -> ModelTree {
    let mut tree = Tree::single();
    let [_, right] = tree.split(0, 0, 0.5, 1);
    tree.split(right, 9, 0.25, 2);
    let mut tree = ModelTree::new(tree);
    for (node, cell) in tree.leaves().collect::<Vec<_>>() {
        // The last cell's domain stays unknown.
        tree.domains[node] = (cell != 2).then(|| Domain {
            minimum: row(u64::from(cell)).map(|x| x - 1.0),
            maximum: row(u64::from(cell)),
        });
    }
    tree
}

pub fn cell_model(cell: u32) -> CellModel {
    // the last one is one colour all over
    let (inputs, hidden): (Vec<u8>, &[usize]) = match cell {
        2 => (Vec::new(), &[]),
        _ => (vec![0, 1, 2, 6, 7, 8, 9, 10, 11, 18, 19, 20, 21], &[6, 4]),
    };
    let shape = Shape {
        sizes: [&[inputs.len()], hidden, &[3]].concat(),
    };
    let number = |i: usize| unit(u64::from(cell) * 100_000 + i as u64) - 0.5;
    CellModel {
        cell,
        kind: Kind::Net,
        input_offset: (0..inputs.len()).map(|i| 0.1 * number(i)).collect(),
        input_scale: (0..inputs.len()).map(|i| 1.0 + number(i + 50)).collect(),
        weights: (0..shape.weights()).map(|i| number(i + 100)).collect(),
        output_scale: [2.0, 1.5, 0.25],
        output_offset: [0.5, 0.25, 0.125],
        divide_base: cell % 2 == 1,
        exponential: cell % 3 == 1,
        inputs,
        shape,
    }
}

pub fn metrics(cell_id: u32) -> CellMetrics {
    CellMetrics {
        cell_id,
        round: 1,
        rows: 1_000,
        train_rows: 700,
        validation_rows: 300 * u64::from(cell_id != 2),
        quarantined_rows: 0,
        iterations: 57,
        stop_reason: "validation error stopped falling".into(),
        train: Some(SquareError {
            mean: 0.0016,
            se: 0.0002,
        }),
        // A negative estimate, and none.
        validation: (cell_id != 2).then_some(SquareError {
            mean: -0.0001,
            se: 0.0004,
        }),
        noise: Some(0.016),
        effective_parameters: None,
        alpha: 1e-6,
        damping: 1e-3,
        weights: cell_model(cell_id).weights.len() as u32,
        seed: facts().seed,
        seams: seams(cell_id),
    }
}

/// Of a cell with neighbours, of one without, and none.
fn seams(cell_id: u32) -> Option<Seams> {
    let spread = |rms| Spread {
        rms,
        median: 0.5 * rms,
    };
    match cell_id {
        0 => Some(Seams {
            rows: 120,
            jump: Some(spread(0.0625)),
            change: Some(spread(0.125)),
        }),
        1 => Some(Seams::default()),
        _ => None,
    }
}

/// A fit's course, with a batch that had no step.
pub fn steps() -> Vec<FitStep> {
    let step = |n: u32| FitStep {
        step: n,
        residuals: 3 * u64::from(n),
        cost: (n != 2).then(|| 1.0 / f64::from(n)),
        relative_square_error: (n != 3).then(|| 0.01 - 0.004 * f64::from(n)),
        damping: 10f64.powi(-(n as i32)),
        gain: (n != 2).then_some(0.75),
    };
    (1..=4).map(step).collect()
}
