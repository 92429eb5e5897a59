//! Row by row, the factors of the products that [`crate::blocks`] sums, in f64 or in f32.

use crate::gemm;
use crate::simd::{Lane, TILE};
use multiversion::multiversion;

/// Numbers that the factors can be.
pub(crate) trait Real: Copy + Default + 'static {
    /// Rounded to this kind.
    fn of(x: f64) -> Self;
    /// The product of two.
    fn times(self, other: Self) -> Self;
    /// Row by row, all products of z's entries a ≤ b.
    fn upper(z: &Packed<Self>, n: usize, rows: usize, ld: usize, out: &mut [Self]);
    /// Row by row, all products of an entry of y with an entry of z.
    fn outer(
        y: (&Packed<Self>, usize),
        z: (&Packed<Self>, usize),
        rows: usize,
        ld: usize,
        out: &mut [Self],
    );
    /// Row by row, Σ_c y_cj z_ck for all (j, k), or for j ≤ k only.
    fn over_channels(
        y: (&[Packed<Self>], usize),
        z: (&[Packed<Self>], usize),
        triangular: bool,
        rows: usize,
        ld: usize,
        out: &mut [Self],
    );
    /// C += Aᵀ B, see [`gemm`].
    fn accumulate(a: &[Self], lda: usize, b: &[Self], ldb: usize, c: &mut [f64]);
}

/// Rows of one width, padded with zeros so that whole vectors can be read past the end.
pub(crate) struct Packed<T> {
    pub stride: usize,
    values: Vec<T>,
}

/// Values a vector step reads or writes.
pub(crate) const STEP: usize = 8;

impl<T: Real> Packed<T> {
    pub fn new(width: usize) -> Packed<T> {
        let stride = width.next_multiple_of(STEP) + STEP;
        Packed {
            stride,
            values: vec![T::default(); stride * TILE],
        }
    }

    pub fn set(&mut self, column: usize, lane: &Lane) {
        for (row, value) in self.values.chunks_exact_mut(self.stride).zip(lane) {
            row[column] = T::of(*value);
        }
    }

    pub fn row(&self, row: usize) -> &[T] {
        &self.values[row * self.stride..][..self.stride]
    }
}

macro_rules! kernels {
    ($real:ty, $accumulate:path) => {
        impl Real for $real {
            #[inline(always)]
            fn of(x: f64) -> $real {
                x as $real
            }

            #[inline(always)]
            fn times(self, other: $real) -> $real {
                self * other
            }

            fn upper(z: &Packed<$real>, n: usize, rows: usize, ld: usize, out: &mut [$real]) {
                upper(z, n, rows, ld, out);
            }

            fn outer(
                y: (&Packed<$real>, usize),
                z: (&Packed<$real>, usize),
                rows: usize,
                ld: usize,
                out: &mut [$real],
            ) {
                outer(y, z, rows, ld, out);
            }

            fn over_channels(
                y: (&[Packed<$real>], usize),
                z: (&[Packed<$real>], usize),
                triangular: bool,
                rows: usize,
                ld: usize,
                out: &mut [$real],
            ) {
                over_channels(y, z, triangular, rows, ld, out);
            }

            fn accumulate(a: &[$real], lda: usize, b: &[$real], ldb: usize, c: &mut [f64]) {
                $accumulate(a, lda, b, ldb, c);
            }
        }

        /// out = v · x for the `n` leading values of x, in whole vectors: up to seven values past the
        /// end are written too, and overwritten by whatever comes next.
        #[inline(always)]
        fn scaled(v: $real, x: &[$real], n: usize, out: &mut [$real]) {
            for (x, out) in x
                .chunks_exact(STEP)
                .zip(out.chunks_exact_mut(STEP))
                .take(n.div_ceil(STEP))
            {
                for i in 0..STEP {
                    out[i] = v * x[i];
                }
            }
        }

        /// Row by row, all products of z's entries a ≤ b.
        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn upper(z: &Packed<$real>, n: usize, rows: usize, ld: usize, out: &mut [$real]) {
            for row in 0..rows {
                let z = z.row(row);
                let mut at = row * ld;
                for a in 0..n {
                    scaled(z[a], &z[a..], n - a, &mut out[at..]);
                    at += n - a;
                }
            }
        }

        /// Row by row, all products of an entry of y with an entry of z.
        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn outer(
            (y, n_y): (&Packed<$real>, usize),
            (z, n_z): (&Packed<$real>, usize),
            rows: usize,
            ld: usize,
            out: &mut [$real],
        ) {
            for row in 0..rows {
                let (y, z) = (y.row(row), z.row(row));
                let mut at = row * ld;
                for v in &y[..n_y] {
                    scaled(*v, z, n_z, &mut out[at..]);
                    at += n_z;
                }
            }
        }

        /// Row by row, Σ_c y_cj z_ck for all (j, k), or for j ≤ k only.
        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn over_channels(
            (y, n_y): (&[Packed<$real>], usize),
            (z, n_z): (&[Packed<$real>], usize),
            triangular: bool,
            rows: usize,
            ld: usize,
            out: &mut [$real],
        ) {
            let ([y0, y1, y2], [z0, z1, z2]) = (y, z) else {
                return;
            };
            for row in 0..rows {
                let (y0, y1, y2) = (y0.row(row), y1.row(row), y2.row(row));
                let (z0, z1, z2) = (z0.row(row), z1.row(row), z2.row(row));
                let mut at = row * ld;
                for j in 0..n_y {
                    let first = if triangular { j } else { 0 };
                    let n = n_z - first;
                    let (v0, v1, v2) = (y0[j], y1[j], y2[j]);
                    let x0 = z0[first..].chunks_exact(STEP);
                    let x1 = z1[first..].chunks_exact(STEP);
                    let x2 = z2[first..].chunks_exact(STEP);
                    let steps = x0.zip(x1).zip(x2).zip(out[at..].chunks_exact_mut(STEP));
                    for (((x0, x1), x2), out) in steps.take(n.div_ceil(STEP)) {
                        for i in 0..STEP {
                            out[i] = v0 * x0[i] + v1 * x1[i] + v2 * x2[i];
                        }
                    }
                    at += n;
                }
            }
        }
    };
}

mod double {
    use super::*;
    kernels!(f64, gemm::accumulate);
}

mod single {
    use super::*;
    kernels!(f32, gemm::accumulate_single);
}
