//! The error of a net on some rows, free of Monte Carlo noise.

use crate::cell::Cell;
use crate::halves::{self, ErrorEstimate};
use crate::prepare;
use crate::problem::NetProblem;
use crate::rows::{MemoryRows, Part};
use crate::tile::CHANNELS;
use rrf_field::net::Shape;

/// Tells a net's error over some rows, free of Monte Carlo noise.
pub(crate) struct Judge<'a> {
    cell: &'a Cell<'a>,
    problem: NetProblem<Part<'a>>,
    ids: &'a [u32],
    divisor: Vec<f64>,
}

impl<'a> Judge<'a> {
    /// On the first `most` training rows; errors are divided by the luminance of the targets
    /// until [`Judge::renew`].
    pub fn on_training(cell: &'a Cell, shape: &Shape, most: usize) -> Judge<'a> {
        Judge::new(cell, shape, &cell.train, &cell.train_ids, most)
    }

    /// On the first `most` validation rows.
    pub fn on_validation(cell: &'a Cell, shape: &Shape, most: usize) -> Judge<'a> {
        Judge::new(cell, shape, &cell.validation, &cell.validation_ids, most)
    }

    /// On the rows that choose weights: validation, or training where there is none; a `share`
    /// of them.
    pub fn choosing(cell: &'a Cell, shape: &Shape, share: f64) -> Judge<'a> {
        let most = |ids: &[u32]| (ids.len() as f64 * share).ceil() as usize;
        if cell.validation_ids.is_empty() {
            Judge::on_training(cell, shape, most(&cell.train_ids))
        } else {
            Judge::on_validation(cell, shape, most(&cell.validation_ids))
        }
    }

    fn new(
        cell: &'a Cell,
        shape: &Shape,
        rows: &'a MemoryRows,
        ids: &'a [u32],
        most: usize,
    ) -> Judge<'a> {
        let ids = &ids[..most.min(ids.len())];
        let divisor = (ids.iter())
            .map(|&r| prepare::luminance(cell.samples.mean(r as usize)))
            .map(|luminance| 1.0 / luminance.max(cell.floor))
            .collect();
        let residuals = ids.len() * CHANNELS;
        Judge {
            problem: NetProblem::new(shape, rows.first(ids.len()), residuals, cell.loss)
                .exponential(cell.config.exponential),
            cell,
            ids,
            divisor,
        }
    }

    /// From here on errors are divided by `share` of the targets' luminance and 1 − `share` of
    /// the luminance that the net with weights `w` predicts.
    pub fn renew(&mut self, w: &[f64], share: f64) {
        let (divisor, floor) = (&mut self.divisor, self.cell.floor);
        self.problem.each_tile(w, |first, tile| {
            for (d, l) in divisor[first..].iter_mut().zip(tile.luminance(share)) {
                *d = 1.0 / l.max(floor);
            }
        });
    }

    /// Squared relative error of the net with weights `w`.
    pub fn error(&mut self, w: &[f64]) -> ErrorEstimate {
        let mut values = Vec::with_capacity(self.ids.len());
        let (cell, ids, divisor) = (self.cell, self.ids, &self.divisor);
        let output = &cell.output;
        self.problem.each_tile(w, |first, tile| {
            for i in 0..tile.batch.rows {
                let row = ids[first + i] as usize;
                let base = cell.samples.base(row, cell.config.divide_base);
                let p = std::array::from_fn(|c| {
                    let (scale, offset) = (output.scale[c], output.offset[c]);
                    base[c] * (f64::from(offset) + f64::from(scale) * tile.out[c][i])
                });
                let [y1, y2] = cell.samples.halves.map(|half| half[row]);
                values.push(halves::product(p, y1, y2, divisor[first + i]));
            }
        });
        ErrorEstimate::of(&values)
    }
}
