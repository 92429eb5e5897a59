//! The few directions that the rows of one cell need of the basis.

use super::svd::leading;
use crate::TransferError;
use crate::tracing::Stream;
use glam::Vec3;
use ndarray::Array2;

/// Directions of a cell: `rank` of the basis' dimensions.
#[derive(Clone, Debug)]
pub struct CellBasis {
    /// How many directions.
    pub rank: usize,
    /// Shape [rank, dimensions of the basis], row-major: coefficients of a light in the cell.
    pub read: Vec<f32>,
    /// Shape [dimensions of the basis, rank], row-major: what a projected row is projected onto.
    pub make: Vec<f32>,
    /// Relative error that the directions left out make, over rows and lights, noise taken out.
    pub error: f64,
}

/// A cell's rows in a basis: for both halves, shape [channel rows, dimensions].
pub type Halves<'a> = [&'a Array2<f64>; 2];

impl CellBasis {
    /// The least number of directions that leaves out at most `target` of the light, up to `most`.
    ///
    /// `rows` are weighted projections of channel rows; `lights` the weighted coefficients of the
    /// ensemble's lights, shape [dimensions, lights]. The directions are those of the first half;
    /// the error they make is the product of both halves' errors, whose noise is independent.
    pub fn new(
        rows: Halves,
        lights: &Array2<f64>,
        target: f64,
        most: usize,
        stream: Stream,
    ) -> Result<CellBasis, TransferError> {
        let [first, second] = rows.map(|half| half.dot(lights));
        let most = most.min(lights.nrows()).max(1);
        let found = leading(&first, most, stream)?;
        let count = first.len().max(1) as f64;
        let (mut rest, mut other) = (first, second);
        let mut kept = 0;
        let mut error = mean_product(&rest, &other, count);
        while kept < found.values.len() && error > target {
            if found.values[kept] <= 0.0 {
                break;
            }
            let direction = found.left.column(kept);
            for half in [&mut rest, &mut other] {
                let along = direction.dot(half);
                for (r, &d) in direction.iter().enumerate() {
                    half.row_mut(r).scaled_add(-d, &along);
                }
            }
            kept += 1;
            error = mean_product(&rest, &other, count);
        }
        let mean = (rows[0] + rows[1]) * 0.5;
        let kept = kept.max(1).min(found.values.len());
        let left = found.left.slice(ndarray::s![.., ..kept]);
        let read = left.t().dot(&mean);
        let right = found.right.slice(ndarray::s![..kept, ..]);
        let make = lights.dot(&right.t()) / found.values.slice(ndarray::s![..kept]);
        Ok(CellBasis {
            rank: kept,
            read: read.iter().map(|&x| x as f32).collect(),
            make: make.iter().map(|&x| x as f32).collect(),
            error,
        })
    }

    /// Coefficients of a light in the cell from those in the basis.
    pub fn coefficients(&self, basis: &[Vec3]) -> Vec<Vec3> {
        super::products(&self.read, basis.len(), basis)
    }
}

/// Root of the mean product of two halves' errors; 0 where noise makes it negative.
fn mean_product(a: &Array2<f64>, b: &Array2<f64>, count: f64) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    (sum / count).max(0.0).sqrt()
}
