//! What the vectorised loops share: tiles of rows, fused multiply-add, tanh.
//!
//! Loops are written over fixed-size arrays and compiled once per instruction set by
//! `multiversion`; `FMA` says at compile time whether the set has a fused multiply-add,
//! because `f64::mul_add` without one is a slow library call.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Rows that are worked on together.
pub const TILE_ROWS: usize = 128;

/// One value for each row of a tile.
pub type TileLane = [f64; TILE_ROWS];

/// a b + c, rounded once where the instruction set can.
#[inline(always)]
pub fn fma<const FMA: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// [`fma`] of f32.
#[inline(always)]
pub(crate) fn single_fma<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// Σ x y over a tile, in eight sums of every eighth row that are added up in their order.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn dot(x: &TileLane, y: &TileLane) -> f64 {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        dot_sums::<true>(x, y)
    } else {
        dot_sums::<false>(x, y)
    }
}

#[inline(always)]
fn dot_sums<const FMA: bool>(x: &TileLane, y: &TileLane) -> f64 {
    let mut sums = [0.0; 8];
    for (x, y) in x.chunks_exact(8).zip(y.chunks_exact(8)) {
        for i in 0..8 {
            sums[i] = fma::<FMA>(x[i], y[i], sums[i]);
        }
    }
    sums.iter().sum()
}

/// tanh of every entry, within 2 ulp of the exact value; NaN stays NaN.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn tanh(values: &mut [f64]) {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        tanh_slice::<true>(values);
    } else {
        tanh_slice::<false>(values);
    }
}

#[inline(always)]
pub(crate) fn tanh_slice<const FMA: bool>(values: &mut [f64]) {
    for v in values {
        *v = tanh_one::<FMA>(*v);
    }
}

/// exp of every entry, at most `rrf_field::MAX_EXPONENT`; NaN stays NaN.
pub fn exponential(values: &mut [f64]) {
    for v in values {
        *v = v.min(f64::from(rrf_field::MAX_EXPONENT)).exp();
    }
}

/// Coefficients 1/k! of expm1, from k = 13 down to k = 2.
const TAYLOR: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    1.0 / 2.0,
];

/// tanh x = e / (e + 2) with e = expm1(2 |x|), sign of x.
///
/// 2|x| = n ln 2 + r with |r| ≤ ln 2 / 2, expm1 = 2^n expm1(r) + (2^n − 1), and expm1(r) by its
/// Taylor series to r^13 (remainder below 2e-17 of r). Without branches, so that it vectorises.
#[inline(always)]
fn tanh_one<const FMA: bool>(x: f64) -> f64 {
    // 1.5 · 2^52: adding it leaves the nearest integer in the lowest bits of the mantissa.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts; the first has 21 trailing zero bits, so n · LN2_HIGH is exact.
    const LN2_HIGH: f64 = 0.693_147_180_369_123_8;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    // Beyond 20, tanh is 1 to the last bit. A NaN compares false and goes on as NaN.
    let y = 2.0 * x.abs();
    let y = if y > 40.0 { 40.0 } else { y };
    let rounded = fma::<FMA>(y, std::f64::consts::LOG2_E, ROUND);
    let n = rounded - ROUND;
    let r = fma::<FMA>(n, -LN2_LOW, fma::<FMA>(n, -LN2_HIGH, y));
    let mut q = TAYLOR[0];
    for c in &TAYLOR[1..] {
        q = fma::<FMA>(q, r, *c);
    }
    let p = fma::<FMA>(q * r, r, r);
    let power = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1023 << 52));
    let e = fma::<FMA>(power, p, power - 1.0);
    (e / (e + 2.0)).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the standard library over all magnitudes: at most 3 ulp apart (each is within
    /// about 1 to 2 ulp of the truth), vector and scalar path.
    #[test]
    fn tanh_against_the_standard_library() {
        let mut x: Vec<f64> = (0..400_000)
            .map(|i| (f64::from(i) / 200_000.0 - 1.0) * 21.0)
            .collect();
        x.extend((0..600).map(|e| 10f64.powi(-e / 2) * 1.37));
        x.extend([0.0, -0.0, 19.9, 20.1, 1e300, -1e300, f64::INFINITY]);
        for path in [tanh as fn(&mut [f64]), tanh_slice::<false>] {
            let mut y = x.clone();
            path(&mut y);
            for (x, y) in x.iter().zip(&y) {
                let exact = x.tanh();
                let ulp = (y - exact).abs() / (exact.abs() * f64::EPSILON).max(f64::MIN_POSITIVE);
                assert!(ulp <= 3.0, "tanh({x}) = {y}, std {exact}, {ulp} ulp");
                assert!(y.abs() <= 1.0);
            }
        }
    }

    #[test]
    fn tanh_keeps_nan_and_is_odd() {
        let mut y = [f64::NAN, -0.7, 0.7];
        tanh(&mut y);
        assert!(y[0].is_nan());
        assert_eq!(y[1], -y[2]);
    }
}
