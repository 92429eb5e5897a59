//! The directions of a cell: the combinations of lights that its rows need.

use ndarray::{Array1, Array2, Axis};

/// A light that gives a cell less than this share of what the mean light gives counts as if it gave
/// that.
const FLOOR: f64 = 0.05;

/// Weights of lights of which a cell makes these squares: errors under each count relative to it.
pub(crate) fn relative_weights(squares: &[f64]) -> Vec<f64> {
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let least = (FLOOR * FLOOR * mean).max(f64::MIN_POSITIVE);
    squares.iter().map(|s| 1.0 / s.max(least)).collect()
}

/// The directions of a cell's rows.
pub(crate) struct Directions {
    pub(crate) rank: usize,
    /// Shape [3 rows, rank]: orthonormal combinations of the weighted channel rows.
    pub(crate) left: Array2<f64>,
    pub(crate) values: Array1<f64>,
    /// Shape [rank, lights].
    pub(crate) right: Array2<f64>,
}

impl Directions {
    /// The directions without which more than `allowed` of the light would be left out, relative to what
    /// each light gives, each direction taken as far as it is borne out in a part.
    pub(crate) fn needed(&self, borne: &[Vec<f32>; 2], allowed: f64) -> Vec<usize> {
        let square = |k: usize, l: usize| (self.values[k] * self.right[[k, l]]).powi(2);
        let lights = 0..self.right.ncols();
        let gives: Vec<f64> = lights
            .map(|l| (0..self.rank).map(|k| square(k, l)).sum())
            .collect();
        let weights = relative_weights(&gives);
        let energy = |k: usize| -> f64 {
            let by = borne.iter().map(|part| part[k]).fold(0.0f32, f32::max);
            let of = |(l, w): (usize, &f64)| w * square(k, l);
            f64::from(by).powi(2) * weights.iter().enumerate().map(of).sum::<f64>()
        };
        let mut order: Vec<usize> = (0..self.rank).collect();
        order.sort_by(|&a, &b| energy(a).total_cmp(&energy(b)).then(b.cmp(&a)));
        let whole: f64 = weights.iter().zip(&gives).map(|(w, g)| w * g).sum();
        let (mut rest, most) = (0.0, allowed.powi(2) * whole);
        let needed = |&k: &usize| {
            rest += energy(k);
            rest > most
        };
        let last = order.last().copied();
        let mut kept: Vec<usize> = order.into_iter().filter(needed).collect();
        if kept.is_empty() {
            kept.extend(last);
        }
        kept.sort_unstable();
        kept
    }

    /// Some of the directions.
    pub(crate) fn only(&self, kept: &[usize]) -> Directions {
        Directions {
            rank: kept.len(),
            left: self.left.select(Axis(1), kept),
            values: self.values.select(Axis(0), kept),
            right: self.right.select(Axis(0), kept),
        }
    }

    /// A part of a row, shape [3, lights], in the directions: shape [rank, 3].
    pub(crate) fn made(&self, part: &[f32]) -> Vec<f32> {
        let lights = self.right.ncols().max(1);
        let mut out = vec![0.0f32; 3 * self.rank];
        for (k, (right, value)) in self.right.rows().into_iter().zip(&self.values).enumerate() {
            for (channel, lit) in part.chunks_exact(lights).enumerate() {
                let sum: f64 = lit.iter().zip(right).map(|(x, v)| f64::from(*x) * v).sum();
                out[3 * k + channel] = (sum / value.max(f64::MIN_POSITIVE)) as f32;
            }
        }
        out
    }
}
