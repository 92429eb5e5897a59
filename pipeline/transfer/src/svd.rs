//! Every call into LAPACK: the leading singular vectors of a large matrix.

use crate::TransferError;
use crate::tracing::Stream;
use ndarray::{Array1, Array2, s};
use ndarray_linalg::error::LinalgError;
use ndarray_linalg::{JobSvd, QR, SVDDC};
use rrf_lm::one_thread;

/// Directions that the range finder takes beyond the rank asked for.
const MORE: usize = 10;
/// Power iterations: each cubes the ratio of wanted to unwanted singular values.
const POWER: usize = 2;

/// The leading part of M = U diag(s) V': columns of U, s, rows of V'.
pub(crate) struct Leading {
    pub(crate) left: Array2<f64>,
    pub(crate) values: Array1<f64>,
    pub(crate) right: Array2<f64>,
}

/// The `rank` largest singular values of a matrix and their vectors; fewer where it has fewer.
///
/// A randomised range finder with power iterations, then an exact decomposition of the small rest
/// (Halko, Martinsson, Tropp, *Finding Structure with Randomness*, SIAM Review 2011, algorithms
/// 4.4 and 5.1); the exact decomposition alone where the matrix is small.
pub(crate) fn leading(
    matrix: &Array2<f64>,
    rank: usize,
    stream: Stream,
) -> Result<Leading, TransferError> {
    one_thread();
    let (rows, columns) = matrix.dim();
    let width = (rank + MORE).min(rows).min(columns);
    if 3 * width >= rows.min(columns) {
        return exact(matrix, rank);
    }
    let start = Array2::from_shape_fn((columns, width), |(i, j)| normal(stream, i, j));
    let mut range = orthonormal(matrix.dot(&start))?;
    for _ in 0..POWER {
        let back = orthonormal(matrix.t().dot(&range))?;
        range = orthonormal(matrix.dot(&back))?;
    }
    let small = exact(&range.t().dot(matrix), rank)?;
    Ok(Leading {
        left: range.dot(&small.left),
        ..small
    })
}

fn exact(matrix: &Array2<f64>, rank: usize) -> Result<Leading, TransferError> {
    let failed = |error: LinalgError| failure(matrix, &error);
    let (left, values, right) = matrix.svddc(JobSvd::Some).map_err(failed)?;
    let kept = rank.min(values.len());
    match (left, right) {
        (Some(left), Some(right)) => Ok(Leading {
            left: left.slice(s![.., ..kept]).to_owned(),
            values: values.slice(s![..kept]).to_owned(),
            right: right.slice(s![..kept, ..]).to_owned(),
        }),
        _ => Err(failure(matrix, &"no singular vectors were returned")),
    }
}

/// An orthonormal basis of a tall matrix' columns.
fn orthonormal(matrix: Array2<f64>) -> Result<Array2<f64>, TransferError> {
    let (q, _) = matrix.qr().map_err(|error| failure(&matrix, &error))?;
    Ok(q)
}

fn failure(matrix: &Array2<f64>, reason: &dyn std::fmt::Display) -> TransferError {
    TransferError::Factorisation {
        rows: matrix.nrows(),
        columns: matrix.ncols(),
        reason: reason.to_string(),
    }
}

/// A standard normal number by its indices (Box and Muller 1958).
fn normal(stream: Stream, i: usize, j: usize) -> f64 {
    let [a, b, ..] = stream.units(i as u64, j as u32, 0).map(f64::from);
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with known singular values: the randomised decomposition finds the leading ones,
    /// orthonormal vectors, and the best approximation of that rank.
    #[test]
    fn finds_the_leading_part() {
        let stream = Stream::new(3, rrf_sampling::Stage::Test, 0);
        let draw = |rows, columns, part| {
            let stream = stream.part(part);
            let m = Array2::from_shape_fn((rows, columns), |(i, j)| normal(stream, i, j));
            orthonormal(m).unwrap()
        };
        let (u, v) = (draw(300, 120, 1), draw(200, 120, 2));
        let values = Array1::from_shape_fn(120, |i| 0.8f64.powi(i as i32));
        let matrix = (&u * &values).dot(&v.t());
        let found = leading(&matrix, 12, stream).unwrap();
        for (k, &value) in found.values.iter().enumerate() {
            assert!((value / values[k] - 1.0).abs() < 1e-6, "value {k}: {value}");
        }
        let gram = found.left.t().dot(&found.left) - Array2::<f64>::eye(12);
        assert!(gram.iter().all(|x| x.abs() < 1e-10));
        let rest = &matrix - (&found.left * &found.values).dot(&found.right);
        let norm: f64 = rest.iter().map(|x| x * x).sum::<f64>().sqrt();
        let best: f64 = values.iter().skip(12).map(|x| x * x).sum::<f64>().sqrt();
        assert!(norm < 1.001 * best, "{norm} {best}");
    }
}
