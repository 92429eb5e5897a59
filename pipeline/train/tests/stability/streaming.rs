//! Rows in a file instead of in memory, and fits that go on after a kill.

use crate::baselines;
use crate::cells::{self, Cell, smooth};
use rrf_field::columns::Columns;
use rrf_train::checkpoint::Keeper;
use rrf_train::prepare::Samples;
use rrf_train::spill::{SpillError, fit_spilled};
use rrf_train::{CellFit, Kind, Size, Start, TrainConfig, fit_from};
use std::cell::RefCell;
use std::fs::File;
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

fn kept(keeper: Option<&dyn Keeper>) -> Start<'_> {
    Start {
        earlier: None,
        keeper,
    }
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

fn spilled(cell: &Cell, rows: usize, config: &TrainConfig, keeper: Option<&dyn Keeper>) -> CellFit {
    let pass = |see: &mut dyn FnMut(&Samples)| {
        pieces(cell, rows, see);
        Ok::<(), io::Error>(())
    };
    fit_spilled(
        kept(keeper),
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
    assert_eq!(a.model, b.model);
    assert_eq!(a.report, b.report);
    let timeless = |fit: &CellFit| {
        let mut metrics = fit.metrics.clone();
        metrics.seconds = 0.0;
        metrics
    };
    assert_eq!(timeless(a), timeless(b));
}

/// Legs of three lengths, starts that compete, the decay's evidence, then pruning.
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
            mean_luminance: None,
            ..config()
        };
        config.lm.reuse = reuse;
        let held = fit_from(kept(None), 0, samples(&cell), &config).unwrap();
        assert_eq!(held.metrics.quarantined_rows, 2);
        for rows in [ROWS, 1000] {
            assert_same(&spilled(&cell, rows, &config, None), &held);
        }
        // going on from a net
        let unpruned = TrainConfig {
            prune: None,
            ..config
        };
        let start = Start {
            earlier: Some(&held.model),
            keeper: None,
        };
        let further = fit_from(start, 0, samples(&cell), &unpruned).unwrap();
        let pass = |see: &mut dyn FnMut(&Samples)| {
            pieces(&cell, 700, see);
            Ok::<(), io::Error>(())
        };
        let file = tempfile::tempfile().unwrap();
        let from_file = fit_spilled(start, 0, pass, &file, &unpruned).unwrap();
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
    let found = fit_spilled(kept(None), 0, pass, &File::open(&path).unwrap(), &config());
    assert!(matches!(found, Err(SpillError::Scratch(_))));
    // cut short behind the fit's back
    let file = tempfile::tempfile().unwrap();
    let cutting = Cutting(&file);
    let found = fit_spilled(kept(Some(&cutting)), 0, pass, &file, &config());
    assert!(matches!(found, Err(SpillError::Scratch(_))), "{found:?}");
}

/// Cuts the file off in the middle of the fit.
struct Cutting<'a>(&'a File);

impl Keeper for Cutting<'_> {
    fn load(&self) -> Option<Vec<u8>> {
        None
    }

    fn is_due(&self) -> bool {
        true
    }

    fn save(&self, _: &[u8]) {
        self.0.set_len(100_000).unwrap();
    }
}

/// Keeps every state that it is given.
#[derive(Default)]
struct Album {
    first: Option<Vec<u8>>,
    states: RefCell<Vec<Vec<u8>>>,
}

impl Keeper for Album {
    fn load(&self) -> Option<Vec<u8>> {
        self.first.clone()
    }

    fn is_due(&self) -> bool {
        true
    }

    fn save(&self, state: &[u8]) {
        self.states.borrow_mut().push(state.to_vec());
    }
}

/// Killed after any step and begun again from what was kept there: the same bits, and only the
/// steps that were left.
#[test]
fn a_fit_goes_on_from_any_of_its_states() {
    for exponential in [false, true] {
        goes_on(&TrainConfig {
            exponential,
            ..config()
        });
    }
    let mut kept = config();
    kept.lm.reuse = 4;
    goes_on(&kept);
}

fn goes_on(config: &TrainConfig) {
    let cell = cell(0.02);
    let whole = fit_from(kept(None), 0, samples(&cell), config).unwrap();
    let album = Album::default();
    assert_same(
        &fit_from(kept(Some(&album)), 0, samples(&cell), config).unwrap(),
        &whole,
    );
    let states = album.states.into_inner();
    assert!(states.len() > 20, "{} states", states.len());
    for (at, state) in states.iter().enumerate().step_by(3) {
        let album = Album {
            first: Some(state.clone()),
            ..Album::default()
        };
        assert_same(
            &fit_from(kept(Some(&album)), 0, samples(&cell), config).unwrap(),
            &whole,
        );
        assert_eq!(album.states.into_inner(), states[at..]);
    }
    // a state of rows in memory is one of rows in a file
    let album = Album {
        first: states.last().cloned(),
        ..Album::default()
    };
    assert_same(&spilled(&cell, 2000, config, Some(&album)), &whole);
    assert_eq!(album.states.into_inner().len(), 1);
}

/// Bytes that are no state, or that of another fit, change nothing.
#[test]
fn a_state_of_another_fit_is_not_used() {
    let cell = cell(0.02);
    let other = TrainConfig {
        size: Size::Hidden(vec![5]),
        ..config()
    };
    let album = Album::default();
    fit_from(kept(Some(&album)), 0, samples(&cell), &other).unwrap();
    let states = album.states.into_inner();
    let whole = fit_from(kept(None), 0, samples(&cell), &config()).unwrap();
    for first in [
        &states[0],
        &states[states.len() / 2],
        &vec![7; 801],
        &vec![255; 800],
    ] {
        let album = Album {
            first: Some(first.clone()),
            ..Album::default()
        };
        assert_same(
            &fit_from(kept(Some(&album)), 0, samples(&cell), &config()).unwrap(),
            &whole,
        );
    }
}

/// Baselines too are the same from a file.
#[test]
fn baselines_from_a_file() {
    let cell = cell(0.05);
    for kind in BASELINES {
        let config = baselines::config(kind);
        let held = fit_from(Start::default(), 0, samples(&cell), &config).unwrap();
        assert_same(&held, &spilled(&cell, 1000, &config, None));
    }
}

const BASELINES: [Kind; 2] = [Kind::Quadratic, Kind::Nearest];
