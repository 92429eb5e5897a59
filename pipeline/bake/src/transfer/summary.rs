//! A transfer in a few numbers.

use rrf_transfer::{PartFit, TransferCell, TransferModel};
use serde::Serialize;

/// The model's error on test rows, and the part of it that trusted answers have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TransferTest {
    /// Test rows.
    pub test_rows: u32,
    /// Relative error on them, noise taken out.
    pub relative_error: f64,
    /// Its standard error over rows.
    pub relative_error_se: f64,
    /// Median of the rows' relative errors; noise of the traced rows is left in it.
    pub median_error: f64,
    /// 95th percentile of them.
    pub percentile_95: f64,
    /// Share of the squared error that the worst 1 % of the rows make.
    pub worst_share: f64,
    /// Share of the rows whose answers are trusted.
    pub trusted_share: f64,
    /// Relative error of those.
    pub trusted_error: f64,
}

/// All of a transfer that its cells do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferFacts {
    /// Lights of the ensemble.
    pub lights: u32,
    /// Its error on test rows.
    pub test: TransferTest,
}

/// A transfer in a few numbers, its error first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TransferSummary {
    /// Error on test rows.
    #[serde(flatten)]
    pub test: TransferTest,
    /// Relative error over rows and lights that cells were not fitted to but chosen by, noise taken
    /// out. The rows lie where light falls steeply, and each cell's own error has one standard error added, so
    /// that it is too large.
    pub held_out_error: f64,
    /// Its standard error, over cells.
    pub held_out_error_se: f64,
    /// Rows that the held-out error is taken over.
    pub judged: u64,
    /// Rows that cells were fitted to.
    pub rows: u64,
    /// Cells.
    pub cells: usize,
    /// Cells that are answered by nets, the others by local fits.
    pub nets: usize,
    /// Cells whose error is above the target.
    pub missing: usize,
    /// Patches of the surface.
    pub patches: usize,
    /// Columns of the transfer that are asked for their light.
    pub columns: usize,
    /// Lights of the ensemble.
    pub lights: u32,
}

impl TransferSummary {
    /// Whether the error on test rows is a relative error to reach or below.
    pub fn meets(&self, target: f32) -> bool {
        self.test.relative_error <= f64::from(target)
    }

    /// Of a model that is to reach a relative error.
    pub fn new(model: &TransferModel, facts: TransferFacts, target: f32) -> TransferSummary {
        let judged = model.cells.iter().filter(|cell| cell.error.is_finite());
        let squares: Vec<(f64, f64)> = judged
            .map(|cell| (f64::from(cell.judged), f64::from(cell.error).powi(2)))
            .collect();
        let count: f64 = squares.iter().map(|s| s.0).sum();
        let mean = squares.iter().map(|(n, e)| n * e).sum::<f64>() / count.max(1.0);
        let spread: f64 = squares.iter().map(|(n, e)| (n * (e - mean)).powi(2)).sum();
        let error = mean.sqrt();
        let se = spread.sqrt() / count.max(1.0) / (2.0 * error.max(f64::MIN_POSITIVE));
        let is_net = |cell: &&TransferCell| {
            cell.parts
                .iter()
                .any(|part| matches!(part, PartFit::Net(_)))
        };
        TransferSummary {
            test: facts.test,
            held_out_error: error,
            held_out_error_se: se,
            judged: model.cells.iter().map(|cell| u64::from(cell.judged)).sum(),
            rows: model.cells.iter().map(|cell| u64::from(cell.rows)).sum(),
            cells: model.cells.len(),
            nets: model.cells.iter().filter(is_net).count(),
            missing: model
                .cells
                .iter()
                .filter(|cell| cell.error > target)
                .count(),
            patches: model.patches.len(),
            columns: model.used.iter().filter(|&&used| used).count(),
            lights: facts.lights,
        }
    }
}
