//! From a prepared cell to a fitted model: initialize, optimise, evaluate, report.

mod evaluator;
mod evidence;
mod initialization;
mod logarithm;
mod online;
mod optimizer;
mod prune;
mod search;
pub mod spill;
mod warm;

use crate::baseline;
use crate::cell::Cell;
use crate::config::{Batches, Schedule, Size, TrainConfig};
use crate::end::FitEnd;
use crate::error::TrainError;
use crate::report::{CellFit, Course, Net, Trained, report};
use crate::rows::samples::Samples;
use crate::start::Start;
use evaluator::Evaluator;
use rrf_field::columns::Columns;
use rrf_field::model::Kind;
use rrf_lm::Termination;

/// Fits one cell. `halves` are two independent estimates of each row's radiance
/// [W·sr⁻¹·m⁻²]; the target is their mean. Rows marked in `validation` choose the weights that
/// are kept and tell the error, the others are trained on. The result depends on nothing but
/// the arguments.
///
/// # Errors
/// For arguments that do not fit together, and settings that are out of range.
pub fn fit_cell(
    cell: u32,
    rows: &Columns,
    halves: [&[[f32; 3]]; 2],
    validation: &[bool],
    config: &TrainConfig,
) -> Result<CellFit, TrainError> {
    let samples = Samples {
        rows,
        halves,
        validation,
    };
    fit_from(Start::default(), cell, samples, config)
}

/// [`fit_cell`] that may go on from an earlier net and may be told to give up.
///
/// # Errors
/// As [`fit_cell`], and [`TrainError::Halted`].
pub fn fit_from(
    start: Start,
    cell: u32,
    samples: Samples,
    config: &TrainConfig,
) -> Result<CellFit, TrainError> {
    fit_prepared(Cell::new(cell, samples, start, config)?)
}

fn fit_prepared(mut cell: Cell) -> Result<CellFit, TrainError> {
    let trained = train(&mut cell);
    let errors = evaluator::evaluate(&cell, &trained.model);
    // sums over rows that were broken off are of no use
    if cell.is_halted() {
        return Err(TrainError::Halted);
    }
    Ok(report(cell, trained, errors))
}

/// The model of least validation error that the configuration leads to.
fn train(cell: &mut Cell) -> Trained {
    baseline::set_inputs(cell);
    let end = if cell.train.len() == 0 {
        FitEnd::NoRows
    } else if cell.units.output.constant || cell.units.inputs.is_empty() {
        FitEnd::Constant
    } else if !cell.config.kind.is_net() {
        match baseline::solve(cell) {
            Some(trained) => return trained,
            None => Termination::NotFinite.into(),
        }
    } else if constant_suffices(cell) {
        let unused = cell.units.inputs.iter().map(|input| input.id);
        cell.dropped_inputs.extend(unused);
        FitEnd::Target
    } else {
        match train_net(cell) {
            Some(trained) => return trained,
            None => Termination::NotFinite.into(),
        }
    };
    constant(cell, end)
}

/// The weighted mean as a model without inputs.
fn constant(cell: &mut Cell, end: FitEnd) -> Trained {
    cell.set_inputs(Vec::new());
    let shape = cell.shape(&[]);
    let weights = vec![0.0; shape.weights()];
    Trained {
        model: cell.model(Kind::Net, shape, weights),
        course: Course::without_steps(end, 0.0, 0.0),
    }
}

/// Whether the mean alone reaches the error sought: the smallest model of all.
fn constant_suffices(cell: &Cell) -> bool {
    let Size::Smallest { target } = cell.config.size else {
        return false;
    };
    // A linear net of zeros answers with the mean; the second evaluation divides by it.
    let shape = cell.shape(&[]);
    let zeros = vec![0.0; shape.weights()];
    let mut evaluator = Evaluator::choosing(cell, &shape, 1.0);
    let share = cell.loss.target_share(evaluator.error(&zeros).square);
    evaluator.renew(&zeros, share);
    evaluator.error(&zeros).square <= target * target
}

/// A net; none where no start has a finite error.
fn train_net(cell: &mut Cell) -> Option<Trained> {
    let (mut net, mut course) = match cell.config.mode {
        Schedule::Local => match &cell.config.size {
            Size::Hidden(hidden) => search::best_of_starts(cell, &cell.shape(hidden)),
            Size::Smallest { target } => search::smallest(cell, *target),
        }?
        .finish(),
        Schedule::Online(batches) | Schedule::Recursive(batches) => online(cell, batches),
    };
    if let Some(tolerance) = cell.config.prune {
        (net, course) = pruned(cell, net, course, tolerance);
    }
    // as they are stored
    let weights = net.weights.iter().map(|w| *w as f32).collect();
    Some(Trained {
        model: cell.model(Kind::Net, net.shape, weights),
        course,
    })
}

/// Hidden layers of an online fit that leaves the size open: it sees its rows only once.
const ONLINE_HIDDEN: &[usize] = &[20, 10];

fn online(cell: &Cell, batches: Batches) -> (Net, Course) {
    let hidden = match &cell.config.size {
        Size::Hidden(hidden) => hidden,
        Size::Smallest { .. } => ONLINE_HIDDEN,
    };
    online::train(cell, cell.shape(hidden), batches)
}

/// What pruning leaves, and the course of the fit of the net that it began with.
fn pruned(cell: &mut Cell, net: Net, course: Course, tolerance: f64) -> (Net, Course) {
    let within = net.error * (1.0 + tolerance).powi(2);
    // the climb to the smallest net has been through the others
    let (limit, smaller) = match cell.config.size {
        Size::Smallest { target } => (within.max(target * target), None),
        Size::Hidden(_) => (within, search::smaller(cell, &net.shape, within)),
    };
    let (net, mut course) = match smaller {
        Some(found) => found.finish(),
        None => (net, course),
    };
    let net = prune::prune(cell, net, limit);
    course.effective_parameters = course.effective_parameters.min(net.weights.len() as f64);
    (net, course)
}
