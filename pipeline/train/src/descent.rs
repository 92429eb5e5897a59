//! One net's way down: steps on a share of the rows, the best weights kept.

use crate::cell::Cell;
use crate::config::Decay;
use crate::evidence;
use crate::fit::HistoryRow;
use crate::judge::Judge;
use crate::end::FitEnd;
use crate::logarithm::Logarithms;
use crate::problem::{Loss, NetProblem};
use crate::tile::Rows;
use rrf_field::net::Shape;
use rrf_lm::{LmConfig, Solver, Step, Termination};

/// Accepted steps after which the luminances that validation errors are divided by are renewed:
/// at each of the first few, then now and then.
fn renews_judge(step: usize) -> bool {
    step <= 4 || step.is_multiple_of(4)
}

/// Accepted steps from one update of the weight decay to the next.
const EVIDENCE: usize = 4;

/// What the first leg starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begin {
    /// Random hidden units and the output layer that is best for them; of exponents the mean.
    Mean,
    /// A few steps towards the logarithm, for exponents.
    Logarithm,
    /// The weights of a net that was fitted before.
    Fitted,
}

/// Steps of [`Begin::Logarithm`].
const FIRST_STEPS: usize = 10;

/// A net under way.
#[derive(Clone)]
pub(crate) struct Descent<'a> {
    cell: &'a Cell<'a>,
    pub shape: Shape,
    /// Which start it came from.
    pub start: u64,
    pub(crate) w: Vec<f64>,
    begin: Begin,
    pub(crate) lm: Solver,
    /// Weight decay a residual.
    pub alpha: f64,
    /// Effective parameters.
    pub gamma: f64,
    /// Residuals of the last run; the damping is in their proportion.
    pub(crate) residuals: f64,
    /// The lowest error on the choosing rows of the last run, and its weights.
    pub error: f64,
    pub best: Vec<f64>,
    pub history: Vec<HistoryRow>,
}

/// How far a run goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leg {
    /// Share of the rows, both of training and of choosing.
    pub share: f64,
    /// Most accepted steps.
    pub steps: usize,
    /// Steps without a better error after which it ends.
    pub patience: usize,
}

impl<'a> Descent<'a> {
    pub fn new(cell: &'a Cell, shape: Shape, start: u64) -> Descent<'a> {
        let w = cell.first_weights(&shape, start);
        Descent::from_weights(cell, shape, start, w)
    }

    pub fn from_weights(cell: &'a Cell, shape: Shape, start: u64, w: Vec<f64>) -> Descent<'a> {
        Descent::stepping(cell, shape, start, w, cell.config.lm)
    }

    /// The same with steps of its own kind.
    pub fn stepping(
        cell: &'a Cell,
        shape: Shape,
        start: u64,
        w: Vec<f64>,
        config: LmConfig,
    ) -> Descent<'a> {
        Descent {
            lm: Solver::new(w.len(), config),
            alpha: cell.config.decay.start(),
            gamma: w.len() as f64,
            residuals: 0.0,
            error: f64::INFINITY,
            best: w.clone(),
            history: Vec::new(),
            begin: Begin::Mean,
            cell,
            shape,
            start,
            w,
        }
    }

    /// From weights that are those of a fitted net.
    pub fn going_on(cell: &'a Cell, shape: Shape, w: Vec<f64>) -> Descent<'a> {
        Descent::from_weights(cell, shape, 0, w).beginning(Begin::Fitted)
    }

    /// The same with another beginning.
    pub fn beginning(self, begin: Begin) -> Descent<'a> {
        Descent { begin, ..self }
    }

    /// Damping at the end.
    pub fn mu(&self) -> f64 {
        self.lm.damping()
    }

    /// Goes on from the best weights.
    pub fn run(&mut self, leg: Leg) -> FitEnd {
        let cell = self.cell;
        let rows = (cell.train.len() as f64 * leg.share).ceil() as usize;
        let part = cell.train.first(rows);
        let residuals = part.residuals().max(1);
        let mut problem = NetProblem::new(&self.shape, part, residuals, cell.loss)
            .exponential(cell.config.exponential)
            .precision(cell.config.precision);
        let mut judge = Judge::choosing(cell, &self.shape, leg.share);
        self.w.clone_from(&self.best);
        let first_run = self.residuals == 0.0;
        if first_run && self.begin != Begin::Fitted {
            self.prepare_start(&mut problem, rows);
            self.best.clone_from(&self.w);
        } else if !first_run {
            self.lm.rescale_damping(residuals as f64 / self.residuals);
        }
        self.residuals = residuals as f64;
        self.error = judge.error(&self.best).square;
        self.descend(&mut problem, &mut judge, leg)
    }

    /// Turns random first weights into what the first leg starts from.
    fn prepare_start(&mut self, problem: &mut NetProblem<impl Rows>, rows: usize) {
        let (cell, residuals) = (self.cell, problem.residuals());
        let alpha = self.alpha * residuals;
        // Where there is no answer the output layer stays at zero: the mean, a valid start.
        self.w[problem.output_layer()].fill(0.0);
        if self.begin != Begin::Logarithm {
            problem.project(&mut self.w, alpha);
            return;
        }
        let (rows, floor) = (cell.train.first(rows), cell.floor);
        let rows = Logarithms { rows, floor };
        let mut start = NetProblem::new(&self.shape, rows, residuals as usize, Loss::Absolute)
            .precision(cell.config.precision);
        start.project(&mut self.w, alpha);
        let mut lm = Solver::new(self.w.len(), cell.config.lm);
        for _ in 0..FIRST_STEPS {
            if lm.step(&mut start, &mut self.w, alpha).is_err() {
                break;
            }
        }
    }

    fn descend(
        &mut self,
        problem: &mut NetProblem<impl Rows>,
        judge: &mut Judge,
        leg: Leg,
    ) -> FitEnd {
        let mut since_best = 0;
        for taken in 1..=leg.steps {
            let alpha = self.alpha * self.residuals;
            let step = match self.lm.step(problem, &mut self.w, alpha) {
                Ok(step) => step,
                Err(termination) => return termination.into(),
            };
            if renews_judge(taken) {
                judge.renew(&self.best, problem.target_share());
                self.error = judge.error(&self.best).square;
            }
            let error = judge.error(&self.w).square;
            self.record(&step, error);
            since_best += 1;
            if error < self.error || !self.error.is_finite() {
                self.error = error;
                self.best.clone_from(&self.w);
                since_best = 0;
            }
            if since_best >= leg.patience {
                return FitEnd::Validation;
            }
            if step.before - step.after <= self.cell.config.lm.cost * step.before {
                return Termination::Cost.into();
            }
            if let (Decay::Evidence(_), 0) = (self.cell.config.decay, taken % EVIDENCE) {
                self.decay_by_evidence(step.data);
            }
        }
        Termination::Iterations.into()
    }

    fn record(&mut self, step: &Step, validation: f64) {
        self.history.push(HistoryRow {
            iteration: self.history.len() + 1,
            residuals: self.residuals as usize,
            cost: step.data / self.residuals,
            validation,
            mu: self.lm.damping(),
            gain: step.gain,
        });
    }

    fn decay_by_evidence(&mut self, data: f64) {
        let alpha = self.alpha * self.residuals;
        if let Some(gamma) = self.lm.effective_parameters(alpha) {
            let overcount = self.cell.noise.overcount;
            self.alpha = evidence::decay(gamma, &self.w, data, self.residuals, overcount) / self.residuals;
            self.gamma = gamma;
        }
    }
}
