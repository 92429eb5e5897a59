//! How good a run is: the model's own error on rows held out of its cells and on test rows, Monte Carlo noise taken
//! out.

use crate::plan::RoundPlan;
use crate::test_rows::Tested;
use rrf_store::model::Fit;
use rrf_train::halves::ErrorEstimate;
use serde::{Deserialize, Serialize};

/// Error of one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellJudgement {
    /// The cell.
    pub cell: u32,
    /// Its share of the whole.
    pub measure: f64,
    /// mean((p - y1)(p - y2) / max(lum, ε)²) over its rows held out; may come out negative.
    pub square_error: f64,
    /// Standard error of that.
    pub square_error_se: f64,
    /// The same over its training rows: what the net cannot follow. 0 where it was not told.
    pub train_square_error: f64,
    /// Relative standard error of its rows' targets.
    pub noise: f64,
    /// Rows trained on.
    pub train_rows: u64,
    /// γ of its net.
    pub effective_parameters: f64,
    /// Its rows.
    pub rows: u64,
    /// Weights of its net.
    pub weights: u32,
}

/// Error of the whole: sqrt(mean((p−m)² / max(lum(m), ε)²)), ε = 5 % of the mean luminance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Relative error of the whole on rows held out of the cells, 0 where the square came out negative.
    pub relative_error: f64,
    /// Its standard error.
    pub relative_error_se: f64,
    /// The same on rows that no net was fitted to; none where there are too few.
    #[serde(default)]
    pub test: Option<Tested>,
    /// The cells, by id.
    pub cells: Vec<CellJudgement>,
}

impl Judgement {
    /// Relative error of the whole and its standard error: on test rows, or held-out ones where there are none.
    pub fn error(&self) -> (f64, f64) {
        match self.test {
            Some(test) => (test.relative_error, test.relative_error_se),
            None => (self.relative_error, self.relative_error_se),
        }
    }

    /// Whether neither rows held out nor test rows can tell the error from zero: the square is within its
    /// standard error.
    pub fn hidden(&self) -> bool {
        let held_out = (self.relative_error, self.relative_error_se);
        [held_out, self.error()].into_iter().all(|error| {
            let (square, square_se) = square(error);
            square <= square_se
        })
    }

    /// Whether the squared error and its standard error together are within that of a target.
    pub fn meets(&self, target: f64) -> bool {
        let (square, square_se) = square(self.error());
        let judged = self.test.is_some() || !self.cells.is_empty();
        judged && square + square_se <= target * target
    }
}

/// The square of a relative error, 0 where it came out negative, and its standard error: as
/// [`ErrorEstimate::relative_se`] has it, the other way around.
fn square((error, se): (f64, f64)) -> (f64, f64) {
    let square_se = if error > 0.0 {
        2.0 * error * se
    } else {
        se * se
    };
    (error * error, square_se)
}

/// Weighs the cells by their measure.
pub(crate) fn judge(plan: &RoundPlan, fits: &[Fit]) -> Judgement {
    let cells: Vec<CellJudgement> = fits
        .iter()
        .filter_map(|fit| {
            let cell = plan.cells.get(fit.model.cell as usize)?;
            let error = fit.metrics.validation?;
            Some(CellJudgement {
                cell: cell.cell,
                measure: cell.measure,
                square_error: error.mean,
                square_error_se: error.se,
                train_square_error: fit.metrics.train.map_or(0.0, |e| e.mean),
                noise: fit.metrics.noise.unwrap_or(0.0),
                train_rows: fit.metrics.train_rows,
                effective_parameters: fit
                    .metrics
                    .effective_parameters
                    .unwrap_or(f64::from(fit.metrics.weights)),
                rows: fit.metrics.rows,
                weights: fit.metrics.weights,
            })
        })
        .collect();
    let judged: f64 = cells.iter().map(|c| c.measure).sum();
    let square = cells
        .iter()
        .map(|c| c.measure * c.square_error)
        .sum::<f64>()
        / judged;
    let variance: f64 = cells
        .iter()
        .map(|c| (c.measure * c.square_error_se / judged).powi(2))
        .sum();
    let whole = ErrorEstimate {
        square,
        square_se: variance.sqrt(),
        rows: 0,
    };
    Judgement {
        relative_error: whole.relative(),
        relative_error_se: whole.relative_se(),
        test: None,
        cells,
    }
}
