//! Why a fit ended.

use rrf_lm::Termination;

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitEnd {
    /// No row to train on.
    NoRows,
    /// The target, or every input, is constant: the model is a constant.
    Constant,
    /// The least squares were solved in one go: no net.
    Solved,
    /// Validation has not improved for the set number of iterations.
    Validation,
    /// The error sought has been reached.
    Target,
    /// The solver's own reason.
    Solver(Termination),
}

impl FitEnd {
    /// As the metrics table writes it.
    pub fn name(self) -> &'static str {
        match self {
            FitEnd::NoRows => "no rows",
            FitEnd::Constant => "constant",
            FitEnd::Solved => "solved",
            FitEnd::Validation => "validation",
            FitEnd::Target => "target",
            FitEnd::Solver(termination) => termination.name(),
        }
    }
}

impl From<Termination> for FitEnd {
    fn from(termination: Termination) -> FitEnd {
        FitEnd::Solver(termination)
    }
}
