//! Training a net as a sum of squares: the [`rrf_lm::Problem`] that Levenberg-Marquardt sees.

use crate::net::blocks::{Accumulator, Precision};
use crate::net::curvature::second_derivative;
use crate::net::simd::TILE_ROWS;
use crate::net::tangent::{Linearised, times};
use crate::net::tile::{Rows, Tile};
use rrf_field::net::Shape;
use rrf_lm::{Cholesky, NormalEquations, Problem};

/// How residuals are weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// s = gain: squared radiance.
    Absolute,
    /// s = gain / max(l, `floor`), l an estimate of the true mean of the channels that is held fixed
    /// within a step (iteratively reweighted least squares).
    ///
    /// With the target's channel mean y for l, a relative noise σ of y biases the fit low by 2σ².
    /// With the prediction's channel mean p there is no such bias, but a row predicted far too
    /// bright loses its weight and is never put right. So l = ω y + (1 − ω) p, each weighted by
    /// the other's squared error: ω = τ² / (τ² + σ²), τ the relative error of the model, never
    /// taken below [`LEAST_ERROR`]. The bias is then 2ωσ² ≤ 2 min(τ², σ²): below the model's own
    /// error whatever the noise.
    Relative {
        /// Channel mean below which errors count as absolute.
        floor: f64,
        /// σ²: mean squared relative noise of the targets.
        noise: f64,
    },
}

/// Smallest relative error that is assumed of a model when its predictions are weighed against
/// the targets.
pub const LEAST_ERROR: f64 = 0.05;

impl Loss {
    /// The weight ω of the target in the channel mean that errors are divided by, for a model of
    /// squared relative error `square`.
    pub fn target_share(&self, square: f64) -> f64 {
        match self {
            Loss::Absolute => 1.0,
            Loss::Relative { noise, .. } => {
                let square = square.max(LEAST_ERROR * LEAST_ERROR);
                square / (square + noise)
            }
        }
    }
}

/// Share of the largest diagonal entry that keeps the output layer's equations solvable where
/// hidden units duplicate each other.
const RIDGE: f64 = 1e-12;

/// Tiles between two looks at whether to give up.
const ASKED: usize = 8;

/// A net of one shape on some rows.
pub struct NetProblem<R: Rows> {
    rows: R,
    loss: Loss,
    tile: Tile,
    sums: Accumulator,
    output_sums: Accumulator,
    linearised: Linearised,
    output: NormalEquations,
    factor: Cholesky,
    /// 1 / max(channel mean, floor) of each row, whole tiles.
    divisor: Vec<f64>,
    parameters: usize,
    /// ω of [`Loss::Relative`].
    share: f64,
    residuals: f64,
    /// No divisor has been set yet.
    fresh: bool,
}

impl<R: Rows> NetProblem<R> {
    /// A net of `shape` on `rows`, of which `residuals` values count; the first linearisation
    /// divides by the targets' channel mean.
    pub fn new(shape: &Shape, rows: R, residuals: usize, loss: Loss) -> NetProblem<R> {
        let tile = Tile::new(shape);
        let first = shape.offsets().last().copied().unwrap_or(0);
        NetProblem {
            sums: Accumulator::new(&tile, Precision::Double),
            output_sums: Accumulator::output_layer(&tile),
            linearised: Linearised::default(),
            output: NormalEquations::zeros(shape.weights() - first),
            factor: Cholesky::default(),
            tile,
            divisor: vec![1.0; rows.len().next_multiple_of(TILE_ROWS)],
            rows,
            loss,
            parameters: shape.weights(),
            share: 1.0,
            fresh: true,
            residuals: residuals.max(1) as f64,
        }
    }

    /// The same with outputs that are exponentials, or not.
    pub fn exponential(mut self, exponential: bool) -> NetProblem<R> {
        self.tile.set_exponential(exponential);
        self
    }

    /// The same with JᵀWJ multiplied in another precision.
    pub fn precision(mut self, precision: Precision) -> NetProblem<R> {
        self.sums = Accumulator::new(&self.tile, precision);
        self
    }

    /// How many values count.
    pub fn residuals(&self) -> f64 {
        self.residuals
    }

    /// The output layer's weights.
    pub fn output_layer(&self) -> std::ops::Range<usize> {
        self.parameters - self.output.n..self.parameters
    }

    /// ω of [`Loss::Relative`] in the next linearisation.
    pub fn target_share(&self) -> f64 {
        self.share
    }

    /// Starts from another ω than 1.
    pub fn set_target_share(&mut self, share: f64) {
        self.share = share;
    }

    /// Runs the net over all rows and hands each tile to `see` with its first row.
    pub fn each_tile(&mut self, w: &[f64], mut see: impl FnMut(usize, &Tile)) {
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            see(first, &self.tile);
        }
    }

    /// Moves the output layer to where F is least for the other weights as they are; false where
    /// that has no unique answer, w then unmoved. Exponential outputs have none.
    pub fn project(&mut self, w: &mut [f64], alpha: f64) -> bool {
        if self.tile.exponential {
            return false;
        }
        self.output_sums.clear();
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            if self.fresh {
                self.renew(first);
            }
            self.tile.residuals(&self.divisor[first..]);
            self.output_sums.add(&self.tile);
        }
        self.output_sums.finish(&mut self.output);
        let (n, top) = (self.output.n, self.output_layer());
        let diagonal = |i: usize| self.output.matrix[i * n + i];
        let largest = (0..n).map(diagonal).fold(0.0, f64::max);
        let mut delta: Vec<f64> = (self.output.gradient.iter().zip(&w[top.clone()]))
            .map(|(g, w)| -(g + alpha * w))
            .collect();
        let add = vec![alpha + RIDGE * largest; n];
        let solved = (self.factor.factor(&self.output.matrix, &add))
            .and_then(|()| self.factor.solve(&mut delta));
        if solved.is_ok() {
            w[top].iter_mut().zip(&delta).for_each(|(w, d)| *w += d);
        }
        solved.is_ok()
    }

    /// Whether a pass ends at row `first`: rows are asked now and then.
    fn halts(&self, first: usize) -> bool {
        first.is_multiple_of(ASKED * TILE_ROWS) && self.rows.halted()
    }

    fn load(&mut self, first: usize) {
        self.tile.batch.clear();
        self.rows.load(first, &mut self.tile.batch);
    }

    fn renew(&mut self, first: usize) {
        if let Loss::Relative { floor, .. } = self.loss {
            let means = self.tile.channel_mean(self.share);
            for (d, l) in self.divisor[first..].iter_mut().zip(means) {
                // Halfway from the last: a full change makes bright and dark rows take turns.
                let last = if self.fresh { l.max(floor) } else { 1.0 / *d };
                *d = 1.0 / (0.5 * (l.max(floor) + last));
            }
        }
    }

    /// Weighs prediction against target by the error left.
    fn reweigh(&mut self, cost: f64) {
        if let Loss::Relative { noise, .. } = self.loss {
            self.share = self.loss.target_share(cost / self.residuals - noise);
        }
    }
}

impl<R: Rows> Problem for NetProblem<R> {
    fn cost(&mut self, w: &[f64]) -> f64 {
        let mut sum = 0.0;
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            sum += self.tile.residuals(&self.divisor[first..]);
        }
        sum
    }

    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64 {
        let mut sum = 0.0;
        self.sums.clear();
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            self.renew(first);
            sum += self.tile.residuals(&self.divisor[first..]);
            self.tile.backward(w);
            self.sums.add(&self.tile);
        }
        self.sums.finish(normal);
        self.fresh = false;
        self.reweigh(sum);
        sum
    }

    fn gradient(&mut self, w: &[f64], out: &mut [f64]) -> Option<f64> {
        let mut sum = 0.0;
        self.linearised.begin(w, self.rows.held());
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            self.renew(first);
            sum += self.tile.residuals(&self.divisor[first..]);
            self.linearised.note(&self.tile, &self.tile.r);
        }
        self.linearised.finish(out);
        self.fresh = false;
        self.reweigh(sum);
        Some(sum)
    }

    fn product(&mut self, v: &[f64], out: &mut [f64]) -> bool {
        if self.rows.held() {
            self.linearised.product(&self.tile, v, out);
            return true;
        }
        self.linearised.restart();
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(&self.linearised.w);
            self.tile.residuals(&self.divisor[first..]);
            self.linearised.product_of(&self.tile, v);
        }
        self.linearised.finish(out);
        true
    }

    fn curvature(&mut self, w: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        self.linearised.begin(w, false);
        for first in (0..self.rows.len()).step_by(TILE_ROWS) {
            if self.halts(first) {
                break;
            }
            self.load(first);
            self.tile.forward(w);
            self.tile.residuals(&self.divisor[first..]);
            let mut second = second_derivative(&self.tile, w, v);
            times(&mut second, &self.tile.s);
            self.linearised.note(&self.tile, &second);
        }
        self.linearised.finish(out);
        true
    }
}
