//! The directions of a cell: the combinations of lights that its rows need.

use ndarray::{Array1, Array2};

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
