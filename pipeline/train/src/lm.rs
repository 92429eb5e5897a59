//! Levenberg-Marquardt steps on the normal equations of any sum of squares.
//!
//! Levenberg 1944; Marquardt 1963; Hagan, Menhaj 1994 (for nets); Moré 1978 (scaling);
//! Nielsen 1999, Madsen, Nielsen, Tingleff 2004 (damping by the gain ratio);
//! Transtrum, Sethna 2012 (geodesic acceleration). Matrices can serve several steps: `conjugate.rs`.
//!
//! Minimised is F(w) = D(w) + α‖w‖², D = Σ s² r². With A = JᵀWJ and g = JᵀWr + α w the step
//! solves (A + α I + μ S) δ = −g and the model promises to lower F by δᵀ(μ S δ − g).

use crate::blocks::Normal;
use crate::levenberg::squared;
pub use crate::levenberg::{Levenberg, Step};
use serde::{Deserialize, Serialize};

/// A sum of squares D(w) = Σ s² r(w)², with derivatives.
pub trait Problem {
    /// How many parameters.
    fn parameters(&self) -> usize;

    /// D(w) under the weights s that the last [`Problem::linearise`] fixed.
    fn cost(&mut self, w: &[f64]) -> f64;

    /// Fixes the weights s at w where they depend on it, fills JᵀWJ and JᵀWr, returns D(w).
    fn linearise(&mut self, w: &[f64], normal: &mut Normal) -> f64;

    /// [`Problem::linearise`] without the matrix: fills JᵀWr alone, returns D(w), and prepares
    /// [`Problem::product`]; none where not supported.
    fn gradient(&mut self, _w: &[f64], _out: &mut [f64]) -> Option<f64> {
        None
    }

    /// JᵀWJ v at the weights of the last [`Problem::gradient`] into `out`; false where not
    /// supported.
    fn product(&mut self, _v: &[f64], _out: &mut [f64]) -> bool {
        false
    }

    /// JᵀW r'' into `out`, r'' the second derivative of r along v; false where not supported.
    fn curvature(&mut self, _w: &[f64], _v: &[f64], _out: &mut [f64]) -> bool {
        false
    }
}

/// The matrix S that the damping multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Scaling {
    /// S = I.
    Identity,
    /// S = the largest diagonal of A seen so far (Moré 1978).
    More,
    /// S = diagonal of A, at least `floor` times its largest entry.
    Clamped {
        /// Smallest share of the largest entry.
        floor: f64,
    },
    /// S = diagonal of A (Marquardt 1963). A saturated unit has a zero diagonal and thus no
    /// damping: kept to show that.
    Marquardt,
}

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stop {
    /// No row to train on.
    NoRows,
    /// The target, or every input, is constant: the model is a constant.
    Constant,
    /// The least squares were solved in one go: no net.
    Solved,
    /// The gradient vanished.
    Gradient,
    /// The step became smaller than the parameters can show.
    Step,
    /// The cost stopped falling.
    Cost,
    /// Validation has not improved for the set number of iterations.
    Validation,
    /// The error sought has been reached.
    Target,
    /// The set number of iterations is used up.
    Iterations,
    /// No damping up to the largest gave a lower cost.
    Damping,
    /// The cost at the start is not finite.
    NotFinite,
}

impl Stop {
    /// As the metrics table writes it.
    pub fn name(self) -> &'static str {
        match self {
            Stop::NoRows => "no rows",
            Stop::Constant => "constant",
            Stop::Solved => "solved",
            Stop::Gradient => "gradient",
            Stop::Step => "step",
            Stop::Cost => "cost",
            Stop::Validation => "validation",
            Stop::Target => "target",
            Stop::Iterations => "iterations",
            Stop::Damping => "damping",
            Stop::NotFinite => "not finite",
        }
    }
}

/// How to step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LmConfig {
    /// First damping, as a share of the largest diagonal of S⁻¹A.
    pub tau: f64,
    /// Damping beyond which the fit gives up, as a multiple of the same.
    pub damping_max: f64,
    /// The matrix that the damping multiplies.
    pub scaling: Scaling,
    /// Largest ratio of acceleration to velocity, 2‖a‖/‖v‖ ≤ this; 0 turns acceleration off.
    pub acceleration: f64,
    /// Steps taken with one matrix JᵀWJ: all but the first of them solve for the step by
    /// conjugate gradients with the first one's factor as preconditioner. 1 forms it anew for
    /// each.
    #[serde(default = "one")]
    pub reuse: usize,
    /// Iterations of the conjugate gradients.
    #[serde(default = "three")]
    pub inner: usize,
    /// Stop where ‖g‖∞ is below this times the larger of 1 and F.
    pub gradient: f64,
    /// Stop where ‖δ‖ ≤ this (‖w‖ + this).
    pub step: f64,
    /// Stop where F falls by less than this share.
    pub cost: f64,
}

fn one() -> usize {
    1
}

fn three() -> usize {
    3
}

impl Default for LmConfig {
    fn default() -> LmConfig {
        LmConfig {
            tau: 1e-3,
            damping_max: 1e12,
            scaling: Scaling::Identity,
            acceleration: 0.0,
            reuse: one(),
            inner: three(),
            gradient: 1e-12,
            step: 1e-12,
            cost: 1e-10,
        }
    }
}

impl LmConfig {
    /// For smooth problems from poor starts: starts carefully, bends its steps along the valley
    /// floor, stops only where f64 sees no further progress.
    pub fn exact() -> LmConfig {
        LmConfig {
            tau: 1.0,
            acceleration: 0.75,
            damping_max: 1e30,
            gradient: 0.0,
            step: 1e-16,
            cost: 1e-16,
            ..LmConfig::default()
        }
    }
}

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Why.
    pub stop: Stop,
    /// Accepted steps.
    pub iterations: usize,
    /// F at the end.
    pub cost: f64,
}

/// Steps from `w` until a stop, at most `most`, then polishes: as near to a minimum of F as
/// f64 allows.
pub fn minimise(
    problem: &mut impl Problem,
    w: &mut [f64],
    alpha: f64,
    config: LmConfig,
    most: usize,
) -> Outcome {
    let mut lm = Levenberg::new(w.len(), config);
    let (mut stop, mut iterations) = (Stop::Iterations, 0);
    while iterations < most {
        match lm.step(problem, w, alpha) {
            Ok(step) => {
                iterations += 1;
                if step.before - step.after <= config.cost * step.before {
                    stop = Stop::Cost;
                    break;
                }
            }
            Err(reason) => {
                stop = reason;
                break;
            }
        }
    }
    iterations += lm.polish(problem, w, alpha);
    Outcome {
        stop,
        iterations,
        cost: problem.cost(w) + alpha * squared(w),
    }
}
