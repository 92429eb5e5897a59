//! Row by row, the factors of the products that [`crate::blocks`] sums.

use crate::simd::{Lane, TILE};
use multiversion::multiversion;

/// Rows of one width, padded with zeros so that whole vectors can be read past the end.
pub(crate) struct Packed {
    pub stride: usize,
    values: Vec<f64>,
}

/// Values a vector step reads or writes.
pub(crate) const STEP: usize = 8;

impl Packed {
    pub fn new(width: usize) -> Packed {
        let stride = width.next_multiple_of(STEP) + STEP;
        Packed {
            stride,
            values: vec![0.0; stride * TILE],
        }
    }

    pub fn set(&mut self, column: usize, lane: &Lane) {
        for (row, value) in self.values.chunks_exact_mut(self.stride).zip(lane) {
            row[column] = *value;
        }
    }

    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.stride..][..self.stride]
    }
}

pub(crate) fn copy(source: &Packed, rows: usize, ld: usize, out: &mut [f64]) {
    let width = ld.min(source.stride);
    for (row, out) in out.chunks_exact_mut(ld).take(rows).enumerate() {
        out[..width].copy_from_slice(&source.row(row)[..width]);
    }
}

/// out = v · x for the `n` leading values of x, in whole vectors: up to seven values past the
/// end are written too, and overwritten by whatever comes next.
#[inline(always)]
fn scaled(v: f64, x: &[f64], n: usize, out: &mut [f64]) {
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
pub(crate) fn upper(z: &Packed, n: usize, rows: usize, ld: usize, out: &mut [f64]) {
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
pub(crate) fn outer(
    y: &Packed,
    n_y: usize,
    z: &Packed,
    n_z: usize,
    rows: usize,
    ld: usize,
    out: &mut [f64],
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
pub(crate) fn over_channels(
    (y, n_y): (&[Packed], usize),
    (z, n_z): (&[Packed], usize),
    triangular: bool,
    rows: usize,
    ld: usize,
    out: &mut [f64],
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
