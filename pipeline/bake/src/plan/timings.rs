//! Wall time of a round's stages.

use serde::{Deserialize, Serialize};

/// Wall time of a round's stages on one machine \[s\]. Stages that were interrupted and continued add up;
/// the time of a killed process is not included, nor that of tasks done by other processes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    /// Extraction.
    pub extract: f64,
    /// Training.
    pub train: f64,
    /// Commit, evaluation and the plan of the next round.
    #[serde(rename = "judge")]
    pub evaluate: f64,
}

impl Timings {
    /// The sum of all stages \[s\].
    pub fn total(&self) -> f64 {
        self.extract + self.train + self.evaluate
    }
}
