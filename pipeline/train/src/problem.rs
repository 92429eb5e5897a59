//! Training a net as a sum of squares: the [`Problem`] that Levenberg-Marquardt sees.

use crate::blocks::{Accumulator, Normal};
use crate::lm::Problem;
use crate::simd::TILE;
use crate::tile::{Rows, Tile};
use rrf_field::net::Shape;

/// How residuals are weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// s = gain: squared radiance.
    Absolute,
    /// s = gain / max(luminance of the prediction, `floor`), the prediction held fixed within a
    /// step (iteratively reweighted least squares). Differentiating through the divisor, or
    /// dividing by noisy targets, would bias the fit low.
    Relative {
        /// Luminance below which errors count as absolute.
        floor: f64,
    },
}

/// A net of one shape on some rows.
pub struct NetProblem<'a, R: Rows> {
    rows: &'a R,
    loss: Loss,
    tile: Tile,
    sums: Accumulator,
    /// 1 / max(luminance, floor) of each row, whole tiles.
    divisor: Vec<f64>,
    parameters: usize,
    /// Whether [`Problem::linearise`] renews the divisors.
    pub refresh: bool,
}

impl<'a, R: Rows> NetProblem<'a, R> {
    /// A net of `shape` on `rows`; all divisors 1 until the first linearisation.
    pub fn new(shape: &Shape, rows: &'a R, loss: Loss) -> NetProblem<'a, R> {
        let tile = Tile::new(shape);
        NetProblem {
            sums: Accumulator::new(&tile),
            tile,
            divisor: vec![1.0; rows.len().next_multiple_of(TILE)],
            rows,
            loss,
            parameters: shape.weights(),
            refresh: true,
        }
    }

    /// Sets the divisors by hand, one a row; missing ones keep their value.
    pub fn set_divisors(&mut self, divisors: &[f64]) {
        for (d, value) in self.divisor.iter_mut().zip(divisors) {
            *d = *value;
        }
    }

    /// Runs the net over all rows and hands each tile to `see` with its first row.
    pub fn each_tile(&mut self, w: &[f64], mut see: impl FnMut(usize, &Tile)) {
        for first in (0..self.rows.len()).step_by(TILE) {
            self.load(first);
            self.tile.forward(w);
            see(first, &self.tile);
        }
    }

    fn load(&mut self, first: usize) {
        self.tile.batch.clear();
        self.rows.load(first, &mut self.tile.batch);
    }

    fn renew(&mut self, first: usize) {
        if let (true, Loss::Relative { floor }) = (self.refresh, self.loss) {
            let luminance = self.tile.luminance();
            for (d, l) in self.divisor[first..].iter_mut().zip(luminance) {
                *d = 1.0 / l.max(floor);
            }
        }
    }
}

impl<R: Rows> Problem for NetProblem<'_, R> {
    fn parameters(&self) -> usize {
        self.parameters
    }

    fn cost(&mut self, w: &[f64]) -> f64 {
        let mut sum = 0.0;
        for first in (0..self.rows.len()).step_by(TILE) {
            self.load(first);
            self.tile.forward(w);
            sum += self.tile.residuals(&self.divisor[first..]);
        }
        sum
    }

    fn linearise(&mut self, w: &[f64], normal: &mut Normal) -> f64 {
        let mut sum = 0.0;
        self.sums.clear();
        for first in (0..self.rows.len()).step_by(TILE) {
            self.load(first);
            self.tile.forward(w);
            self.renew(first);
            sum += self.tile.residuals(&self.divisor[first..]);
            self.tile.backward(w);
            self.sums.add(&self.tile);
        }
        self.sums.finish(normal);
        sum
    }
}
