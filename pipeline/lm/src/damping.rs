//! The damping μ S and how it follows the gain ratio (Nielsen 1999).

use crate::config::{LmConfig, Scaling};
use crate::problem::NormalEquations;

/// μ and S from one step to the next.
#[derive(Clone, Debug)]
pub(crate) struct Damping {
    /// μ; set at the first step.
    pub mu: f64,
    /// What the next failure multiplies μ by.
    nu: f64,
    /// Largest diagonal of S⁻¹A at the first step; 0 before.
    largest: f64,
    /// The diagonal of S.
    pub scale: Vec<f64>,
}

impl Damping {
    /// Of `n` parameters, before the first step.
    pub fn new(n: usize) -> Damping {
        Damping {
            mu: 0.0,
            nu: 2.0,
            largest: 0.0,
            scale: vec![0.0; n],
        }
    }

    /// Refreshes S, and sets μ at the first step.
    pub fn rescale(&mut self, normal: &NormalEquations, config: &LmConfig) {
        let n = normal.n;
        let top = (0..n).map(|i| normal.diagonal(i)).fold(0.0, f64::max);
        for i in 0..n {
            let d = normal.diagonal(i);
            self.scale[i] = match config.scaling {
                Scaling::Identity => 1.0,
                Scaling::More => self.scale[i].max(d),
                Scaling::Clamped { floor } => d.max(floor * top),
                Scaling::Marquardt => d,
            };
        }
        if self.largest == 0.0 {
            self.largest = match config.scaling {
                Scaling::Identity => top.max(f64::MIN_POSITIVE),
                _ => 1.0,
            };
            self.mu = config.tau * self.largest;
        }
        if config.scaling == Scaling::More {
            // A column that has been zero so far must still be damped.
            for s in &mut self.scale {
                if *s == 0.0 {
                    *s = 1.0;
                }
            }
        }
    }

    /// What is added to the diagonal of A: α + μ S.
    pub fn added(&self, alpha: f64) -> Vec<f64> {
        self.scale.iter().map(|s| alpha + self.mu * s).collect()
    }

    /// Whether μ is beyond the largest that is allowed.
    pub fn is_exhausted(&self, config: &LmConfig) -> bool {
        self.mu > config.damping_max * self.largest
    }

    /// After a step that failed.
    pub fn raise(&mut self) {
        self.mu = (self.mu * self.nu).max(f64::MIN_POSITIVE);
        self.nu *= 2.0;
    }

    /// After a step that was taken; `least` is the least factor.
    pub fn lower(&mut self, gain: f64, least: f64) {
        self.mu *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(least);
        self.nu = 2.0;
    }

    /// Back to no more than where it started.
    pub fn settle(&mut self, config: &LmConfig) {
        self.mu = self.mu.min(config.tau * self.largest);
        self.nu = 2.0;
    }

    /// Follows a change in the number of residuals.
    pub fn multiply(&mut self, times: f64) {
        self.mu *= times;
        self.largest *= times;
    }
}
