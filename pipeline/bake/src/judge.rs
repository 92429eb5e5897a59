//! How good a run is: the model's own error on rows held out, Monte Carlo noise taken out.

use crate::error::BakeError;
use crate::run::Run;
use rrf_extract::Plan;
use rrf_store::model::{self, CellMetrics};
use serde::Serialize;

/// Error of one cell.
#[derive(Clone, Debug, Serialize)]
pub struct CellJudgement {
    /// The cell.
    pub cell: u32,
    /// Its share of the whole.
    pub measure: f64,
    /// mean((p - y1)(p - y2) / max(lum, ε)²) over its rows held out; may come out negative.
    pub square_error: f64,
    /// Standard error of that.
    pub square_error_se: f64,
}

/// Error of the whole: sqrt(mean((p−m)² / max(lum(m), ε)²)), ε = 5 % of the mean luminance.
#[derive(Clone, Debug, Serialize)]
pub struct Judgement {
    /// Relative error of the whole, 0 where the square came out negative.
    pub relative_error: f64,
    /// Its standard error.
    pub relative_error_se: f64,
    /// The cells, by id.
    pub cells: Vec<CellJudgement>,
}

/// Reads the run's metrics and weighs the cells by their measure.
pub fn judge(run: &Run, plan: &Plan) -> Result<Judgement, BakeError> {
    let metrics = model::read_metrics(&run.folder, &run.facts())?;
    Ok(whole(plan, &metrics))
}

fn whole(plan: &Plan, metrics: &[CellMetrics]) -> Judgement {
    let cells: Vec<CellJudgement> = metrics
        .iter()
        .filter_map(|m| {
            let cell = plan.cells.get(m.cell_id as usize)?;
            Some(CellJudgement {
                cell: m.cell_id,
                measure: cell.measure,
                square_error: m.validation?.mean,
                square_error_se: m.validation?.se,
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
    let relative_error = square.max(0.0).sqrt();
    // d sqrt(x) = dx / (2 sqrt(x)); at zero the square's own error bounds it
    let relative_error_se = if relative_error > 0.0 {
        variance.sqrt() / (2.0 * relative_error)
    } else {
        variance.sqrt().sqrt()
    };
    Judgement {
        relative_error,
        relative_error_se,
        cells,
    }
}
