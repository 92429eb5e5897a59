//! The error of a model from the errors of its cells.

use crate::plan::evaluation::{CellEvaluation, Evaluation};
use crate::plan::round::RoundPlan;
use rrf_metrics::ErrorEstimate;
use rrf_store::model::Fit;

/// Evaluates a model on the held-out rows of its cells, weighted by their measure.
pub(crate) fn evaluate(plan: &RoundPlan, fits: &[Fit]) -> Evaluation {
    let cells: Vec<CellEvaluation> = fits
        .iter()
        .filter_map(|fit| {
            let cell = plan.cells.get(fit.model.cell as usize)?;
            let metrics = &fit.metrics;
            let error = metrics.validation?;
            Some(CellEvaluation {
                cell: cell.cell,
                measure: cell.measure,
                square_error: error.mean,
                square_error_se: error.se,
                train_square_error: metrics.train.map_or(0.0, |e| e.mean),
                noise: metrics.noise.unwrap_or(0.0),
                train_rows: metrics.train_rows,
                effective_parameters: metrics
                    .effective_parameters
                    .unwrap_or(f64::from(metrics.weights)),
                rows: metrics.rows,
                weights: metrics.weights,
            })
        })
        .collect();
    let measure: f64 = cells.iter().map(|c| c.measure).sum();
    let squares = cells.iter().map(|c| c.measure * c.square_error);
    let variance: f64 = cells
        .iter()
        .map(|c| (c.measure * c.square_error_se / measure).powi(2))
        .sum();
    let whole = ErrorEstimate {
        square: squares.sum::<f64>() / measure,
        square_se: variance.sqrt(),
        rows: 0,
    };
    Evaluation {
        relative_error: whole.relative(),
        relative_error_se: whole.relative_se(),
        test: None,
        cells,
    }
}
