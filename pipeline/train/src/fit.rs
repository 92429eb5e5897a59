//! One cell's samples in, one cell's model out.

use crate::baseline;
use crate::cell::Cell;
use crate::config::{Batches, Mode, Size, TrainConfig};
use crate::descent::Descent;
use crate::error::TrainError;
use crate::halves::ErrorEstimate;
use crate::judge::Judge;
use crate::end::FitEnd;
use crate::online;
use crate::prepare::Samples;
use crate::prune::{self, Net};
use crate::search;
use rrf_field::columns::Columns;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_lm::Termination;
use std::time::Instant;

/// A fitted cell.
#[derive(Clone, Debug)]
pub struct CellFit {
    /// What is stored and evaluated.
    pub model: CellModel,
    /// How the fit went, in numbers.
    pub metrics: CellMetrics,
    /// How the fit went, row by row and step by step.
    pub report: FitReport,
}

/// Numbers of one fit.
#[derive(Clone, Debug, PartialEq)]
pub struct CellMetrics {
    /// The cell.
    pub cell: u32,
    /// Seed of the first weights.
    pub seed: u64,
    /// Rows of the cell.
    pub rows: usize,
    /// Rows trained on.
    pub train_rows: usize,
    /// Rows kept back.
    pub validation_rows: usize,
    /// Rows left out because a number in them is not finite.
    pub quarantined_rows: usize,
    /// Accepted steps.
    pub iterations: usize,
    /// Why the fit ended.
    pub stop: FitEnd,
    /// Squared relative error over the training rows, free of Monte Carlo noise but not of what
    /// the net has learned of it: slightly low.
    pub train_error: ErrorEstimate,
    /// Squared relative error over the validation rows, free of Monte Carlo noise.
    pub validation_error: ErrorEstimate,
    /// Weight decay, a residual.
    pub alpha: f64,
    /// Damping at the end.
    pub mu: f64,
    /// Effective parameters γ; without an estimate the number of weights.
    pub effective_parameters: f64,
    /// Weights stored.
    pub weights: usize,
    /// ε of the relative error, W·sr⁻¹·m⁻².
    pub floor: f64,
    /// Wall time; not part of any stored model.
    pub seconds: f64,
}

/// One accepted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryRow {
    /// Accepted steps so far.
    pub iteration: usize,
    /// Residuals of the rows stepped on.
    pub residuals: usize,
    /// Mean weighted squared residual over the training rows (with noise).
    pub cost: f64,
    /// Squared relative error on the rows judged by.
    pub validation: f64,
    /// Damping after the step.
    pub mu: f64,
    /// Gain ratio.
    pub gain: f64,
}

/// What is worth knowing about a fit beyond its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitReport {
    /// Rows left out because a number in them is not finite, by place in the cell.
    pub quarantined: Vec<u32>,
    /// Inputs dropped because they do not vary or cannot matter, as places in `rrf_field::model::INPUTS`.
    pub dropped_inputs: Vec<u8>,
    /// The course of the fit.
    pub history: Vec<HistoryRow>,
}

/// Fits one cell. `halves` are two independent estimates of each row's radiance
/// [W·sr⁻¹·m⁻²]; the target is their mean. Rows marked in `validation` choose the weights that
/// are kept and tell the error, the others are trained on. The result depends on nothing but
/// the arguments.
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
    fit_from(None, cell, samples, config)
}

/// [`fit_cell`] that goes on from an earlier net: that of a cell around this one or of fewer rows.
/// It is used where the two are of one kind and the earlier one is no larger.
///
/// # Errors
/// As [`fit_cell`].
pub fn fit_from(
    earlier: Option<&CellModel>,
    cell: u32,
    samples: Samples,
    config: &TrainConfig,
) -> Result<CellFit, TrainError> {
    Ok(fit_prepared(
        cell,
        Cell::new(cell, samples, config)?.going_on(earlier),
    ))
}

pub(crate) fn fit_prepared(cell: u32, prepared: Cell) -> CellFit {
    let start = Instant::now();
    let prepared = baseline::with_inputs(prepared);
    let mut fit = match prepared.trivial() {
        Some(stop) => constant(cell, prepared, stop),
        None if !prepared.config.kind.is_net() => match baseline::fit(cell, &prepared) {
            Some(fit) => fit,
            None => constant(cell, prepared, Termination::NotFinite.into()),
        },
        None => train(cell, prepared),
    };
    fit.metrics.seconds = start.elapsed().as_secs_f64();
    fit
}

/// Whether the mean alone reaches the error sought: the smallest model of all.
fn constant_suffices(prepared: &Cell) -> bool {
    let Size::Smallest { target } = prepared.config.size else {
        return false;
    };
    // A linear net of zeros answers with the mean; the second judgement divides by it.
    let shape = prepared.shape(&[]);
    let zeros = vec![0.0; shape.weights()];
    let mut judge = Judge::choosing(prepared, &shape, 1.0);
    let share = prepared.loss.target_share(judge.error(&zeros).square);
    judge.renew(&zeros, share);
    judge.error(&zeros).square <= target * target
}

/// The weighted mean as a model without inputs.
fn constant(cell: u32, prepared: Cell, stop: FitEnd) -> CellFit {
    let prepared = prepared.without_inputs();
    let shape = prepared.shape(&[]);
    let ended = Ended {
        weights: vec![0.0; shape.weights()],
        shape,
        error: f64::INFINITY,
        stop,
        iterations: 0,
        mu: 0.0,
        alpha: 0.0,
        gamma: 0.0,
    };
    finish(cell, prepared, ended)
}

fn train(cell: u32, mut prepared: Cell) -> CellFit {
    if constant_suffices(&prepared) {
        let unused = prepared.units.inputs.iter().map(|input| input.id);
        prepared.report.dropped_inputs.extend(unused);
        return constant(cell, prepared, FitEnd::Target);
    }
    let (mut ended, mut history) = match prepared.config.mode {
        Mode::Local => match local(&prepared) {
            Some(found) => found,
            None => return constant(cell, prepared, Termination::NotFinite.into()),
        },
        Mode::Online(batches) | Mode::Recursive(batches) => online(&prepared, batches),
    };
    if let Some(tolerance) = prepared.config.prune {
        ended = pruned(&mut prepared, ended, &mut history, tolerance);
    }
    prepared.report.history = history;
    finish(cell, prepared, ended)
}

fn local(prepared: &Cell) -> Option<(Ended, Vec<HistoryRow>)> {
    let (best, stop) = match &prepared.config.size {
        Size::Hidden(hidden) => search::best_of_starts(prepared, &prepared.shape(hidden)),
        Size::Smallest { target } => search::smallest(prepared, *target),
    }?;
    let history = best.history.clone();
    Some((Ended::of(best, stop), history))
}

fn online(prepared: &Cell, batches: Batches) -> (Ended, Vec<HistoryRow>) {
    let shape = match &prepared.config.size {
        Size::Hidden(hidden) => prepared.shape(hidden),
        Size::Smallest { .. } => prepared.shape(ONLINE_HIDDEN),
    };
    let found = online::train(prepared, &shape, batches);
    let ended = Ended {
        gamma: shape.weights() as f64,
        shape,
        weights: found.best,
        error: found.error,
        stop: found.stop.into(),
        iterations: found.history.len(),
        mu: found.mu,
        alpha: prepared.config.decay.start(),
    };
    (ended, found.history)
}

/// Hidden layers of an online fit that leaves the size open: it sees its rows only once.
const ONLINE_HIDDEN: &[usize] = &[20, 10];

/// What pruning leaves; `history` is that of the net it began with.
fn pruned(
    prepared: &mut Cell,
    ended: Ended,
    history: &mut Vec<HistoryRow>,
    tolerance: f64,
) -> Ended {
    let within = ended.error * (1.0 + tolerance).powi(2);
    // the climb to the smallest net has been through the others
    let (limit, smaller) = match prepared.config.size {
        Size::Smallest { target } => (within.max(target * target), None),
        Size::Hidden(_) => (within, search::smaller(prepared, &ended.shape, within)),
    };
    let ended = match smaller {
        Some((net, stop)) => {
            history.clone_from(&net.history);
            Ended::of(net, stop)
        }
        None => ended,
    };
    let net = Net {
        shape: ended.shape,
        weights: ended.weights,
        error: ended.error,
        alpha: ended.alpha,
    };
    let net = prune::prune(prepared, net, limit);
    Ended {
        gamma: ended.gamma.min(net.weights.len() as f64),
        shape: net.shape,
        weights: net.weights,
        error: net.error,
        ..ended
    }
}

/// Where training ended.
struct Ended {
    shape: Shape,
    weights: Vec<f64>,
    /// Squared relative error on the choosing rows.
    error: f64,
    stop: FitEnd,
    iterations: usize,
    mu: f64,
    alpha: f64,
    gamma: f64,
}

impl Ended {
    fn of(best: Descent, stop: FitEnd) -> Ended {
        Ended {
            mu: best.mu(),
            iterations: best.history.len(),
            shape: best.shape,
            weights: best.best,
            error: best.error,
            stop,
            alpha: best.alpha,
            gamma: best.gamma,
        }
    }
}

/// Rounds the weights to f32, as they are stored, and judges what is stored.
fn finish(cell: u32, prepared: Cell, ended: Ended) -> CellFit {
    let shape = ended.shape;
    let weights: Vec<f32> = ended.weights.iter().map(|w| *w as f32).collect();
    let stored: Vec<f64> = weights.iter().map(|w| f64::from(*w)).collect();
    let mut on_training = Judge::on_training(&prepared, &shape, usize::MAX);
    let mut on_validation = Judge::on_validation(&prepared, &shape, usize::MAX);
    let share = prepared
        .loss
        .target_share(on_training.error(&stored).square);
    let [train_error, validation_error] = [&mut on_training, &mut on_validation].map(|judge| {
        judge.renew(&stored, share);
        judge.error(&stored)
    });
    let metrics = CellMetrics {
        cell,
        seed: prepared.config.seed,
        rows: prepared.rows,
        train_rows: prepared.train.len(),
        validation_rows: prepared.validation.len(),
        quarantined_rows: prepared.report.quarantined.len(),
        iterations: ended.iterations,
        stop: ended.stop,
        train_error,
        validation_error,
        alpha: ended.alpha,
        mu: ended.mu,
        effective_parameters: ended.gamma,
        weights: weights.len(),
        floor: prepared.floor,
        seconds: 0.0,
    };
    let model = CellModel {
        cell,
        kind: Kind::Net,
        inputs: prepared.units.inputs.iter().map(|i| i.id).collect(),
        input_offset: prepared.units.inputs.iter().map(|i| i.offset).collect(),
        input_scale: prepared.units.inputs.iter().map(|i| i.scale).collect(),
        shape,
        weights,
        output_scale: prepared.units.output.scale,
        output_offset: prepared.units.output.offset,
        divide_base: prepared.config.divide_base,
        exponential: prepared.config.exponential,
    };
    CellFit {
        model,
        metrics,
        report: prepared.report,
    }
}
