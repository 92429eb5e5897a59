//! Rows with the weights of the relative loss, for fits that are linear in what they seek.

use crate::cell::Cell;
use crate::net::problem::Loss;
use crate::net::simd::TILE_ROWS;
use crate::net::tile::{Batch, CHANNELS, Rows};

/// The training rows of a cell and what their residuals are divided by.
pub(super) struct Weighing<'a> {
    cell: &'a Cell<'a>,
    /// max(channel mean, floor) of each row; 1 where errors are absolute.
    divisor: Vec<f64>,
    fresh: bool,
}

/// One row in the units of a net.
pub(super) struct Row<'a> {
    /// Its place among the training rows.
    pub at: usize,
    /// Scaled inputs.
    pub x: &'a [f64],
    /// Targets.
    pub target: [f64; CHANNELS],
    /// Square root of the weight of each channel's residual; 0 where it does not count.
    pub weight: [f64; CHANNELS],
    /// Radiance a unit of output.
    gain: [f64; CHANNELS],
    /// Channel mean of output 0.
    base: f64,
}

impl Row<'_> {
    /// Channel mean of such outputs.
    fn channel_mean(&self, out: [f64; CHANNELS]) -> f64 {
        let sum: f64 = (0..CHANNELS).map(|c| self.gain[c] * out[c]).sum();
        self.base + sum / CHANNELS as f64
    }
}

impl<'a> Weighing<'a> {
    /// Divided by the targets' channel mean.
    pub fn new(cell: &'a Cell<'a>) -> Weighing<'a> {
        let mut weighing = Weighing {
            cell,
            divisor: vec![1.0; cell.train.len()],
            fresh: true,
        };
        weighing.renew(1.0, |row| row.target);
        weighing
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.divisor.len()
    }

    /// Every row in order.
    pub fn each(&self, mut see: impl FnMut(&Row)) {
        let rows = self.cell.train.first(self.len());
        let inputs = self.cell.units.inputs.len();
        let (mut batch, mut x) = (Batch::new(inputs), vec![0.0; inputs]);
        for first in (0..self.len()).step_by(TILE_ROWS) {
            batch.clear();
            rows.load(first, &mut batch);
            for i in 0..batch.rows {
                for (x, lane) in x.iter_mut().zip(&batch.x) {
                    *x = lane[i];
                }
                let gain = batch.gain.map(|lane| lane[i]);
                see(&Row {
                    at: first + i,
                    x: &x,
                    target: batch.target.map(|lane| lane[i]),
                    weight: gain.map(|gain| gain / self.divisor[first + i]),
                    gain,
                    base: batch.base[i],
                });
            }
        }
    }

    /// Weighs prediction against target by the error left, noise taken out, and divides by that
    /// from here on; `out` are a row's outputs.
    pub fn reweigh(&mut self, out: impl Fn(&Row) -> [f64; CHANNELS]) {
        let (mut sum, mut counted) = (0.0, 0usize);
        self.each(|row| {
            for (c, found) in out(row).into_iter().enumerate() {
                sum += (row.weight[c] * (found - row.target[c])).powi(2);
                counted += usize::from(row.weight[c] > 0.0);
            }
        });
        let square = sum / counted.max(1) as f64 - self.cell.noise.square;
        self.renew(self.cell.loss.target_share(square), out);
    }

    fn renew(&mut self, share: f64, out: impl Fn(&Row) -> [f64; CHANNELS]) {
        let Loss::Relative { floor, .. } = self.cell.loss else {
            return;
        };
        let mut divisor = std::mem::take(&mut self.divisor);
        let next = Weighing {
            cell: self.cell,
            divisor: vec![1.0; divisor.len()],
            fresh: self.fresh,
        };
        next.each(|row| {
            let l =
                share * row.channel_mean(row.target) + (1.0 - share) * row.channel_mean(out(row));
            // halfway from the last, as a net's are
            let last = if next.fresh {
                l.max(floor)
            } else {
                divisor[row.at]
            };
            divisor[row.at] = 0.5 * (l.max(floor) + last);
        });
        self.divisor = divisor;
        self.fresh = false;
    }
}
