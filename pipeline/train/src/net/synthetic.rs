//! Synthetic data for tests: random rows, and derivatives by dual numbers.

use crate::net::simd::TILE_ROWS;
use crate::net::tile::{Batch, CHANNELS, Rows};
use rrf_field::net::Shape;
use rrf_sampling::{Stage, Stream};

/// Random numbers in [−1, 1).
pub fn uniform(seed: u64, index: u64, dimension: u32) -> f64 {
    2.0 * Stream::new(seed, Stage::Test, 0).f64(index, dimension) - 1.0
}

/// Random weights in ±`size`.
pub fn weights(shape: &Shape, seed: u64, size: f64) -> Vec<f64> {
    (0..shape.weights())
        .map(|i| size * uniform(seed, i as u64, 7))
        .collect()
}

/// Random inputs and targets with unequal gains, some of them 0.
pub struct RandomRows {
    pub seed: u64,
    pub rows: usize,
}

impl RandomRows {
    /// Inputs, targets, gains and base of one row.
    pub fn row(&self, row: usize, inputs: usize) -> (Vec<f64>, [f64; 3], [f64; 3], f64) {
        let u = |d: usize| uniform(self.seed, row as u64, d as u32);
        let x = (0..inputs).map(|d| 1.7 * u(d)).collect();
        let target = std::array::from_fn(|c| u(40 + c));
        let gain = std::array::from_fn(|c| if row % 11 == c { 0.0 } else { 1.2 + u(50 + c) });
        (x, target, gain, 2.0 + u(60))
    }
}

impl Rows for RandomRows {
    fn len(&self) -> usize {
        self.rows
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        batch.rows = TILE_ROWS.min(self.rows - first);
        for i in 0..batch.rows {
            let (x, target, gain, base) = self.row(first + i, batch.x.len());
            for (lane, x) in batch.x.iter_mut().zip(x) {
                lane[i] = x;
            }
            for c in 0..CHANNELS {
                batch.target[c][i] = target[c];
                batch.gain[c][i] = gain[c];
            }
            batch.base[i] = base;
        }
    }
}

/// Outputs of the net and their derivatives along `direction` in weight space, exact to
/// rounding: forward differentiation of the plain scalar evaluation.
pub fn derivative(shape: &Shape, w: &[f64], direction: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let layers = shape.sizes.len() - 1;
    let (mut value, mut slope) = (x.to_vec(), vec![0.0; x.len()]);
    for (layer, start) in shape.offsets().into_iter().enumerate() {
        let n = shape.sizes[layer];
        let mut next = (Vec::new(), Vec::new());
        for unit in 0..shape.sizes[layer + 1] {
            let at = start + unit * (n + 1);
            let (mut z, mut dz) = (w[at], direction[at]);
            for i in 0..n {
                z += w[at + 1 + i] * value[i];
                dz += direction[at + 1 + i] * value[i] + w[at + 1 + i] * slope[i];
            }
            if layer + 1 < layers {
                let h = z.tanh();
                (z, dz) = (h, dz * (1.0 - h * h));
            }
            next.0.push(z);
            next.1.push(dz);
        }
        (value, slope) = next;
    }
    (value, slope)
}
