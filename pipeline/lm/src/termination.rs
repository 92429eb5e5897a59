//! Why the steps ended.

use serde::{Deserialize, Serialize};

/// Why the steps ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Termination {
    /// The gradient vanished.
    Gradient,
    /// The step became smaller than the parameters can show.
    Step,
    /// The cost stopped falling.
    Cost,
    /// The set number of iterations is used up.
    Iterations,
    /// No damping up to the largest gave a lower cost.
    Damping,
    /// The cost at the start is not finite.
    NotFinite,
}

impl Termination {
    /// In a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Termination::Gradient => "gradient",
            Termination::Step => "step",
            Termination::Cost => "cost",
            Termination::Iterations => "iterations",
            Termination::Damping => "damping",
            Termination::NotFinite => "not finite",
        }
    }
}
