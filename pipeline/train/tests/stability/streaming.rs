//! Rows in a file instead of in memory.

use crate::baselines;
use crate::cells::{self, Cell, smooth};
use rrf_field::columns::Columns;
use rrf_train::Samples;
use rrf_train::fit::spill::{SpillError, fit_spilled};
use rrf_train::{CellFit, Kind, Size, Start, TrainConfig, TrainError, fit_from};
use std::fs::{File, OpenOptions};
use std::io;

/// More than a window of the file.
const ROWS: usize = 9000;

fn cell(noise: f64) -> Cell {
    let mut cell = Cell::new(ROWS, noise, smooth);
    // what is left out must be left out of the file too
    cell.halves[0][17][1] = f32::NAN;
    cell.halves[1][5003][0] = f32::INFINITY;
    cell
}

fn samples(cell: &Cell) -> Samples<'_> {
    Samples {
        rows: &cell.columns,
        halves: [&cell.halves[0], &cell.halves[1]],
        validation: &cell.validation,
    }
}

/// The cell in pieces of `rows` rows.
fn pieces(cell: &Cell, rows: usize, see: &mut dyn FnMut(&Samples)) {
    for first in (0..ROWS).step_by(rows) {
        let range = first..ROWS.min(first + rows);
        let columns = Columns {
            columns: std::array::from_fn(|c| cell.columns.columns[c][range.clone()].to_vec()),
        };
        see(&Samples {
            rows: &columns,
            halves: [0, 1].map(|h| &cell.halves[h][range.clone()]),
            validation: &cell.validation[range],
        });
    }
}

fn spilled(cell: &Cell, rows: usize, config: &TrainConfig) -> CellFit {
    let pass = |see: &mut dyn FnMut(&Samples)| {
        pieces(cell, rows, see);
        Ok::<(), io::Error>(())
    };
    fit_spilled(
        Start::default(),
        0,
        pass,
        &tempfile::tempfile().unwrap(),
        config,
    )
    .unwrap()
}

fn assert_same(a: &CellFit, b: &CellFit) {
    let bits =
        |fit: &CellFit| -> Vec<u32> { fit.model.weights.iter().map(|w| w.to_bits()).collect() };
    assert_eq!(bits(a), bits(b));
    assert_eq!(a, b);
}

/// Phases of three lengths, starts that compete, the decay's evidence, then pruning.
fn config() -> TrainConfig {
    TrainConfig {
        size: Size::Hidden(vec![6, 4]),
        starts: 3,
        rungs: 2,
        rung_steps: 3,
        iterations: 9,
        prune: Some(0.05),
        ..cells::config()
    }
}

#[test]
fn a_file_of_rows_gives_the_bits_of_rows_in_memory() {
    let cell = cell(0.02);
    for (divide_base, reuse) in [(false, 1), (true, 1), (true, 4)] {
        let mut config = TrainConfig {
            divide_base,
            mean_radiance: None,
            ..config()
        };
        config.lm.reuse = reuse;
        let held = fit_from(Start::default(), 0, samples(&cell), &config).unwrap();
        assert_eq!(held.quarantined.len(), 2);
        for rows in [ROWS, 1000] {
            assert_same(&spilled(&cell, rows, &config), &held);
        }
        // going on from a net
        let unpruned = TrainConfig {
            prune: None,
            ..config
        };
        let earlier = Some(&held.model);
        let further = fit_from(earlier.into(), 0, samples(&cell), &unpruned).unwrap();
        let pass = |see: &mut dyn FnMut(&Samples)| {
            pieces(&cell, 700, see);
            Ok::<(), io::Error>(())
        };
        let file = tempfile::tempfile().unwrap();
        let from_file = fit_spilled(earlier.into(), 0, pass, &file, &unpruned).unwrap();
        assert_same(&from_file, &further);
    }
}

#[test]
fn a_file_that_cannot_be_used_is_an_error() {
    let cell = cell(0.0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("read only");
    std::fs::write(&path, b"").unwrap();
    let pass = |see: &mut dyn FnMut(&Samples)| {
        pieces(&cell, ROWS, see);
        Ok::<(), io::Error>(())
    };
    let write_only = OpenOptions::new().write(true).open(&path).unwrap();
    for unusable in [File::open(&path).unwrap(), write_only] {
        let found = fit_spilled(Start::default(), 0, pass, &unusable, &config());
        assert!(matches!(found, Err(SpillError::Scratch(_))), "{found:?}");
    }
}

/// Baselines too are the same from a file.
#[test]
fn baselines_from_a_file() {
    let cell = cell(0.05);
    for kind in BASELINES {
        let config = baselines::config(kind);
        let held = fit_from(Start::default(), 0, samples(&cell), &config).unwrap();
        assert_same(&held, &spilled(&cell, 1000, &config));
    }
}

const BASELINES: [Kind; 2] = [Kind::Quadratic, Kind::Nearest];

/// Fits that are told to give up end with an error, whether their rows are held or in a file, and
/// however late they are told: at the n-th question.
#[test]
fn a_fit_that_is_halted_is_an_error() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let cell = cell(0.0);
    let config = config();
    for questions in [0, 1, 10, 100] {
        let asked = AtomicUsize::new(0);
        let halt = || asked.fetch_add(1, Ordering::Relaxed) >= questions;
        let start = Start {
            earlier: None,
            halt: Some(&halt),
        };
        let held = fit_from(start, 0, samples(&cell), &config);
        assert!(matches!(held, Err(TrainError::Halted)), "{questions}");
        let pass = |see: &mut dyn FnMut(&Samples)| {
            pieces(&cell, 700, see);
            Ok::<(), io::Error>(())
        };
        let file = tempfile::tempfile().unwrap();
        let spilled = fit_spilled(start, 0, pass, &file, &config);
        let end = matches!(spilled, Err(SpillError::Train(TrainError::Halted)));
        assert!(end, "{questions}");
    }
}
