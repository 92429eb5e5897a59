//! How to step.

use serde::{Deserialize, Serialize};

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
    /// S = diagonal of A (Marquardt 1963). A parameter that no residual depends on has a zero
    /// there and thus no damping: kept to show that.
    Marquardt,
}

/// How to step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LmConfig {
    /// First damping, as a share of the largest diagonal of S⁻¹A.
    pub tau: f64,
    /// Damping beyond which the solver gives up, as a multiple of the same.
    pub damping_max: f64,
    /// The matrix that the damping multiplies.
    pub scaling: Scaling,
    /// Always false and read by nothing: a key of the settings that fits of version 0.6 are hashed
    /// with. It goes when the version rises.
    pub separable: bool,
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
    /// Stop where ‖g‖∞ is below this times F.
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
            separable: false,
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
