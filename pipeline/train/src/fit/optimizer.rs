//! The optimizer run of one net: steps on a share of the rows, the best weights kept.

use super::evaluator::Evaluator;
use super::evidence;
use super::initialization::{Initialization, random_weights};
use crate::cell::Cell;
use crate::config::Decay;
use crate::end::FitEnd;
use crate::net::problem::NetProblem;
use crate::net::tile::Rows;
use crate::report::{Course, HistoryRow, Net};
use rrf_field::net::Shape;
use rrf_lm::{LmConfig, Solver, Step, Termination};

/// A net under way.
#[derive(Clone)]
pub(crate) struct OptimizerRun<'a> {
    cell: &'a Cell<'a>,
    pub shape: Shape,
    /// Which start it came from.
    pub start: u64,
    initialization: Initialization,
    w: Vec<f64>,
    solver: Solver,
    /// Weight decay a residual.
    pub alpha: f64,
    /// Effective parameters.
    gamma: f64,
    /// Residuals of the last phase, 0 before the first; the damping is in their proportion.
    residuals: f64,
    /// The lowest error on the choosing rows of the last phase, and its weights.
    pub error: f64,
    best: Vec<f64>,
    /// Why the last phase ended.
    pub end: FitEnd,
    history: Vec<HistoryRow>,
}

/// How far a run goes at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Phase {
    /// Share of the rows, both of training and of choosing.
    pub share: f64,
    /// Most accepted steps.
    pub steps: usize,
    /// Steps without a better error after which it ends.
    pub patience: usize,
}

/// Accepted steps after which the divisors of validation errors are renewed: at each of the first
/// few, then now and then.
fn renews_evaluator(step: usize) -> bool {
    step <= 4 || step.is_multiple_of(4)
}

/// Accepted steps from one update of the weight decay to the next.
const EVIDENCE: usize = 4;

impl<'a> OptimizerRun<'a> {
    /// From random weights.
    pub fn random(
        cell: &'a Cell,
        shape: &Shape,
        start: u64,
        how: Initialization,
    ) -> OptimizerRun<'a> {
        let w = random_weights(cell, shape, start);
        let run = OptimizerRun::new(cell, shape.clone(), w, how, cell.config.lm);
        OptimizerRun { start, ..run }
    }

    /// From weights given, which `how` may change.
    pub fn new(
        cell: &'a Cell,
        shape: Shape,
        w: Vec<f64>,
        how: Initialization,
        lm: LmConfig,
    ) -> OptimizerRun<'a> {
        OptimizerRun {
            solver: Solver::new(w.len(), lm),
            alpha: cell.config.decay.start(),
            gamma: w.len() as f64,
            residuals: 0.0,
            error: f64::INFINITY,
            best: w.clone(),
            end: Termination::Iterations.into(),
            history: Vec::new(),
            initialization: how,
            start: 0,
            cell,
            shape,
            w,
        }
    }

    /// A phase from the best weights on.
    pub fn run(&mut self, phase: Phase) {
        let cell = self.cell;
        let rows = (cell.train.len() as f64 * phase.share).ceil() as usize;
        let part = cell.train.first(rows);
        let residuals = part.residuals().max(1);
        let mut problem = NetProblem::new(&self.shape, part, residuals, cell.loss)
            .exponential(cell.config.exponential)
            .precision(cell.config.precision);
        let mut evaluator = Evaluator::choosing(cell, &self.shape, phase.share);
        let before = std::mem::replace(&mut self.residuals, residuals as f64);
        if before == 0.0 {
            let alpha = self.alpha * self.residuals;
            let how = self.initialization;
            how.apply(cell, &self.shape, &mut problem, rows, alpha, &mut self.best);
        } else {
            self.solver.rescale_damping(self.residuals / before);
        }
        self.w.clone_from(&self.best);
        self.error = evaluator.error(&self.best).square;
        self.end = self.take_steps(&mut problem, &mut evaluator, phase);
    }

    fn take_steps(
        &mut self,
        problem: &mut NetProblem<impl Rows>,
        evaluator: &mut Evaluator,
        phase: Phase,
    ) -> FitEnd {
        let config = self.cell.config;
        let mut since_best = 0;
        for taken in 1..=phase.steps {
            if self.cell.is_halted() {
                break;
            }
            let alpha = self.alpha * self.residuals;
            let step = match self.solver.step(problem, &mut self.w, alpha) {
                Ok(step) => step,
                Err(termination) => return termination.into(),
            };
            if renews_evaluator(taken) {
                evaluator.renew(&self.best, problem.target_share());
                self.error = evaluator.error(&self.best).square;
            }
            let error = evaluator.error(&self.w).square;
            self.record(&step, error);
            since_best += 1;
            if error < self.error || !self.error.is_finite() {
                self.error = error;
                self.best.clone_from(&self.w);
                since_best = 0;
            }
            if since_best >= phase.patience {
                return FitEnd::Validation;
            }
            if step.before - step.after <= config.lm.cost * step.before {
                return Termination::Cost.into();
            }
            if let (Decay::Evidence(_), 0) = (config.decay, taken % EVIDENCE) {
                self.decay_by_evidence(step.data);
            }
        }
        Termination::Iterations.into()
    }

    fn record(&mut self, step: &Step, validation: f64) {
        self.history.push(HistoryRow {
            residuals: self.residuals as usize,
            cost: step.data / self.residuals,
            validation,
            damping: self.solver.damping(),
            gain: step.gain,
        });
    }

    fn decay_by_evidence(&mut self, data: f64) {
        let (n, alpha) = (self.residuals, self.alpha * self.residuals);
        if let Some(gamma) = self.solver.effective_parameters(alpha) {
            let overcount = self.cell.noise.overcount;
            self.alpha = evidence::decay(gamma, &self.w, data, n, overcount) / n;
            self.gamma = gamma;
        }
    }

    /// The net of the best weights, and how the run came to it.
    pub fn finish(self) -> (Net, Course) {
        let net = Net {
            shape: self.shape,
            weights: self.best,
            error: self.error,
            alpha: self.alpha,
        };
        let course = Course {
            end: self.end,
            damping: self.solver.damping(),
            alpha: self.alpha,
            effective_parameters: self.gamma,
            history: self.history,
        };
        (net, course)
    }
}
