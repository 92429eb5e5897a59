//! Fits of what nets are compared with (`rrf_field::model::Kind`): linear least squares, solved
//! in one go, or the rows themselves.
//!
//! Rows, targets and weights are those of a net's fit: the relative loss of
//! [`crate::net::problem::Loss`], its divisors renewed by the predictions. Of several strengths of
//! regularisation the rows held out choose one, as they choose a net's weights.

mod errors;
mod nearest;
mod probes;
mod quadratic;
mod solved;
mod weighing;

use crate::cell::Cell;
use crate::end::FitEnd;
use crate::report::{Course, Trained};
pub(crate) use errors::evaluate;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;

/// Gives a cell the inputs that its kind needs, whatever was asked for.
pub(crate) fn set_inputs(cell: &mut Cell) {
    if cell.config.kind == Kind::Probes && cell.train.len() > 0 {
        cell.set_inputs(probes::inputs(cell, probes::GRID));
    }
}

/// Fits a cell's baseline; none where it asks for a net, or nothing could be solved.
pub(crate) fn solve(cell: &Cell) -> Option<Trained> {
    let candidates = match cell.config.kind {
        Kind::Net => return None,
        Kind::Quadratic => quadratic::solve(cell),
        Kind::Nearest => nearest::keep(cell),
        Kind::Probes => probes::solve(cell),
    };
    let mut best: Option<(f64, CellModel, f64)> = None;
    let one = candidates.len() == 1;
    for solved in candidates {
        let shape = Shape {
            sizes: solved.layers,
        };
        let model = cell.model(cell.config.kind, shape, solved.weights);
        let error = match one {
            true => 0.0,
            false => errors::choosing(cell, &model).square,
        };
        if best.as_ref().is_none_or(|(least, ..)| error < *least) {
            best = Some((error, model, solved.ridge));
        }
    }
    let (_, model, ridge) = best?;
    let weights = model.weights.len() as f64;
    Some(Trained {
        model,
        course: Course::without_steps(FitEnd::Solved, ridge, weights),
    })
}
