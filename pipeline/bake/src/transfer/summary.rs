//! A transfer in a few numbers.

use rrf_transfer::{PartFit, TransferCell, TransferModel};
use serde::Serialize;

/// A transfer in a few numbers, its error first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TransferSummary {
    /// Relative error over rows and lights that no cell was fitted to, noise taken out; each cell's
    /// own has one standard error added, so that it is rather too large.
    pub relative_error: f64,
    /// Its standard error, over cells.
    pub relative_error_se: f64,
    /// Rows that the error is taken over.
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
    /// Of a model that was fitted to some lights, to reach a relative error.
    pub fn new(model: &TransferModel, lights: u32, target: f32) -> TransferSummary {
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
            relative_error: error,
            relative_error_se: se,
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
            lights,
        }
    }
}
