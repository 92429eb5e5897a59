//! Reasons that a bake ends.

use serde::{Deserialize, Serialize};

/// Reason that a bake ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The error of the whole model meets the target.
    Target,
    /// The maximum number of rounds is reached.
    Rounds,
    /// No refinement is expected to lower the error of any cell.
    #[serde(rename = "nothing_to_split")]
    NothingToRefine,
    /// The error cannot be distinguished from zero.
    Noise,
    /// The time limit is reached.
    Time,
}

impl StopReason {
    /// The reason in words, after so many rounds.
    pub fn text(self, rounds: u32) -> String {
        match self {
            StopReason::Target => "stopped because the target is reached".into(),
            StopReason::Rounds => format!("stopped after the maximum of {rounds} rounds"),
            StopReason::NothingToRefine => {
                "stopped because no refinement is expected to lower the error of any cell".into()
            }
            StopReason::Noise => {
                "stopped because the remaining error is below the noise of the samples".into()
            }
            StopReason::Time => "stopped because the time limit is reached".into(),
        }
    }
}
