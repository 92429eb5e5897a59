//! A net with one hidden layer and many linear outputs, and the same under one light.

use super::packed::PackedRows;
use crate::query::INPUTS;
use glam::Vec3;

/// A net with one hidden layer of tanh units, and linear outputs of 1, the inputs and the units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferNet {
    /// Which inputs it sees.
    pub inputs: Vec<u8>,
    /// Mean of each.
    pub mean: Vec<f32>,
    /// 1 / deviation of each.
    pub scale: Vec<f32>,
    /// Least and largest of each that it was fitted to, scaled: beyond them it only guesses.
    pub low: Vec<f32>,
    /// See `low`.
    pub high: Vec<f32>,
    /// Shape [units, inputs + 1] row-major, the constant last.
    pub hidden: Vec<f32>,
    /// Shape [1 + inputs + units, outputs].
    pub output: PackedRows<i16>,
}

impl TransferNet {
    /// How many hidden units.
    pub fn units(&self) -> usize {
        self.hidden.len() / (self.inputs.len() + 1)
    }

    /// How many numbers the outputs are combinations of.
    pub fn features(&self) -> usize {
        1 + self.inputs.len() + self.units()
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        4 * (4 * self.inputs.len() + self.hidden.len()) + self.output.bytes()
    }

    /// The outputs for a light: each row of output weights, shape [rank, 3], with the light's
    /// coefficients. What is left is one output a channel, shape \[features\].
    pub fn contract(&self, coefficients: &[Vec3]) -> Vec<Vec3> {
        super::sums::contract(&self.output, coefficients)
    }

    /// One output a channel for a point, under a contracted light.
    #[inline]
    pub fn evaluate(&self, all: &[f32; INPUTS], contracted: &[Vec3]) -> Vec3 {
        let mut x = [0.0f32; INPUTS];
        let d = self.inputs.len();
        for (j, x) in x.iter_mut().take(d).enumerate() {
            let scaled = (all[self.inputs[j] as usize] - self.mean[j]) * self.scale[j];
            *x = scaled.clamp(self.low[j], self.high[j]);
        }
        let (first, units) = contracted.split_at(1 + d);
        let mut sum = first.first().copied().unwrap_or_default();
        for (w, x) in first[1..].iter().zip(&x) {
            sum += *w * *x;
        }
        for (w, h) in units.iter().zip(self.hidden.chunks_exact(d + 1)) {
            let mut z = h[d];
            for (h, x) in h[..d].iter().zip(&x) {
                z += h * x;
            }
            sum += *w * z.tanh();
        }
        sum
    }

    /// How far a point lies outside of what the net was fitted to, in deviations.
    pub fn beyond(&self, all: &[f32; INPUTS]) -> f32 {
        let mut most = 0.0f32;
        for (j, &input) in self.inputs.iter().enumerate() {
            let x = (all[input as usize] - self.mean[j]) * self.scale[j];
            most = most.max(self.low[j] - x).max(x - self.high[j]);
        }
        most
    }
}
