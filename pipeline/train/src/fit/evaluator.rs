//! The error of a model on some rows, free of Monte Carlo noise.

use crate::baseline;
use crate::cell::Cell;
use crate::net::problem::NetProblem;
use crate::net::tile::CHANNELS;
use crate::rows::{CellRows, Part};
use rrf_field::model::CellModel;
use rrf_field::net::Shape;
use rrf_metrics::estimate::{ErrorEstimate, by_halves};
use rrf_metrics::relative::{channel_mean, inverse_level};
use std::ops::Range;

/// Squared relative errors of what is stored, on the rows trained on and on those held out.
pub(crate) fn evaluate(cell: &Cell, model: &CellModel) -> [ErrorEstimate; 2] {
    if !model.kind.is_net() {
        return baseline::evaluate(cell, model);
    }
    let stored: Vec<f64> = model.weights.iter().map(|w| f64::from(*w)).collect();
    let mut on_training = Evaluator::on_training(cell, &model.shape, usize::MAX);
    let mut on_validation = Evaluator::on_validation(cell, &model.shape, usize::MAX);
    let square = on_training.error(&stored).square;
    let share = cell.loss.target_share(square);
    [&mut on_training, &mut on_validation].map(|evaluator| {
        evaluator.renew(&stored, share);
        evaluator.error(&stored)
    })
}

/// Tells a net's error over some rows, free of Monte Carlo noise.
pub(crate) struct Evaluator<'a> {
    cell: &'a Cell<'a>,
    problem: NetProblem<Part<'a>>,
    /// Which of the cell's rows, in its order.
    range: Range<usize>,
    divisor: Vec<f64>,
}

impl<'a> Evaluator<'a> {
    /// On the first `most` training rows; errors are divided by the channel mean of the targets
    /// until [`Evaluator::renew`].
    pub fn on_training(cell: &'a Cell, shape: &Shape, most: usize) -> Evaluator<'a> {
        Evaluator::new(cell, shape, &cell.train, 0, most)
    }

    /// On the first `most` validation rows.
    pub fn on_validation(cell: &'a Cell, shape: &Shape, most: usize) -> Evaluator<'a> {
        Evaluator::new(cell, shape, &cell.validation, cell.train.len(), most)
    }

    /// On the rows that choose weights: validation, or training where there is none; a `share`
    /// of them.
    pub fn choosing(cell: &'a Cell, shape: &Shape, share: f64) -> Evaluator<'a> {
        let most = |rows: &CellRows| (rows.len() as f64 * share).ceil() as usize;
        if cell.validation.len() == 0 {
            Evaluator::on_training(cell, shape, most(&cell.train))
        } else {
            Evaluator::on_validation(cell, shape, most(&cell.validation))
        }
    }

    fn new(
        cell: &'a Cell,
        shape: &Shape,
        rows: &'a CellRows<'a>,
        first: usize,
        most: usize,
    ) -> Evaluator<'a> {
        let range = first..first + most.min(rows.len());
        let mut divisor = Vec::with_capacity(range.len());
        cell.raw.each(range.clone(), |chunk, rows| {
            let levels = rows.map(|row| channel_mean(chunk.mean(row)));
            divisor.extend(levels.map(|level| inverse_level(level, cell.floor)));
        });
        let residuals = range.len() * CHANNELS;
        Evaluator {
            problem: NetProblem::new(shape, rows.first(range.len()), residuals, cell.loss)
                .exponential(cell.config.exponential),
            cell,
            range,
            divisor,
        }
    }

    /// From here on errors are divided by `share` of the targets' channel mean and 1 − `share` of
    /// that of the net with weights `w`.
    pub fn renew(&mut self, w: &[f64], share: f64) {
        let (divisor, floor) = (&mut self.divisor, self.cell.floor);
        self.problem.each_tile(w, |first, tile| {
            for (d, l) in divisor[first..].iter_mut().zip(tile.channel_mean(share)) {
                *d = inverse_level(l, floor);
            }
        });
    }

    /// Squared relative error of the net with weights `w`.
    pub fn error(&mut self, w: &[f64]) -> ErrorEstimate {
        let mut values = Vec::with_capacity(self.range.len());
        let (cell, start, divisor) = (self.cell, self.range.start, &self.divisor);
        let output = &cell.units.output;
        self.problem.each_tile(w, |first, tile| {
            cell.raw.show(start + first, tile.batch.rows, |chunk, at| {
                for i in 0..tile.batch.rows {
                    let base = chunk.base(at + i, cell.config.divide_base);
                    let p = std::array::from_fn(|c| {
                        let (scale, offset) = (output.scale[c], output.offset[c]);
                        base[c] * (f64::from(offset) + f64::from(scale) * tile.out[c][i])
                    });
                    let [y1, y2] = [0, 1].map(|half| chunk.halves[half][at + i]);
                    values.push(by_halves(p, y1, y2, divisor[first + i]));
                }
            });
        });
        ErrorEstimate::of(&values)
    }
}
