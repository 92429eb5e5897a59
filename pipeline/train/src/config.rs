//! What a fit is asked for.

use crate::error::TrainError;
use crate::lm::LmConfig;
use serde::{Deserialize, Serialize};

/// Weight decay α a residual: α‖w‖² times the number of residuals is added to the loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Decay {
    /// α stays as given.
    Fixed(f64),
    /// α starts as given and follows the evidence (see [`crate::evidence`]).
    Evidence(f64),
}

impl Decay {
    /// α at the start.
    pub fn start(self) -> f64 {
        match self {
            Decay::Fixed(alpha) | Decay::Evidence(alpha) => alpha,
        }
    }
}

/// How cells are fitted; written whole into a run's manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainConfig {
    /// Seed of all first weights.
    pub seed: u64,
    /// Inputs to consider, as names in `rrf_field::model::INPUTS`; those that do not vary in a
    /// cell are dropped.
    pub inputs: Vec<String>,
    /// Units of the hidden layers, inputs side first; empty: a linear model.
    pub hidden: Vec<usize>,
    /// Divide the target by the base colour (Lambert cells: outgoing radiance is proportional
    /// to it). Channels of base colour 0 are left out of the loss.
    pub divide_base: bool,
    /// Relative loss (see [`crate::problem::Loss`]); otherwise squared radiance.
    pub relative: bool,
    /// ε of the relative loss and error, as a share of the mean luminance.
    pub epsilon: f64,
    /// Mean luminance of the whole data set, W·sr⁻¹·m⁻²; without it the cell's own.
    pub mean_luminance: Option<f32>,
    /// Weight decay.
    pub decay: Decay,
    /// Nets that start from different first weights; a power of two. The better half goes on at
    /// each rung.
    pub starts: usize,
    /// Legs on a part of the rows before the one on all: the last on half of them, the one
    /// before on a quarter, and so on.
    pub rungs: usize,
    /// Steps of each of these.
    pub rung_steps: usize,
    /// Most steps on all rows.
    pub iterations: usize,
    /// Steps without a better validation error after which a fit stops.
    pub patience: usize,
    /// How to step.
    pub lm: LmConfig,
}

impl Default for TrainConfig {
    fn default() -> TrainConfig {
        let inputs = [
            "px",
            "py",
            "pz",
            "nx",
            "ny",
            "nz",
            "vx",
            "vy",
            "vz",
            "lx",
            "ly",
            "lz",
            "dx",
            "dy",
            "dz",
            "inv_distance",
        ];
        TrainConfig {
            seed: 1,
            inputs: inputs.map(String::from).to_vec(),
            hidden: vec![20, 10],
            divide_base: false,
            relative: true,
            epsilon: 0.05,
            mean_luminance: None,
            decay: Decay::Evidence(1e-6),
            starts: 1,
            rungs: 0,
            rung_steps: 5,
            iterations: 60,
            patience: 6,
            lm: LmConfig::default(),
        }
    }
}

impl TrainConfig {
    /// Every number within its range.
    pub fn check(&self) -> Result<(), TrainError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let checks = [
            ("epsilon", self.epsilon, positive(self.epsilon), "positive"),
            (
                "mean_luminance",
                self.mean_luminance.map_or(0.0, f64::from),
                self.mean_luminance
                    .is_none_or(|m| m >= 0.0 && m.is_finite()),
                "at least 0",
            ),
            (
                "decay",
                self.decay.start(),
                self.decay.start() >= 0.0 && self.decay.start().is_finite(),
                "at least 0",
            ),
            ("lm.tau", self.lm.tau, positive(self.lm.tau), "positive"),
        ];
        for (name, value, fine, range) in checks {
            if !fine {
                let value = value.to_string();
                return Err(TrainError::Config { name, value, range });
            }
        }
        if self.hidden.len() > 2 || self.hidden.contains(&0) {
            return Err(TrainError::Config {
                name: "hidden",
                value: format!("{:?}", self.hidden),
                range: "at most two layers of at least one unit",
            });
        }
        Ok(())
    }
}
