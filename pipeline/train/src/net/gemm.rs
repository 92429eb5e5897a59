//! C += Aᵀ B over the rows of a tile, the one dense kernel of the trainer.
//!
//! A is `[rows, lda]`, B is `[rows, ldb]`, C is `[m, ldc]`, all row-major. The entry C(i, j)
//! is summed over the rows in their order, whatever the instruction set's block is. A and B are
//! f64, or f32 with the sums of one tile in f32: twice as many numbers a vector. C is f64.

use crate::net::simd::{fma, single_fma};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Columns of A are padded to a multiple of this.
pub const PAD_A: usize = 8;
/// Columns of B are padded to a multiple of this.
pub const PAD_B: usize = 48;

/// C += Aᵀ B. `lda` and `ldc`'s row count are multiples of [`PAD_A`], `ldb` of [`PAD_B`];
/// `ldc` equals `ldb`. Columns beyond the used ones may hold any finite values.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
// In any one copy, two of the conditions are the same constant.
#[allow(clippy::ifs_same_cond)]
pub fn accumulate(a: &[f64], lda: usize, b: &[f64], ldb: usize, c: &mut [f64]) {
    if target_cfg_f!(target_feature = "avx512f") {
        blocks_8_24::<true>(a, lda, b, ldb, c);
    } else if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        blocks_4_8::<true>(a, lda, b, ldb, c);
    } else {
        blocks_4_8::<false>(a, lda, b, ldb, c);
    }
}

/// [`accumulate`] of f32 factors; the tile's sums are f32.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
#[allow(clippy::ifs_same_cond)]
pub fn accumulate_single(a: &[f32], lda: usize, b: &[f32], ldb: usize, c: &mut [f64]) {
    if target_cfg_f!(target_feature = "avx512f") {
        single_8_48::<true>(a, lda, b, ldb, c);
    } else if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        single_4_16::<true>(a, lda, b, ldb, c);
    } else {
        single_4_16::<false>(a, lda, b, ldb, c);
    }
}

/// One row of a block of accumulators.
macro_rules! row {
    ($name:ident, $real:ty, $fma:path) => {
        #[inline(always)]
        fn $name<const N: usize, const FMA: bool>(
            mut sum: [$real; N],
            x: $real,
            y: &[$real; N],
        ) -> [$real; N] {
            for j in 0..N {
                sum[j] = $fma(x, y[j], sum[j]);
            }
            sum
        }
    };
}

row!(row, f64, fma::<FMA>);
row!(row_single, f32, single_fma::<FMA>);

/// C in blocks of `$m` x `$n` accumulators that stay in registers while the rows go by.
/// Each row of a block is a variable of its own: as one array of arrays they end up in memory,
/// thirty times slower.
macro_rules! blocks {
    ($name:ident, $real:ty, $row:ident, $m:literal, $n:literal, $($i:literal $sum:ident),*) => {
        #[inline(always)]
        pub(crate) fn $name<const FMA: bool>(
            a: &[$real],
            lda: usize,
            b: &[$real],
            ldb: usize,
            c: &mut [f64],
        ) {
            for at_b in (0..ldb).step_by($n) {
                for at_a in (0..lda).step_by($m) {
                    $(let mut $sum = [0.0; $n];)*
                    for (x, y) in a.chunks_exact(lda).zip(b.chunks_exact(ldb)) {
                        let (Some(x), Some(y)) =
                            (x[at_a..].first_chunk::<$m>(), y[at_b..].first_chunk::<$n>())
                        else {
                            return;
                        };
                        $($sum = $row::<$n, FMA>($sum, x[$i], y);)*
                    }
                    $(for (c, s) in c[(at_a + $i) * ldb + at_b..][..$n].iter_mut().zip(&$sum) {
                        *c += f64::from(*s);
                    })*
                }
            }
        }
    };
}

blocks!(blocks_8_24, f64, row, 8, 24, 0 s0, 1 s1, 2 s2, 3 s3, 4 s4, 5 s5, 6 s6, 7 s7);
blocks!(blocks_4_8, f64, row, 4, 8, 0 s0, 1 s1, 2 s2, 3 s3);
blocks!(single_8_48, f32, row_single, 8, 48, 0 s0, 1 s1, 2 s2, 3 s3, 4 s4, 5 s5, 6 s6, 7 s7);
blocks!(single_4_16, f32, row_single, 4, 16, 0 s0, 1 s1, 2 s2, 3 s3);

#[cfg(test)]
mod tests {
    use super::*;

    /// The dispatched kernel, the plain one and a triple loop; integers, so exactly equal.
    #[test]
    fn equals_the_triple_loop() {
        for (rows, lda, ldb) in [(1, 8, 48), (5, 16, 96), (128, 24, 144), (0, 8, 48)] {
            let a: Vec<f64> = (0..rows * lda)
                .map(|i| ((i * 7) % 19) as f64 - 9.0)
                .collect();
            let b: Vec<f64> = (0..rows * ldb)
                .map(|i| ((i * 5) % 23) as f64 - 11.0)
                .collect();
            let mut expected = vec![1.0; lda * ldb];
            for r in 0..rows {
                for i in 0..lda {
                    for j in 0..ldb {
                        expected[i * ldb + j] += a[r * lda + i] * b[r * ldb + j];
                    }
                }
            }
            for kernel in [accumulate, blocks_4_8::<false>, blocks_8_24::<false>] {
                let mut c = vec![1.0; lda * ldb];
                kernel(&a, lda, &b, ldb, &mut c);
                assert_eq!(c, expected);
            }
            let [a, b] = [&a, &b].map(|x| x.iter().map(|&x| x as f32).collect::<Vec<f32>>());
            for kernel in [
                accumulate_single,
                single_4_16::<false>,
                single_8_48::<false>,
            ] {
                let mut c = vec![1.0; lda * ldb];
                kernel(&a, lda, &b, ldb, &mut c);
                assert_eq!(c, expected);
            }
        }
    }
}
