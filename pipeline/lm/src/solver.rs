//! One damped step after another.

use crate::config::LmConfig;
use crate::conjugate::Preconditioner;
use crate::damping::Damping;
use crate::linalg::Cholesky;
use crate::problem::{NormalEquations, Problem};
use crate::termination::Termination;
use crate::vector::{largest, negated, squared, sum};

/// What an accepted step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// F before, under the weights fixed for this step.
    pub before: f64,
    /// F after, under the same weights.
    pub after: f64,
    /// D after.
    pub data: f64,
    /// Gain ratio: actual over promised fall.
    pub gain: f64,
}

/// A step to be tried, and the fall in F that the model promises.
struct Proposal {
    delta: Vec<f64>,
    promised: f64,
}

/// The state that goes from one step to the next.
#[derive(Clone, Debug)]
pub struct Solver {
    config: LmConfig,
    /// At the last linearisation.
    normal: NormalEquations,
    damping: Damping,
    preconditioner: Preconditioner,
    /// Steps taken with the factor; 0 where there is none to use.
    kept: usize,
}

/// Least factor of the damping from one step to the next.
const FALL: f64 = 1.0 / 3.0;

/// The same after a step without a new matrix: too few iterations damp as well, so that their
/// gain says little about what a full solution can do with less.
const FALL_BETWEEN: f64 = 0.6;

impl Solver {
    /// Before the first step of a problem with `n` parameters.
    pub fn new(n: usize, config: LmConfig) -> Solver {
        Solver {
            config,
            normal: NormalEquations::zeros(n),
            damping: Damping::new(n),
            preconditioner: Preconditioner::default(),
            kept: 0,
        }
    }

    /// Damping μ; 0 before the first step.
    pub fn damping(&self) -> f64 {
        self.damping.mu
    }

    /// The normal equations at the last linearisation.
    pub fn normal_equations(&self) -> &NormalEquations {
        &self.normal
    }

    /// One accepted step from `w`, which it moves; or the reason why there is none.
    ///
    /// # Errors
    /// The reason why there is none; `w` is then untouched.
    pub fn step(
        &mut self,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
    ) -> Result<Step, Termination> {
        if let Some(step) = self.step_between(problem, w, alpha) {
            return Ok(step);
        }
        let before = problem.linearise(w, &mut self.normal) + alpha * squared(w);
        if !before.is_finite() {
            return Err(Termination::NotFinite);
        }
        let g = self.gradient(w, alpha);
        if largest(&g) <= self.config.gradient * before.max(f64::MIN_POSITIVE) {
            return Err(Termination::Gradient);
        }
        self.damping.rescale(&self.normal, &self.config);
        while !self.damping.is_exhausted(&self.config) {
            let Some(proposal) = self.propose(problem, w, &g, alpha) else {
                self.damping.raise();
                continue;
            };
            let length = squared(&proposal.delta).sqrt();
            if length <= self.config.step * (squared(w).sqrt() + self.config.step) {
                return Err(Termination::Step);
            }
            if let Some(step) = self.take(&proposal, problem, w, alpha, before, FALL) {
                self.preconditioner.renew();
                self.kept = 1;
                return Ok(step);
            }
        }
        Err(Termination::Damping)
    }

    /// A step from `w` without a new matrix; none where one is due, or where the step would not
    /// lower F. The residual ϱ of the iterations is in the promised fall, δᵀ(μSδ − g + ϱ).
    fn step_between(
        &mut self,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
    ) -> Option<Step> {
        // Whatever goes wrong below calls for a new matrix.
        let kept = std::mem::take(&mut self.kept);
        if kept == 0 || kept >= self.config.reuse {
            return None;
        }
        let before = problem.gradient(w, &mut self.normal.gradient)? + alpha * squared(w);
        let g = self.gradient(w, alpha);
        let added = self.damping.added(alpha);
        let solution = self
            .preconditioner
            .solve(problem, &g, &added, self.config.inner)?;
        let (mu, scale) = (self.damping.mu, &self.damping.scale);
        let promised: f64 = (solution.delta.iter().zip(&g))
            .zip(scale)
            .zip(&solution.residual)
            .map(|(((d, g), s), r)| d * (mu * s * d - g + r))
            .sum();
        if !(promised > 0.0 && promised.is_finite()) {
            return None;
        }
        let proposal = Proposal {
            delta: solution.delta,
            promised,
        };
        let step = self.take(&proposal, problem, w, alpha, before, FALL_BETWEEN)?;
        self.kept = kept + 1;
        Some(step)
    }

    /// Takes a step that lowers F, and the damping down by no more than `fall`; raises the damping
    /// for any other.
    fn take(
        &mut self,
        proposal: &Proposal,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
        before: f64,
        fall: f64,
    ) -> Option<Step> {
        let trial = sum(w, &proposal.delta);
        let data = problem.cost(&trial);
        let after = data + alpha * squared(&trial);
        let gain = (before - after) / proposal.promised;
        if !(after.is_finite() && after < before && gain > 0.0) {
            self.damping.raise();
            return None;
        }
        w.copy_from_slice(&trial);
        self.damping.lower(gain, fall);
        Some(Step {
            before,
            after,
            data,
            gain,
        })
    }

    /// The step for the damping in force; none where its matrix has no factor.
    fn propose(
        &mut self,
        problem: &mut impl Problem,
        w: &[f64],
        g: &[f64],
        alpha: f64,
    ) -> Option<Proposal> {
        let factor = &mut self.preconditioner.factor;
        factor
            .factor(&self.normal.matrix, &self.damping.added(alpha))
            .ok()?;
        let mut delta = negated(g);
        factor.solve(&mut delta).ok()?;
        let mu = self.damping.mu;
        let promised: f64 = (delta.iter().zip(g).zip(&self.damping.scale))
            .map(|((v, g), s)| v * (mu * s * v - g))
            .sum();
        if promised <= 0.0 || !promised.is_finite() {
            return None;
        }
        if self.config.acceleration > 0.0 {
            accelerate(problem, factor, w, &mut delta, self.config.acceleration)?;
        }
        Some(Proposal { delta, promised })
    }

    /// g = JᵀWr + αw at the last linearisation.
    fn gradient(&self, w: &[f64], alpha: f64) -> Vec<f64> {
        (self.normal.gradient.iter().zip(w))
            .map(|(g, w)| g + alpha * w)
            .collect()
    }

    /// Before another problem of the same size: a damping that gave up on the last one is taken
    /// back to where it started.
    pub fn settle(&mut self) {
        self.damping.settle(&self.config);
        self.kept = 0;
    }

    /// Follows a change in the number of residuals.
    pub fn rescale_damping(&mut self, times: f64) {
        self.damping.multiply(times);
        self.kept = 0;
    }

    /// Effective parameters n − α tr (A + αI)⁻¹, from the last matrix that was formed, undamped;
    /// none where A + αI is not positive definite. The next step forms a new matrix.
    pub fn effective_parameters(&mut self, alpha: f64) -> Option<f64> {
        self.kept = 0;
        let n = self.normal.n;
        let factor = &mut self.preconditioner.factor;
        factor.factor(&self.normal.matrix, &vec![alpha; n]).ok()?;
        let inverse = factor.inverse().ok()?;
        let trace: f64 = (0..n).map(|i| inverse[i * n + i]).sum();
        Some((n as f64 - alpha * trace).clamp(0.0, n as f64))
    }
}

/// v ← v + a / 2 where the second-order correction a is small enough, 2‖a‖ ≤ `most` ‖v‖, else no
/// step (Transtrum, Sethna 2012).
fn accelerate(
    problem: &mut impl Problem,
    factor: &Cholesky,
    w: &[f64],
    v: &mut [f64],
    most: f64,
) -> Option<()> {
    let mut a = vec![0.0; v.len()];
    if !problem.curvature(w, v, &mut a) {
        return Some(());
    }
    a.iter_mut().for_each(|a| *a = -*a);
    factor.solve(&mut a).ok()?;
    if 2.0 * squared(&a).sqrt() > most * squared(v).sqrt() {
        return None;
    }
    for (v, a) in v.iter_mut().zip(&a) {
        *v += 0.5 * a;
    }
    Some(())
}
