//! The damped step and what goes from one to the next.

use crate::blocks::Normal;
use crate::conjugate::Recycled;
use crate::evidence::{self, Evidence};
use crate::linalg::Cholesky;
use crate::lm::{LmConfig, Problem, Scaling, Stop};

/// What an accepted step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// F before, under the weights fixed for this step.
    pub before: f64,
    /// F after, under the same weights.
    pub after: f64,
    /// D after.
    pub data: f64,
    /// Gain ratio.
    pub gain: f64,
    /// Damping tried before one was accepted.
    pub tries: usize,
}

/// The state that goes from one step to the next.
#[derive(Clone, Debug)]
pub struct Levenberg {
    /// How to step.
    pub config: LmConfig,
    /// Damping μ; set at the first step.
    pub mu: f64,
    /// Normal equations at the last linearisation.
    pub normal: Normal,
    nu: f64,
    largest: f64,
    pub(crate) scale: Vec<f64>,
    pub(crate) factor: Cholesky,
    pub(crate) recycled: Recycled,
}

impl Levenberg {
    /// Before the first step of a problem with `n` parameters.
    pub fn new(n: usize, config: LmConfig) -> Levenberg {
        Levenberg {
            config,
            mu: 0.0,
            normal: Normal::zeros(n),
            nu: 2.0,
            largest: 0.0,
            scale: vec![0.0; n],
            factor: Cholesky::default(),
            recycled: Recycled::default(),
        }
    }

    /// One accepted step from `w`, which it moves; or the reason why there is none.
    pub fn step(
        &mut self,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
    ) -> Result<Step, Stop> {
        if let Some(step) = self.between(problem, w, alpha) {
            return Ok(step);
        }
        let data = problem.linearise(w, &mut self.normal);
        let before = data + alpha * squared(w);
        if !before.is_finite() {
            return Err(Stop::NotFinite);
        }
        let g: Vec<f64> = (self.normal.gradient.iter().zip(w.iter()))
            .map(|(g, w)| g + alpha * w)
            .collect();
        if largest(&g) <= self.config.gradient * before.max(f64::MIN_POSITIVE) {
            return Err(Stop::Gradient);
        }
        self.rescale();
        for tries in 1.. {
            if self.mu > self.config.damping_max * self.largest {
                return Err(Stop::Damping);
            }
            let Some((delta, promised)) = self.propose(problem, w, &g, alpha) else {
                self.raise();
                continue;
            };
            if squared(&delta).sqrt() <= self.config.step * (squared(w).sqrt() + self.config.step) {
                return Err(Stop::Step);
            }
            let trial: Vec<f64> = w.iter().zip(&delta).map(|(w, d)| w + d).collect();
            let data = problem.cost(&trial);
            let after = data + alpha * squared(&trial);
            let gain = (before - after) / promised;
            if !(after.is_finite() && after < before && gain > 0.0) {
                self.raise();
                continue;
            }
            w.copy_from_slice(&trial);
            self.lower(gain, FALL);
            self.recycled.begin();
            return Ok(Step {
                before,
                after,
                data,
                gain,
                tries,
            });
        }
        Err(Stop::Damping)
    }

    /// Before another problem of the same size: a damping that gave up on the last one is taken
    /// back to where it started.
    pub fn settle(&mut self) {
        self.mu = self.mu.min(self.config.tau * self.largest);
        self.nu = 2.0;
        self.recycled.forget();
    }

    /// Follows a change in the number of residuals.
    pub fn rescale_damping(&mut self, times: f64) {
        self.mu *= times;
        self.largest *= times;
        self.recycled.forget();
    }

    /// Weight decay by the evidence, from the last normal equations that were made.
    pub fn evidence(
        &mut self,
        alpha: f64,
        w: &[f64],
        data: f64,
        residuals: f64,
        overcount: f64,
    ) -> Option<Evidence> {
        self.recycled.forget();
        let (factor, normal) = (&mut self.factor, &self.normal);
        evidence::update(factor, normal, alpha, w, data, residuals, overcount).ok()
    }

    /// Refreshes S, and sets μ at the first step.
    fn rescale(&mut self) {
        let n = self.normal.n;
        let diagonal = |i: usize| self.normal.matrix[i * n + i];
        let top = (0..n).map(diagonal).fold(0.0, f64::max);
        for i in 0..n {
            let d = diagonal(i);
            self.scale[i] = match self.config.scaling {
                Scaling::Identity => 1.0,
                Scaling::More => self.scale[i].max(d),
                Scaling::Clamped { floor } => d.max(floor * top),
                Scaling::Marquardt => d,
            };
        }
        if self.largest == 0.0 {
            self.largest = match self.config.scaling {
                Scaling::Identity => top.max(f64::MIN_POSITIVE),
                _ => 1.0,
            };
            self.mu = self.config.tau * self.largest;
        }
        if self.config.scaling == Scaling::More {
            // A column that has been zero so far must still be damped.
            for s in &mut self.scale {
                if *s == 0.0 {
                    *s = 1.0;
                }
            }
        }
    }

    /// The step for the damping in force and the fall in F that the model promises.
    fn propose(
        &mut self,
        problem: &mut impl Problem,
        w: &[f64],
        g: &[f64],
        alpha: f64,
    ) -> Option<(Vec<f64>, f64)> {
        let add: Vec<f64> = self.scale.iter().map(|s| alpha + self.mu * s).collect();
        self.factor.factor(&self.normal.matrix, &add).ok()?;
        self.recycled.added = add;
        let mut v: Vec<f64> = g.iter().map(|g| -g).collect();
        self.factor.solve(&mut v).ok()?;
        let promised: f64 = (v.iter().zip(g).zip(&self.scale))
            .map(|((v, g), s)| v * (self.mu * s * v - g))
            .sum();
        if promised <= 0.0 || !promised.is_finite() {
            return None;
        }
        if self.config.acceleration > 0.0 {
            self.accelerate(problem, w, &mut v)?;
        }
        Some((v, promised))
    }

    /// v ← v + a / 2 where the second-order correction a is small enough, else no step.
    fn accelerate(&self, problem: &mut impl Problem, w: &[f64], v: &mut [f64]) -> Option<()> {
        let mut a = vec![0.0; v.len()];
        if !problem.curvature(w, v, &mut a) {
            return Some(());
        }
        a.iter_mut().for_each(|a| *a = -*a);
        self.factor.solve(&mut a).ok()?;
        if 2.0 * squared(&a).sqrt() > self.config.acceleration * squared(v).sqrt() {
            return None;
        }
        for (v, a) in v.iter_mut().zip(&a) {
            *v += 0.5 * a;
        }
        Some(())
    }

    pub(crate) fn raise(&mut self) {
        self.mu = (self.mu * self.nu).max(f64::MIN_POSITIVE);
        self.nu *= 2.0;
    }

    pub(crate) fn lower(&mut self, gain: f64, least: f64) {
        self.mu *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(least);
        self.nu = 2.0;
    }
}

/// Least factor of the damping from one step to the next.
const FALL: f64 = 1.0 / 3.0;

/// Σ w².
pub(crate) fn squared(w: &[f64]) -> f64 {
    w.iter().map(|w| w * w).sum()
}

fn largest(w: &[f64]) -> f64 {
    w.iter().fold(0.0, |m, w| m.max(w.abs()))
}

impl Levenberg {
    /// Gauss-Newton steps for as long as the fall that the model promises, δᵀA δ, gets smaller.
    ///
    /// Near a minimum F is flat: differences below 1e-16 F cannot be seen, although they stand
    /// for relative changes of 1e-8 in w. The gradient still shows them. Returns the steps kept.
    pub(crate) fn polish(
        &mut self,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
    ) -> usize {
        self.recycled.forget();
        let mut promised = f64::INFINITY;
        for kept in 0..POLISH {
            let cost = problem.linearise(w, &mut self.normal) + alpha * squared(w);
            let mut delta: Vec<f64> = (self.normal.gradient.iter().zip(w.iter()))
                .map(|(g, w)| -(g + alpha * w))
                .collect();
            let g = delta.clone();
            let n = w.len();
            // As little damping as keeps a singular matrix positive definite.
            let add: Vec<f64> = (0..n)
                .map(|i| alpha + 4.0 * f64::EPSILON * self.normal.matrix[i * n + i])
                .collect();
            let solved = (self.factor.factor(&self.normal.matrix, &add))
                .and_then(|()| self.factor.solve(&mut delta));
            let fall: f64 = delta.iter().zip(&g).map(|(d, g)| d * g).sum();
            let trial: Vec<f64> = w.iter().zip(&delta).map(|(w, d)| w + d).collect();
            let flat = problem.cost(&trial) + alpha * squared(&trial) <= cost * (1.0 + 1e-9);
            if solved.is_err() || !flat || fall.is_nan() || fall >= 0.5 * promised {
                return kept;
            }
            w.copy_from_slice(&trial);
            promised = fall;
        }
        POLISH
    }
}

/// Most Gauss-Newton steps of a polish.
const POLISH: usize = 30;
