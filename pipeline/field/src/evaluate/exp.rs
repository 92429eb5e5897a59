//! An exponential for f32 columns.

use super::tanh::{horner, multiply_add};

/// Largest exponent of a net whose outputs are exponents: e^12 = 163,000 times the mean radiance
/// of its cell. It keeps a net that is asked far outside its rows from overflowing.
pub const MAX_EXPONENT: f32 = 12.0;

/// Below this the result is no longer a normal f32; the argument is held there.
const LEAST_EXPONENT: f32 = -87.0;

/// Largest relative error of `exp` on its range, in both forms.
pub const EXP_ERROR: f32 = 3.0e-7;

/// Coefficients 1/k! from k = 0: the remainder at |r| = ln 2 / 2 is 0.35^8 / 8! = 5e-9.
const TAYLOR: [f32; 8] = [
    1.0,
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
];

/// exp(x) for x at most [`MAX_EXPONENT`] (larger ones are held there), within [`EXP_ERROR`]
/// relative; NaN stays NaN. x = n ln 2 + r, exp(x) = 2^n exp(r).
///
/// `FUSED` as in [`super::tanh::rational_tanh`].
#[inline(always)]
pub fn exp<const FUSED: bool>(x: f32) -> f32 {
    // 1.5 · 2^23: adding it leaves the nearest integer in the lowest bits of the mantissa.
    const ROUND: f32 = 12_582_912.0;
    // ln 2 in two parts; the first has 9 significant bits, so n · LN2_HIGH is exact.
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let x = x.clamp(LEAST_EXPONENT, MAX_EXPONENT);
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = multiply_add::<FUSED>(n, -LN2_LOW, multiply_add::<FUSED>(n, -LN2_HIGH, x));
    let power = f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23));
    power * horner::<FUSED, 8>(&TAYLOR, r)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the standard library in f64, on a dense grid and beyond its ends.
    #[test]
    fn stays_within_the_stated_error() {
        for f in [exp::<false> as fn(f32) -> f32, exp::<true>] {
            for i in 0..=2_000_000 {
                let x = LEAST_EXPONENT + (MAX_EXPONENT - LEAST_EXPONENT) * (i as f32 / 2e6);
                let error = (f64::from(f(x)) / f64::from(x).exp() - 1.0).abs();
                assert!(error < f64::from(EXP_ERROR), "exp({x}): {error:e}");
            }
            assert_eq!(f(1e30), f(MAX_EXPONENT));
            assert!(f(-1e30) > 0.0 && f(-1e30) < 1e-37);
            assert!(f(f32::NAN).is_nan());
        }
    }
}
