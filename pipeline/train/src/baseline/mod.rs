//! Fits of what nets are compared with (`rrf_field::model::Kind`): linear least squares, solved
//! in one go, or the rows themselves.
//!
//! Rows, targets and weights are those of a net's fit: the relative loss of [`crate::problem::Loss`],
//! its divisors renewed by the predictions. Of several strengths of regularisation the rows held
//! out choose one, as they choose a net's weights.

mod errors;
mod nearest;
mod probes;
mod quadratic;
mod weighing;

use crate::cell::Cell;
use crate::fit::{CellFit, CellMetrics};
use crate::halves::ErrorEstimate;
use crate::end::FitEnd;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;

/// A model and what regularised it.
struct Solved {
    weights: Vec<f32>,
    /// Layers as the weights table has them.
    layers: Vec<usize>,
    /// Share of the mean diagonal of the normal equations that was added to it.
    ridge: f64,
}

/// A cell with the inputs that its kind needs, whatever was asked for.
pub(crate) fn with_inputs(prepared: Cell) -> Cell {
    match prepared.config.kind {
        Kind::Probes if prepared.train.len() > 0 => {
            let inputs = probes::inputs(&prepared, probes::GRID);
            prepared.with_inputs(inputs)
        }
        _ => prepared,
    }
}

/// Fits a cell's baseline; none where `prepared` asks for a net, or nothing could be solved.
pub(crate) fn fit(cell: u32, prepared: &Cell) -> Option<CellFit> {
    let candidates = match prepared.config.kind {
        Kind::Net => return None,
        Kind::Quadratic => quadratic::solve(prepared),
        Kind::Nearest => nearest::keep(prepared),
        Kind::Probes => probes::solve(prepared),
    };
    let mut best: Option<(f64, CellModel, f64)> = None;
    let one = candidates.len() == 1;
    for solved in candidates {
        let model = model(prepared, &solved);
        let error = match one {
            true => 0.0,
            false => errors::choosing(prepared, &model).square,
        };
        if best.as_ref().is_none_or(|(least, ..)| error < *least) {
            best = Some((error, model, solved.ridge));
        }
    }
    let (_, model, ridge) = best?;
    let (train, validation) = errors::both(prepared, &model);
    Some(CellFit {
        metrics: metrics(cell, prepared, &model, ridge, [train, validation]),
        model: CellModel { cell, ..model },
        report: prepared.report.clone(),
    })
}

/// As it is stored, but of cell 0.
fn model(prepared: &Cell, solved: &Solved) -> CellModel {
    let units = &prepared.units;
    CellModel {
        cell: 0,
        kind: prepared.config.kind,
        inputs: units.inputs.iter().map(|i| i.id).collect(),
        input_offset: units.inputs.iter().map(|i| i.offset).collect(),
        input_scale: units.inputs.iter().map(|i| i.scale).collect(),
        shape: Shape {
            sizes: solved.layers.clone(),
        },
        weights: solved.weights.clone(),
        output_scale: units.output.scale,
        output_offset: units.output.offset,
        divide_base: prepared.config.divide_base,
        exponential: false,
    }
}

fn metrics(
    cell: u32,
    prepared: &Cell,
    model: &CellModel,
    ridge: f64,
    [train_error, validation_error]: [ErrorEstimate; 2],
) -> CellMetrics {
    CellMetrics {
        cell,
        seed: prepared.config.seed,
        rows: prepared.rows,
        train_rows: prepared.train.len(),
        validation_rows: prepared.validation.len(),
        quarantined_rows: prepared.report.quarantined.len(),
        iterations: 0,
        stop: FitEnd::Solved,
        train_error,
        validation_error,
        alpha: ridge,
        mu: 0.0,
        effective_parameters: model.weights.len() as f64,
        weights: model.weights.len(),
        floor: prepared.floor,
        seconds: 0.0,
    }
}
