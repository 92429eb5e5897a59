//! What comes out of a fit.

use crate::cell::Cell;
use crate::end::FitEnd;
use rrf_field::model::CellModel;
use rrf_field::net::Shape;
use rrf_metrics::ErrorEstimate;

/// A fitted cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellFit {
    /// What is stored and evaluated.
    pub model: CellModel,
    /// Why the fit ended.
    pub end: FitEnd,
    /// Squared relative error over the training rows, free of Monte Carlo noise but not of what
    /// the net has learned of it: slightly low.
    pub train_error: ErrorEstimate,
    /// Squared relative error over the validation rows, free of Monte Carlo noise.
    pub validation_error: ErrorEstimate,
    /// ε of the relative error, W·sr⁻¹·m⁻².
    pub floor: f64,
    /// Weight decay, a residual.
    pub alpha: f64,
    /// Damping at the end.
    pub damping: f64,
    /// Effective parameters γ; without an estimate the number of weights.
    pub effective_parameters: f64,
    /// Rows of the cell.
    pub rows: usize,
    /// Rows trained on.
    pub train_rows: usize,
    /// Rows kept back.
    pub validation_rows: usize,
    /// Rows left out because a number in them is not finite, by place in the cell.
    pub quarantined: Vec<u32>,
    /// Inputs dropped because they do not vary or cannot matter, as places in `rrf_field::inputs::INPUTS`.
    pub dropped_inputs: Vec<u8>,
    /// Accepted steps.
    pub history: Vec<HistoryRow>,
}

/// One accepted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryRow {
    /// Residuals of the rows stepped on.
    pub residuals: usize,
    /// Mean weighted squared residual over the training rows (with noise).
    pub cost: f64,
    /// Squared relative error on the rows that choose.
    pub validation: f64,
    /// Damping after the step.
    pub damping: f64,
    /// Gain ratio.
    pub gain: f64,
}

/// A net in the units of its cell, weights as they were trained.
pub(crate) struct Net {
    pub shape: Shape,
    pub weights: Vec<f64>,
    /// Squared relative error on the choosing rows.
    pub error: f64,
    /// Weight decay a residual.
    pub alpha: f64,
}

/// A model and how training came to it.
pub(crate) struct Trained {
    pub model: CellModel,
    pub course: Course,
}

/// How training went.
pub(crate) struct Course {
    pub end: FitEnd,
    pub damping: f64,
    pub alpha: f64,
    pub effective_parameters: f64,
    pub history: Vec<HistoryRow>,
}

impl Course {
    /// Of a model that took no steps.
    pub fn without_steps(end: FitEnd, alpha: f64, effective_parameters: f64) -> Course {
        Course {
            end,
            damping: 0.0,
            alpha,
            effective_parameters,
            history: Vec::new(),
        }
    }
}

/// All of it, with the errors on training and validation rows.
pub(crate) fn report(
    cell: Cell,
    trained: Trained,
    [train_error, validation_error]: [ErrorEstimate; 2],
) -> CellFit {
    let Trained { model, course } = trained;
    CellFit {
        model,
        end: course.end,
        train_error,
        validation_error,
        floor: cell.floor,
        alpha: course.alpha,
        damping: course.damping,
        effective_parameters: course.effective_parameters,
        rows: cell.rows,
        train_rows: cell.train.len(),
        validation_rows: cell.validation.len(),
        quarantined: cell.quarantined,
        dropped_inputs: cell.dropped_inputs,
        history: course.history,
    }
}
