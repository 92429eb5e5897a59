//! What a fit is asked for.

use crate::error::TrainError;
use crate::net::blocks::Precision;
use rrf_field::inputs::INPUTS;
use rrf_field::model::Kind;
use rrf_lm::LmConfig;
use serde::{Deserialize, Serialize};

/// Weight decay α a residual: α‖w‖² times the number of residuals is added to the loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Decay {
    /// α stays as given.
    Fixed(f64),
    /// α starts as given and follows the evidence (see `fit/evidence.rs`).
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

/// Which nets a cell may get.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Size {
    /// Units of the hidden layers, inputs side first; empty: a linear model.
    Hidden(Vec<usize>),
    /// The first of [`ARCHITECTURES`] whose relative validation error is at most `target`; the best
    /// of them where none is.
    Smallest {
        /// Relative error sought.
        target: f64,
    },
}

/// Hidden layers from small to large.
pub const ARCHITECTURES: [&[usize]; 6] = [&[], &[4], &[8, 4], &[12, 8], &[20, 10], &[32, 16]];

/// How an online mode goes through the rows: once, in the order they come in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Batches {
    /// Rows a batch.
    pub rows: usize,
    /// Most steps on a batch.
    pub steps: usize,
}

/// Which rows a step sees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// All rows of the cell.
    Local,
    /// Batch after batch, each on its own.
    Online(Batches),
    /// Batch after batch, the accumulated JᵀWJ of the earlier ones kept.
    Recursive(Batches),
}

/// How cells are fitted; written whole into a run's manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainConfig {
    /// Seed of all first weights.
    pub seed: u64,
    /// Inputs to consider, as names in `rrf_field::inputs::INPUTS`; those that do not vary in a
    /// cell are dropped.
    pub inputs: Vec<String>,
    /// Cells do without the normal and without the material where the position of a point tells them.
    /// Large cells, of many planes, are better with the normal.
    #[serde(default, rename = "told_by_place")]
    pub drop_redundant: bool,
    /// Nets, or what they are compared with.
    #[serde(default, skip_serializing_if = "Kind::is_net")]
    pub kind: Kind,
    /// Which nets to consider.
    pub size: Size,
    /// Make the net smaller for as long as the validation error stays within this share above that of the
    /// whole one (or below [`Size::Smallest`]'s target): a smaller one of [`ARCHITECTURES`] in place of
    /// [`Size::Hidden`]'s, then inputs and units taken out.
    pub prune: Option<f64>,
    /// Divide the target by the base colour (Lambert cells: outgoing radiance is proportional
    /// to it). Channels of base colour 0 are left out of the loss.
    pub divide_base: bool,
    /// The net's outputs are exponents: y = scale exp(out). Radiance spans orders of magnitude
    /// and is a product of distances, cosines and reflectances; its logarithm is what a small
    /// net fits well. The loss stays in radiance: neither targets nor noise pass a logarithm.
    pub exponential: bool,
    /// Relative loss (see [`crate::net::problem::Loss`]); otherwise squared radiance.
    pub relative: bool,
    /// ε of the relative loss and error, as a share of the mean radiance.
    pub epsilon: f64,
    /// Mean radiance over the channels and the whole data set, W·sr⁻¹·m⁻²; without it the cell's own.
    #[serde(rename = "mean_luminance")]
    pub mean_radiance: Option<f32>,
    /// Which rows a step sees.
    pub mode: Schedule,
    /// Weight decay.
    pub decay: Decay,
    /// Nets that start from different first weights, each initialized in two ways where outputs are
    /// exponents; a fit that goes on from an earlier net is one. The best go on from rung to rung, half
    /// as many at each, one on all rows; without rungs all run to the end.
    pub starts: usize,
    /// Phases on a part of the rows before the one on all: the last on half of them, the one
    /// before on a quarter, and so on.
    pub rungs: usize,
    /// Steps of each of these.
    pub rung_steps: usize,
    /// Most steps on all rows.
    pub iterations: usize,
    /// Steps without a better validation error after which a fit stops.
    pub patience: usize,
    /// The same of a fit that goes on from an earlier net, and will hardly be the last one.
    #[serde(default = "patience_going_on")]
    pub patience_going_on: usize,
    /// In which precision JᵀWJ is multiplied.
    #[serde(default)]
    pub precision: Precision,
    /// How to step.
    pub lm: LmConfig,
}

impl Default for TrainConfig {
    fn default() -> TrainConfig {
        let offered = INPUTS.iter().filter(|input| input.by_default);
        TrainConfig {
            seed: 1,
            inputs: offered.map(|input| input.name.into()).collect(),
            drop_redundant: false,
            kind: Kind::Net,
            size: Size::Hidden(vec![20, 10]),
            prune: None,
            divide_base: false,
            exponential: false,
            relative: true,
            epsilon: 0.05,
            mean_radiance: None,
            mode: Schedule::Local,
            decay: Decay::Evidence(1e-6),
            starts: 1,
            rungs: 2,
            rung_steps: 5,
            iterations: 60,
            patience: 6,
            patience_going_on: patience_going_on(),
            precision: Precision::Double,
            lm: LmConfig::default(),
        }
    }
}

fn patience_going_on() -> usize {
    2
}

impl TrainConfig {
    /// Every number within its range.
    pub fn check(&self) -> Result<(), TrainError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let checks = [
            ("epsilon", self.epsilon, positive(self.epsilon), "positive"),
            (
                "mean_radiance",
                self.mean_radiance.map_or(0.0, f64::from),
                self.mean_radiance.is_none_or(|m| m >= 0.0 && m.is_finite()),
                "at least 0",
            ),
            (
                "decay",
                self.decay.start(),
                self.decay.start() >= 0.0 && self.decay.start().is_finite(),
                "at least 0",
            ),
            (
                "prune",
                self.prune.unwrap_or(0.0),
                self.prune.unwrap_or(0.0) >= 0.0,
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
        if let Schedule::Online(batches) | Schedule::Recursive(batches) = self.mode
            && (batches.rows == 0 || batches.steps == 0)
        {
            return Err(TrainError::Config {
                name: "mode",
                value: format!("{batches:?}"),
                range: "at least 1 row and step",
            });
        }
        let of_nets_alone =
            self.mode != Schedule::Local || self.prune.is_some() || self.exponential;
        if !self.kind.is_net() && of_nets_alone {
            return Err(TrainError::NoNet {
                kind: self.kind.name(),
            });
        }
        match &self.size {
            Size::Hidden(units) if units.len() > 2 || units.contains(&0) => {
                return Err(TrainError::Config {
                    name: "size",
                    value: format!("{units:?}"),
                    range: "at most two layers of at least one unit",
                });
            }
            Size::Smallest { target } if !positive(*target) => {
                return Err(TrainError::Config {
                    name: "size",
                    value: target.to_string(),
                    range: "a positive target",
                });
            }
            _ => {}
        }
        Ok(())
    }
}
