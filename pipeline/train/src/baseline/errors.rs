//! The error of what is stored, free of Monte Carlo noise: by the evaluation that frames use.

use crate::cell::Cell;
use rrf_field::Field;
use rrf_field::model::CellModel;
use rrf_field::tree::Tree;
use rrf_metrics::estimate::{ErrorEstimate, by_halves};
use rrf_metrics::relative::{channel_mean, inverse_level};
use std::ops::Range;

/// Squared relative error on the rows that choose: those held out, or those trained on where there
/// are none; errors divided by the targets' channel mean.
pub(super) fn choosing(cell: &Cell, model: &CellModel) -> ErrorEstimate {
    let (train, held) = ranges(cell);
    error(cell, model, if held.is_empty() { train } else { held }, 1.0)
}

/// Squared relative errors on the rows trained on and on those held out, divided by a mixture of
/// the targets' channel mean and of the prediction's, as those of nets are; but how far predictions can be
/// relied on is measured on the rows that choose: what is made of the training rows may follow their noise.
pub(crate) fn evaluate(cell: &Cell, model: &CellModel) -> [ErrorEstimate; 2] {
    let (train, held) = ranges(cell);
    let share = cell.loss.target_share(choosing(cell, model).square);
    [train, held].map(|rows| error(cell, model, rows, share))
}

fn ranges(cell: &Cell) -> (Range<usize>, Range<usize>) {
    let train = cell.train.len();
    (0..train, train..train + cell.validation.len())
}

/// A model that cannot be evaluated has an error beyond all numbers.
fn error(cell: &Cell, model: &CellModel, rows: Range<usize>, share: f64) -> ErrorEstimate {
    let (mut values, mut out) = (Vec::with_capacity(rows.len()), Default::default());
    let mut cells = Vec::new();
    let failed = ErrorEstimate {
        square: f64::INFINITY,
        ..ErrorEstimate::default()
    };
    // the only cell of its tree
    let alone = CellModel {
        cell: 0,
        ..model.clone()
    };
    let Ok(field) = Field::new(Tree::single(), vec![alone]) else {
        return failed;
    };
    let mut fine = true;
    cell.raw.each(rows, |chunk, rows| {
        let ids: Vec<u32> = rows.clone().map(|row| row as u32).collect();
        let asked = chunk.columns.take(&ids);
        fine &= field.evaluate(&asked, &mut out, &mut cells).is_ok();
        for (i, row) in rows.enumerate() {
            let p: [f64; 3] = std::array::from_fn(|c| f64::from(out[c][i]));
            let [target, found] = [chunk.mean(row), p].map(channel_mean);
            let level = share * target + (1.0 - share) * found;
            let [y1, y2] = [0, 1].map(|half| chunk.halves[half][row]);
            values.push(by_halves(p, y1, y2, inverse_level(level, cell.floor)));
        }
    });
    if fine {
        ErrorEstimate::of(&values)
    } else {
        failed
    }
}
