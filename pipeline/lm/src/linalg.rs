//! Every call into LAPACK, through `ndarray-linalg`: Cholesky factors of small dense matrices.

use crate::blas::one_thread;
use ndarray::{ArrayView2, ArrayViewMut1, ArrayViewMut2, ShapeBuilder, ShapeError};
use ndarray_linalg::cholesky::{CholeskyFactorized, InverseCInto, SolveC};
use ndarray_linalg::{AllocatedArray, AllocatedArrayMut, Lapack, UPLO};

/// The matrix is not positive definite to working precision (or not finite).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("matrix of order {order} is not positive definite; more damping is needed")]
pub struct Indefinite {
    /// Rows of the matrix.
    pub order: usize,
}

/// A = L Lᵀ, with room that is used again from one factorisation to the next.
#[derive(Clone, Debug, Default)]
pub struct Cholesky {
    n: usize,
    /// Lᵀ, row-major; below its diagonal whatever was left there. LAPACK, which counts by columns,
    /// sees L, so nothing is transposed on the way in or out.
    factor: Vec<f64>,
}

impl Cholesky {
    /// Factors `matrix` (row-major, upper triangle read) with `add[i]` added to its diagonal.
    pub fn factor(&mut self, matrix: &[f64], add: &[f64]) -> Result<(), Indefinite> {
        one_thread();
        let n = add.len();
        let failed = Indefinite { order: n };
        self.n = n;
        self.factor.resize(n * n, 0.0);
        let rows = self.factor.chunks_exact_mut(n.max(1));
        for (i, (to, from)) in rows.zip(matrix.chunks_exact(n.max(1))).enumerate() {
            to[i..].copy_from_slice(&from[i..]);
            let d = &mut to[i];
            *d += add[i];
            // Some LAPACKs walk on through a NaN or a negative first pivot.
            if !(*d > 0.0 && d.is_finite()) {
                return Err(failed);
            }
        }
        if n > 0 {
            // Of the trait itself: `cholesky_inplace` clears the other triangle too.
            let mut view = columns(n, &mut self.factor).map_err(|_| failed)?;
            let layout = view.square_layout().map_err(|_| failed)?;
            let values = view.as_allocated_mut().map_err(|_| failed)?;
            f64::cholesky(layout, UPLO::Lower, values).map_err(|_| failed)?;
        }
        let finite = (0..n).all(|i| self.factor[i * n + i].is_finite());
        if finite { Ok(()) } else { Err(failed) }
    }

    fn factorised(&self) -> Option<CholeskyFactorized<ndarray::ViewRepr<&f64>>> {
        let factor = ArrayView2::from_shape((self.n, self.n).f(), &self.factor).ok()?;
        Some(CholeskyFactorized {
            factor,
            uplo: UPLO::Lower,
        })
    }

    /// Overwrites `b` with the solution of A x = b; fails where the solution is not finite.
    pub fn solve(&self, b: &mut [f64]) -> Result<(), Indefinite> {
        let failed = Indefinite { order: self.n };
        if self.n > 0 {
            let mut view = ArrayViewMut1::from_shape(self.n, b).map_err(|_| failed)?;
            let factor = self.factorised().ok_or(failed)?;
            factor.solvec_inplace(&mut view).map_err(|_| failed)?;
        }
        let finite = b.iter().all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(failed) }
    }

    /// A⁻¹, row-major; the factor is used up.
    pub fn inverse(&mut self) -> Result<&[f64], Indefinite> {
        let failed = Indefinite { order: self.n };
        if self.n > 0 {
            CholeskyFactorized {
                factor: columns(self.n, &mut self.factor).map_err(|_| failed)?,
                uplo: UPLO::Lower,
            }
            .invc_into()
            .map_err(|_| failed)?;
        }
        Ok(&self.factor)
    }
}

/// A square matrix as LAPACK counts it, column by column.
fn columns(n: usize, values: &mut [f64]) -> Result<ArrayViewMut2<'_, f64>, ShapeError> {
    ArrayViewMut2::from_shape((n, n).f(), values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A = M Mᵀ with a known M: the factor solves, the inverse inverts.
    #[test]
    fn solves_and_inverts() {
        let n = 7;
        let m: Vec<f64> = (0..n * n)
            .map(|i| ((i * 37 + 11) % 23) as f64 / 7.0)
            .collect();
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                a[i * n + j] = (0..n).map(|k| m[i * n + k] * m[j * n + k]).sum();
            }
        }
        let add = vec![0.5; n];
        let x: Vec<f64> = (0..n).map(|i| i as f64 - 2.5).collect();
        let mut b: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum::<f64>() + 0.5 * x[i])
            .collect();
        let right = b.clone();
        let mut cholesky = Cholesky::default();
        cholesky.factor(&a, &add).unwrap();
        cholesky.solve(&mut b).unwrap();
        for (b, x) in b.iter().zip(&x) {
            assert!((b - x).abs() < 1e-10, "{b} {x}");
        }
        let inverse = cholesky.inverse().unwrap();
        for i in 0..n {
            let y: f64 = (0..n).map(|j| inverse[i * n + j] * right[j]).sum();
            assert!((y - x[i]).abs() < 1e-10);
        }
    }

    #[test]
    fn refuses_what_is_not_positive_definite() {
        let mut c = Cholesky::default();
        for bad in [
            [1.0, 2.0, 2.0, 1.0],
            [-1.0, 0.0, 0.0, 1.0],
            [f64::NAN, 0.0, 0.0, 1.0],
            [1.0, f64::NAN, f64::NAN, 1.0],
            [0.0, 0.0, 0.0, 0.0],
        ] {
            let refused = c
                .factor(&bad, &[0.0; 2])
                .and_then(|()| c.solve(&mut [1.0, 1.0]));
            assert_eq!(refused, Err(Indefinite { order: 2 }));
        }
        assert_eq!(c.factor(&[], &[]), Ok(()));
    }
}
