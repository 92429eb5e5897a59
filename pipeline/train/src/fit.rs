//! One cell's samples in, one cell's model out.

use crate::config::{Decay, TrainConfig};
use crate::error::TrainError;
use crate::halves::{self, ErrorEstimate};
use crate::lm::{Levenberg, Problem, Stop};
use crate::prepare::{self, Input, MemoryRows, OutputScale, Samples};
use crate::problem::{Loss, NetProblem};
use crate::tile::CHANNELS;
use rrf_field::columns::Columns;
use rrf_field::model::CellModel;
use rrf_field::net::Shape;
use rrf_field::rng::{Stage, Stream};
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
    pub stop: Stop,
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

/// Rows split, scaled and ready for nets of any shape.
pub(crate) struct Prepared<'a> {
    pub samples: Samples<'a>,
    pub config: &'a TrainConfig,
    pub inputs: Vec<Input>,
    pub output: OutputScale,
    pub loss: Loss,
    pub floor: f64,
    pub train_ids: Vec<u32>,
    pub validation_ids: Vec<u32>,
    pub train: MemoryRows,
    pub validation: MemoryRows,
    pub report: FitReport,
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
    let start = Instant::now();
    let samples = Samples {
        rows,
        halves,
        validation,
    };
    let prepared = Prepared::new(samples, config)?;
    let mut fit = if let Some(stop) = prepared.trivial() {
        prepared.constant(cell, stop)
    } else {
        prepared.train(cell)
    };
    fit.metrics.seconds = start.elapsed().as_secs_f64();
    Ok(fit)
}

impl<'a> Prepared<'a> {
    pub(crate) fn new(
        samples: Samples<'a>,
        config: &'a TrainConfig,
    ) -> Result<Prepared<'a>, TrainError> {
        samples.check()?;
        config.check()?;
        let divide = config.divide_base;
        let (ids, mut dropped_inputs) = prepare::choose_inputs(config)?;
        let mut inputs = prepare::compute_inputs(&ids, samples.rows);
        let quarantined = prepare::quarantine(&samples, &inputs, divide);
        let mut usable = vec![true; samples.rows.len()];
        for &row in &quarantined {
            usable[row as usize] = false;
        }
        let (mut train_ids, mut validation_ids) = (Vec::new(), Vec::new());
        for (row, _) in usable.iter().enumerate().filter(|(_, usable)| **usable) {
            if samples.validation[row] {
                validation_ids.push(row as u32);
            } else {
                train_ids.push(row as u32);
            }
        }
        dropped_inputs.extend(prepare::scale_inputs(&mut inputs, &train_ids));
        let floor = floor(&samples, &train_ids, &validation_ids, config);
        let ids = if train_ids.is_empty() {
            &validation_ids
        } else {
            &train_ids
        };
        let output = prepare::scale_outputs(&samples, ids, floor, divide);
        let memory = |ids: &[u32]| MemoryRows::new(&samples, ids, &inputs, &output, divide);
        let loss = if config.relative {
            let noise = prepare::noise(&samples, ids, floor);
            Loss::Relative { floor, noise }
        } else {
            Loss::Absolute
        };
        Ok(Prepared {
            train: memory(&train_ids),
            validation: memory(&validation_ids),
            loss,
            report: FitReport {
                quarantined,
                dropped_inputs,
                history: Vec::new(),
            },
            samples,
            config,
            inputs,
            output,
            floor,
            train_ids,
            validation_ids,
        })
    }

    /// Why no net is needed, if so.
    fn trivial(&self) -> Option<Stop> {
        if self.train_ids.is_empty() {
            Some(Stop::NoRows)
        } else if self.output.constant || self.inputs.is_empty() {
            Some(Stop::Constant)
        } else {
            None
        }
    }

    /// The weighted mean as a model without inputs.
    fn constant(self, cell: u32, stop: Stop) -> CellFit {
        let shape = Shape {
            sizes: vec![0, CHANNELS],
        };
        let mut none = self;
        none.inputs.clear();
        let memory = |ids: &[u32]| {
            MemoryRows::new(
                &none.samples,
                ids,
                &[],
                &none.output,
                none.config.divide_base,
            )
        };
        none.train = memory(&none.train_ids);
        none.validation = memory(&none.validation_ids);
        let ended = Ended {
            weights: vec![0.0; shape.weights()],
            iterations: 0,
            stop,
            mu: 0.0,
            alpha: 0.0,
            gamma: 0.0,
        };
        none.finish(cell, shape, ended)
    }

    fn train(mut self, cell: u32) -> CellFit {
        let mut sizes = vec![self.inputs.len()];
        sizes.extend(&self.config.hidden);
        sizes.push(CHANNELS);
        let shape = Shape { sizes };
        let stream = Stream::new(self.config.seed, Stage::Train, cell);
        let mut history = Vec::new();
        let ended = self.descend(&shape, first_weights(&shape, &stream, 0), &mut history);
        self.report.history = history;
        self.finish(cell, shape, ended)
    }

    /// Levenberg-Marquardt from `w` on; the weights with the best validation error.
    fn descend(&self, shape: &Shape, mut w: Vec<f64>, history: &mut Vec<HistoryRow>) -> Ended {
        let config = self.config;
        let residuals = self.train.residuals();
        let mut alpha = config.decay.start() * residuals as f64;
        let mut gamma = w.len() as f64;
        let mut problem = NetProblem::new(shape, &self.train, residuals, self.loss);
        let mut judge = self.judge(shape);
        let mut lm = Levenberg::new(w.len(), config.lm);
        solve_output(&mut problem, &mut lm, shape, &mut w, alpha);
        let mut best = (judge.error(&w).square, w.clone());
        let (mut stop, mut since) = (Stop::Iterations, 0);
        for iteration in 1..=config.iterations {
            let step = match lm.step(&mut problem, &mut w, alpha) {
                Ok(step) => step,
                Err(reason) => {
                    stop = reason;
                    break;
                }
            };
            if iteration % RENEW_JUDGE == 0 {
                judge.renew(&best.1, problem.target_share());
                best.0 = judge.error(&best.1).square;
            }
            if let (Decay::Evidence(_), 0) = (config.decay, iteration % EVIDENCE) {
                let n = residuals as f64;
                if let Some(found) = lm.evidence(alpha, &w, step.data, n) {
                    (alpha, gamma) = (found.alpha, found.gamma);
                }
            }
            let validation = judge.error(&w).square;
            history.push(HistoryRow {
                iteration,
                cost: step.data / residuals.max(1) as f64,
                validation,
                mu: lm.mu,
                gain: step.gain,
            });
            since += 1;
            if validation < best.0 || !best.0.is_finite() {
                best = (validation, w.clone());
                since = 0;
            }
            if since >= config.patience {
                stop = Stop::Validation;
                break;
            }
            if step.before - step.after <= config.lm.cost * step.before {
                stop = Stop::Cost;
                break;
            }
        }
        Ended {
            weights: best.1,
            iterations: history.len(),
            stop,
            mu: lm.mu,
            alpha: alpha / residuals.max(1) as f64,
            gamma,
        }
    }

    /// The rows that choose the weights: validation, or training where there is none.
    fn judge(&self, shape: &Shape) -> Judge<'_> {
        let (rows, ids) = if self.validation_ids.is_empty() {
            (&self.train, &self.train_ids)
        } else {
            (&self.validation, &self.validation_ids)
        };
        Judge::new(self, shape, rows, ids)
    }

    /// Rounds the weights to f32, as they are stored, and judges what is stored.
    fn finish(self, cell: u32, shape: Shape, ended: Ended) -> CellFit {
        let weights: Vec<f32> = ended.weights.iter().map(|w| *w as f32).collect();
        let stored: Vec<f64> = weights.iter().map(|w| f64::from(*w)).collect();
        let share = {
            let mut judge = Judge::new(&self, &shape, &self.train, &self.train_ids);
            self.loss.target_share(judge.error(&stored).square)
        };
        let error = |rows, ids| {
            let mut judge = Judge::new(&self, &shape, rows, ids);
            judge.renew(&stored, share);
            judge.error(&stored)
        };
        let train_error = error(&self.train, &self.train_ids);
        let validation_error = error(&self.validation, &self.validation_ids);
        let metrics = CellMetrics {
            cell,
            seed: self.config.seed,
            rows: self.samples.rows.len(),
            train_rows: self.train_ids.len(),
            validation_rows: self.validation_ids.len(),
            quarantined_rows: self.report.quarantined.len(),
            iterations: ended.iterations,
            stop: ended.stop,
            train_error,
            validation_error,
            alpha: ended.alpha,
            mu: ended.mu,
            effective_parameters: ended.gamma,
            weights: weights.len(),
            floor: self.floor,
            seconds: 0.0,
        };
        let model = CellModel {
            cell,
            inputs: self.inputs.iter().map(|i| i.id).collect(),
            input_offset: self.inputs.iter().map(|i| i.offset).collect(),
            input_scale: self.inputs.iter().map(|i| i.scale).collect(),
            shape,
            weights,
            output_scale: self.output.scale,
            output_offset: self.output.offset,
            divide_base: self.config.divide_base,
        };
        CellFit {
            model,
            metrics,
            report: self.report,
        }
    }
}

/// Accepted steps after which the luminances that validation errors are divided by are renewed.
const RENEW_JUDGE: usize = 10;

/// Accepted steps from one update of the weight decay to the next.
const EVIDENCE: usize = 4;

/// Tells a net's error over some rows, free of Monte Carlo noise.
struct Judge<'a> {
    prepared: &'a Prepared<'a>,
    problem: NetProblem<'a, MemoryRows>,
    ids: &'a [u32],
    divisor: Vec<f64>,
}

impl<'a> Judge<'a> {
    /// Errors are divided by the luminance of the targets until [`Judge::renew`].
    fn new(prepared: &'a Prepared, shape: &Shape, rows: &'a MemoryRows, ids: &'a [u32]) -> Self {
        let divisor = (ids.iter())
            .map(|&r| prepare::luminance(prepared.samples.mean(r as usize)))
            .map(|luminance| 1.0 / luminance.max(prepared.floor))
            .collect();
        Judge {
            problem: NetProblem::new(shape, rows, ids.len() * CHANNELS, prepared.loss),
            prepared,
            ids,
            divisor,
        }
    }

    /// From here on errors are divided by `share` of the targets' luminance and 1 − `share` of
    /// the luminance that the net with weights `w` predicts.
    fn renew(&mut self, w: &[f64], share: f64) {
        let (divisor, floor) = (&mut self.divisor, self.prepared.floor);
        self.problem.each_tile(w, |first, tile| {
            for (d, l) in divisor[first..].iter_mut().zip(tile.luminance(share)) {
                *d = 1.0 / l.max(floor);
            }
        });
    }

    /// Squared relative error of the net with weights `w`.
    fn error(&mut self, w: &[f64]) -> ErrorEstimate {
        let mut values = Vec::with_capacity(self.ids.len());
        let (prepared, ids, divisor) = (self.prepared, self.ids, &self.divisor);
        let output = &prepared.output;
        self.problem.each_tile(w, |first, tile| {
            for i in 0..tile.batch.rows {
                let row = ids[first + i] as usize;
                let base = prepared.samples.base(row, prepared.config.divide_base);
                let p = std::array::from_fn(|c| {
                    let (scale, offset) = (output.scale[c], output.offset[c]);
                    base[c] * (f64::from(offset) + f64::from(scale) * tile.out[c][i])
                });
                let [y1, y2] = prepared.samples.halves.map(|half| half[row]);
                values.push(halves::product(p, y1, y2, divisor[first + i]));
            }
        });
        ErrorEstimate::of(&values)
    }
}

/// The output layer is linear: its best weights for the hidden layers at hand, errors divided by
/// the targets' luminance, are one solve away.
fn solve_output(
    problem: &mut NetProblem<MemoryRows>,
    lm: &mut Levenberg,
    shape: &Shape,
    w: &mut [f64],
    alpha: f64,
) {
    let first = shape.offsets().last().copied().unwrap_or(0);
    w[first..].fill(0.0);
    problem.linearise(w, &mut lm.normal);
    let (n, m) = (w.len(), w.len() - first);
    let mut block = vec![0.0; m * m];
    for i in 0..m {
        block[i * m..][..m].copy_from_slice(&lm.normal.matrix[(first + i) * n + first..][..m]);
    }
    let mut right: Vec<f64> = lm.normal.gradient[first..].iter().map(|g| -g).collect();
    let largest = (0..m).map(|i| block[i * m + i]).fold(0.0, f64::max);
    let mut factor = crate::linalg::Cholesky::default();
    let add = vec![alpha + 1e-10 * largest; m];
    // Without a factor the layer stays at zero: the mean, a valid start.
    if factor.factor(&block, &add).is_ok() && factor.solve(&mut right).is_ok() {
        w[first..].copy_from_slice(&right);
    }
}

/// Where a descent ended.
struct Ended {
    weights: Vec<f64>,
    iterations: usize,
    stop: Stop,
    mu: f64,
    alpha: f64,
    gamma: f64,
}

/// ε in radiance.
fn floor(samples: &Samples, train: &[u32], validation: &[u32], config: &TrainConfig) -> f64 {
    let rows = || train.iter().chain(validation);
    let own = || {
        let sum: f64 = rows()
            .map(|&r| prepare::luminance(samples.mean(r as usize)))
            .sum();
        sum / rows().count().max(1) as f64
    };
    let mean = config.mean_luminance.map_or_else(own, f64::from);
    // Black cells: any positive number, the errors are then absolute.
    if mean > 0.0 {
        config.epsilon * mean
    } else {
        1.0
    }
}

/// Weights of a start: uniform with variance 1 / inputs (LeCun et al. 1998), biases uniform in
/// ±1 so that the units' thresholds spread over the standardised inputs.
pub(crate) fn first_weights(shape: &Shape, stream: &Stream, start: u64) -> Vec<f64> {
    let mut w = Vec::with_capacity(shape.weights());
    for layer in shape.sizes.windows(2) {
        let range = (3.0 / layer[0].max(1) as f64).sqrt();
        for _ in 0..layer[1] {
            for input in 0..=layer[0] {
                let u = 2.0 * stream.f64(start, w.len() as u32) - 1.0;
                w.push(if input == 0 { u } else { range * u });
            }
        }
    }
    w
}
