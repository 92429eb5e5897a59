//! The error of a model on held-out rows and on test rows, Monte Carlo noise removed.

use crate::plan::refinement::Refinement;
use crate::plan::stop::StopReason;
use serde::{Deserialize, Serialize};

/// Error of one cell on its held-out rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellEvaluation {
    /// The cell.
    pub cell: u32,
    /// Its share of the whole domain.
    pub measure: f64,
    /// mean((p - y1)(p - y2) / max(c, ε)²) over its held-out rows, c the channel mean; can be negative.
    pub square_error: f64,
    /// Standard error of `square_error`.
    pub square_error_se: f64,
    /// Mean relative square error over its training rows; 0 where unknown.
    pub train_square_error: f64,
    /// Relative standard error of the targets.
    pub noise: f64,
    /// Rows that the net was fitted to.
    pub train_rows: u64,
    /// Effective number of parameters γ of the net.
    pub effective_parameters: f64,
    /// All rows.
    pub rows: u64,
    /// Weights of the net.
    pub weights: u32,
}

/// Error of the whole model on the test rows, which no net was fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TestError {
    /// Number of test rows.
    pub rows: u64,
    /// As [`Evaluation::relative_error`].
    pub relative_error: f64,
    /// Its standard error.
    pub relative_error_se: f64,
}

/// Relative error of the whole model ([`rrf_metrics::relative`]), free of Monte Carlo noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Relative error on the held-out rows of the cells, 0 where the square came out negative.
    pub relative_error: f64,
    /// Its standard error.
    pub relative_error_se: f64,
    /// Error on test rows; none where they are too few.
    #[serde(default)]
    pub test: Option<TestError>,
    /// The cells, by id.
    pub cells: Vec<CellEvaluation>,
}

/// Evaluation of a committed round and what follows from it, `RUN/rounds/000/judged.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EvaluatedRound {
    /// The round.
    pub round: u32,
    /// Its errors.
    #[serde(rename = "judgement")]
    pub evaluation: Evaluation,
    /// Why the bake ends here; none where another round follows.
    pub stop: Option<StopReason>,
    /// Possible refinements of the cells that miss the target.
    #[serde(default, rename = "remedies")]
    pub refinements: Vec<Refinement>,
}

impl Evaluation {
    /// Relative error of the whole model and its standard error, on test rows where there are any,
    /// otherwise on held-out rows.
    pub fn error(&self) -> (f64, f64) {
        match self.test {
            Some(test) => (test.relative_error, test.relative_error_se),
            None => (self.relative_error, self.relative_error_se),
        }
    }

    /// Whether the error cannot be distinguished from zero, neither on held-out rows nor on test
    /// rows: its square is within one standard error.
    pub(crate) fn is_within_noise(&self) -> bool {
        let held_out = (self.relative_error, self.relative_error_se);
        [held_out, self.error()].into_iter().all(|error| {
            let (square, square_se) = square(error);
            square <= square_se
        })
    }

    /// Whether the squared error plus its standard error is at most the squared target.
    pub fn meets(&self, target: f64) -> bool {
        let (square, square_se) = square(self.error());
        let evaluated = self.test.is_some() || !self.cells.is_empty();
        evaluated && square + square_se <= target * target
    }
}

/// The square of a relative error and its standard error: the inverse of
/// [`ErrorEstimate::relative_se`](rrf_metrics::ErrorEstimate::relative_se).
fn square((error, se): (f64, f64)) -> (f64, f64) {
    let square_se = if error > 0.0 {
        2.0 * error * se
    } else {
        se * se
    };
    (error * error, square_se)
}
