//! Row by row, the factors of the products that [`crate::net::blocks`] sums, in f64 or in f32.

use crate::net::gemm;
use crate::net::simd::{TILE_ROWS, TileLane};
use crate::net::tile::CHANNELS;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Numbers that the factors can be.
pub(crate) trait Real: Copy + Default + 'static {
    /// Rounded to this kind.
    fn of(x: f64) -> Self;
    /// The product of two.
    fn times(self, other: Self) -> Self;
    /// Up to [`STEP`] lanes as rows of that many values; the rest of each row is zero.
    fn transpose(lanes: &[TileLane], out: &mut [[Self; STEP]; TILE_ROWS]);
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
    /// Row by row, Σ_c y_cj z_ck for all (j, k), or for j ≤ k only; the channels of a row follow
    /// one another.
    fn over_channels(
        y: (&Packed<Self>, usize),
        z: (&Packed<Self>, usize),
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

/// Most values that a vector step reads or writes.
pub(crate) const STEP: usize = 16;

impl<T: Real> Packed<T> {
    pub fn new(width: usize) -> Packed<T> {
        let stride = width.next_multiple_of(STEP) + STEP;
        Packed {
            stride,
            values: vec![T::default(); stride * TILE_ROWS],
        }
    }

    /// The same with ones in the first column.
    pub fn with_ones(mut self) -> Packed<T> {
        for row in self.values.chunks_exact_mut(self.stride) {
            row[0] = T::of(1.0);
        }
        self
    }

    /// Lanes as columns, from `first` on, in whole vectors: what follows the last becomes zero.
    pub fn set(&mut self, first: usize, lanes: &[TileLane]) {
        let mut block = [[T::default(); STEP]; TILE_ROWS];
        for (at, lanes) in (first..).step_by(STEP).zip(lanes.chunks(STEP)) {
            T::transpose(lanes, &mut block);
            for (row, values) in self.values.chunks_exact_mut(self.stride).zip(&block) {
                row[at..][..STEP].copy_from_slice(values);
            }
        }
    }

    pub fn row(&self, row: usize) -> &[T] {
        &self.values[row * self.stride..][..self.stride]
    }
}

macro_rules! kernels {
    ($real:ty, $step:literal, $fma:path, $accumulate:path) => {
        /// Values of a vector step.
        const WIDE: usize = $step;

        impl Real for $real {
            #[inline(always)]
            fn of(x: f64) -> $real {
                x as $real
            }

            #[inline(always)]
            fn times(self, other: $real) -> $real {
                self * other
            }

            fn transpose(lanes: &[TileLane], out: &mut [[$real; STEP]; TILE_ROWS]) {
                transpose(lanes, out);
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
                y: (&Packed<$real>, usize),
                z: (&Packed<$real>, usize),
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

        /// The values of both halves in turn, which takes the first bit of a value's place to its
        /// end: as often as the step has bits, and lane by lane becomes row by row.
        #[inline(always)]
        fn riffle(from: &[$real], to: &mut [$real]) {
            let (a, b) = from.split_at(from.len() / 2);
            for ((to, a), b) in to.as_chunks_mut::<2>().0.iter_mut().zip(a).zip(b) {
                *to = [*a, *b];
            }
        }

        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn transpose(lanes: &[TileLane], out: &mut [[$real; STEP]; TILE_ROWS]) {
            let mut other = [0.0; STEP * TILE_ROWS];
            let out = out.as_flattened_mut();
            for (to, lane) in out.chunks_exact_mut(TILE_ROWS).zip(lanes) {
                for (to, x) in to.iter_mut().zip(lane) {
                    *to = *x as $real;
                }
            }
            out[lanes.len() * TILE_ROWS..].fill(0.0);
            for _ in 0..STEP.ilog2() / 2 {
                riffle(out, &mut other);
                riffle(&other, out);
            }
        }

        /// out = Σ_c v_c x_c for the `n` leading values of each x, in whole vectors: what is written
        /// past the end is overwritten by whatever comes next. `V` is how many vectors hold n
        /// values, or 0 where that is not known when this is compiled.
        #[inline(always)]
        fn combined<const C: usize, const V: usize, const FMA: bool>(
            v: [$real; C],
            x: [&[$real]; C],
            n: usize,
            out: &mut [$real],
        ) {
            let vectors = if V == 0 { n.div_ceil(WIDE) } else { V };
            let x = x.map(|x| &x.as_chunks::<WIDE>().0[..vectors]);
            let out = &mut out.as_chunks_mut::<WIDE>().0[..vectors];
            for (k, out) in out.iter_mut().enumerate() {
                let mut sum = x[0][k].map(|x| v[0] * x);
                for c in 1..C {
                    for (sum, x) in sum.iter_mut().zip(&x[c][k]) {
                        *sum = $fma(v[c], *x, *sum);
                    }
                }
                *out = sum;
            }
        }

        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn upper(z: &Packed<$real>, n: usize, rows: usize, ld: usize, out: &mut [$real]) {
            if n <= WIDE {
                products::<1, 1, false>((z, n), (z, n), true, rows, ld, out);
            } else {
                products::<1, 0, false>((z, n), (z, n), true, rows, ld, out);
            }
        }

        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn outer(
            y: (&Packed<$real>, usize),
            z: (&Packed<$real>, usize),
            rows: usize,
            ld: usize,
            out: &mut [$real],
        ) {
            match z.1.div_ceil(WIDE) {
                1 => products::<1, 1, false>(y, z, false, rows, ld, out),
                2 => products::<1, 2, false>(y, z, false, rows, ld, out),
                _ => products::<1, 0, false>(y, z, false, rows, ld, out),
            }
        }

        #[multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn over_channels(
            y: (&Packed<$real>, usize),
            z: (&Packed<$real>, usize),
            triangular: bool,
            rows: usize,
            ld: usize,
            out: &mut [$real],
        ) {
            if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
                match (triangular, z.1.div_ceil(WIDE)) {
                    (_, 1) => products::<CHANNELS, 1, true>(y, z, triangular, rows, ld, out),
                    (false, 2) => products::<CHANNELS, 2, true>(y, z, false, rows, ld, out),
                    _ => products::<CHANNELS, 0, true>(y, z, triangular, rows, ld, out),
                }
            } else {
                products::<CHANNELS, 0, false>(y, z, triangular, rows, ld, out);
            }
        }

        /// Row by row, Σ_c y_cj z_ck for all (j, k), or for j ≤ k only.
        #[inline(always)]
        fn products<const C: usize, const V: usize, const FMA: bool>(
            (y, n_y): (&Packed<$real>, usize),
            (z, n_z): (&Packed<$real>, usize),
            triangular: bool,
            rows: usize,
            ld: usize,
            out: &mut [$real],
        ) {
            for row in 0..rows {
                let (y, z) = (y.row(row), z.row(row));
                let y: [_; C] = std::array::from_fn(|c| &y[c * n_y..][..n_y]);
                let z: [_; C] = std::array::from_fn(|c| &z[c * n_z..]);
                let mut at = row * ld;
                for j in 0..n_y {
                    let first = if triangular { j } else { 0 };
                    let (v, x) = (y.map(|y| y[j]), z.map(|z| &z[first..]));
                    combined::<C, V, FMA>(v, x, n_z - first, &mut out[at..]);
                    at += n_z - first;
                }
            }
        }
    };
}

mod double {
    use super::*;
    use crate::net::simd::fma;
    kernels!(f64, 8, fma::<FMA>, gemm::accumulate);
}

mod single {
    use super::*;
    use crate::net::simd::single_fma;
    kernels!(f32, 16, single_fma::<FMA>, gemm::accumulate_single);
}

#[cfg(test)]
mod tests;
