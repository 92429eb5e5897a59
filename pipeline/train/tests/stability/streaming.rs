//! Rows that are read again and again instead of held.

use crate::cells::{self, Cell, smooth};
use rrf_field::columns::Columns;
use rrf_field::model::CellModel;
use rrf_train::Scaling;
use rrf_train::blocks::Normal;
use rrf_train::lm::{Levenberg, LmConfig, Problem};
use rrf_train::prepare::{self, OutputScale, Samples};
use rrf_train::problem::{Loss, NetProblem};
use rrf_train::rows::MemoryRows;
use rrf_train::streamed::{Chunk, StreamedRows};
use rrf_train::tile::Rows;
use std::cell::Cell as Counter;

const ROWS: usize = 3000;

fn part(cell: &Cell, first: usize, count: usize) -> Chunk {
    let cut = |column: &Vec<f32>| column[first..first + count].to_vec();
    Chunk {
        columns: Columns {
            columns: std::array::from_fn(|c| cut(&cell.columns.columns[c])),
        },
        halves: [0, 1].map(|h| cell.halves[h][first..first + count].to_vec()),
    }
}

fn held(cell: &Cell, units: &CellModel) -> MemoryRows {
    let mut inputs = prepare::compute_inputs(&units.inputs, &cell.columns);
    for (i, input) in inputs.iter_mut().enumerate() {
        (input.offset, input.scale) = (units.input_offset[i], units.input_scale[i]);
    }
    let samples = Samples {
        rows: &cell.columns,
        halves: [&cell.halves[0], &cell.halves[1]],
        validation: &cell.validation,
    };
    let output = OutputScale {
        scale: units.output_scale,
        offset: units.output_offset,
        constant: false,
    };
    let all: Vec<u32> = (0..ROWS as u32).collect();
    MemoryRows::new(&samples, &all, &inputs, &output, units.divide_base)
}

/// Five steps and what they lead to.
fn steps(rows: impl Rows, units: &CellModel) -> (Vec<f64>, Normal) {
    let loss = Loss::Relative {
        floor: 0.05,
        noise: 1e-4,
    };
    let mut problem = NetProblem::new(&units.shape, rows, 3 * ROWS, loss);
    let config = LmConfig {
        scaling: Scaling::Identity,
        ..LmConfig::default()
    };
    let mut w: Vec<f64> = units.weights.iter().map(|w| f64::from(*w) * 0.9).collect();
    let mut lm = Levenberg::new(w.len(), config);
    for _ in 0..5 {
        lm.step(&mut problem, &mut w, 1e-3).unwrap();
    }
    (w, lm.normal)
}

/// 300 rows asked for at a time become 384, three tiles; never more than these are held.
#[test]
fn streamed_rows_give_the_bits_of_rows_in_memory() {
    let cell = Cell::new(ROWS, 0.02, smooth);
    let units = cell.fit(&cells::config()).model;
    let (reads, most) = (Counter::new(0), Counter::new(0));
    let streamed = StreamedRows::new(ROWS, 300, &units, |first, count| {
        reads.set(reads.get() + 1);
        most.set(most.get().max(count));
        Ok::<_, ()>(part(&cell, first, count))
    });
    let (from_stream, from_memory) = (steps(&streamed, &units), steps(held(&cell, &units), &units));
    assert_eq!(from_stream, from_memory);
    assert_eq!(most.get(), 384);
    // eight chunks a pass, at least two passes a step
    assert!(reads.get() >= 5 * 2 * 8, "{}", reads.get());
}

/// A part that cannot be read stops the fit before it moves a weight.
#[test]
fn a_failed_read_stops_the_fit() {
    let cell = Cell::new(ROWS, 0.0, smooth);
    let units = cell.fit(&cells::config()).model;
    let streamed = StreamedRows::new(ROWS, 512, &units, |first, count| {
        if first >= 1024 {
            return Err("gone");
        }
        Ok(part(&cell, first, count))
    });
    let mut problem = NetProblem::new(&units.shape, &streamed, 3 * ROWS, Loss::Absolute);
    let mut w: Vec<f64> = units.weights.iter().map(|w| f64::from(*w)).collect();
    let before = w.clone();
    assert!(problem.cost(&w).is_nan());
    let mut lm = Levenberg::new(w.len(), LmConfig::default());
    assert_eq!(
        lm.step(&mut problem, &mut w, 0.0),
        Err(rrf_train::Stop::NotFinite)
    );
    assert_eq!(streamed.failure(), Some("gone"));
    assert_eq!(w, before);
}
