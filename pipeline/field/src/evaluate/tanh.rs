//! A rational tanh for f32 columns.

/// Where the argument is clamped: 1 − tanh(8) = 2.3e-7, below the error of the fit.
const BOUND: f32 = 8.0;

/// Numerator and denominator of tanh(x)/x in x², constant term first.
/// Minimax in relative error on [0, 8] by the differential-correction algorithm
/// (Barrodale, Powell, Roberts 1972), then rounded to f32. All positive: no cancellation.
const P: [f32; 4] = [0.999_999_9, 0.129_180_13, 2.942_894_8e-3, 1.134_389_4e-5];
const Q: [f32; 5] = [
    1.0,
    0.462_512_28,
    2.378_201_9e-2,
    2.375_379_1e-4,
    2.432_978_8e-7,
];

/// Largest relative error of `rational_tanh` over all finite f32, in both forms.
pub const TANH_ERROR: f32 = 5.0e-7;

/// tanh(x) within [`TANH_ERROR`] relative; NaN stays NaN.
///
/// `FUSED` chooses fused multiply-add; set it only inside a function compiled for a processor
/// that has it, elsewhere each one is a library call.
#[inline(always)]
pub fn rational_tanh<const FUSED: bool>(x: f32) -> f32 {
    let x = x.clamp(-BOUND, BOUND);
    let t = x * x;
    let p = horner::<FUSED, 4>(&P, t);
    let q = horner::<FUSED, 5>(&Q, t);
    x * p / q
}

/// a·b + c, fused or rounded twice.
#[inline(always)]
pub fn multiply_add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
pub fn horner<const FUSED: bool, const N: usize>(coefficients: &[f32; N], t: f32) -> f32 {
    let mut sum = coefficients[N - 1];
    for k in (0..N - 1).rev() {
        sum = multiply_add::<FUSED>(sum, t, coefficients[k]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(f: fn(f32) -> f32) -> f64 {
        // Every 509th positive f32 (a prime step: all exponents and mantissa patterns), and oddness.
        let mut worst = 0.0f64;
        for bits in (1..f32::INFINITY.to_bits()).step_by(509) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).tanh();
            if exact < f64::from(f32::MIN_POSITIVE) {
                continue; // subnormal results have no relative precision to keep
            }
            worst = worst.max((f64::from(f(x)) / exact - 1.0).abs());
            assert_eq!(f(x).to_bits(), (-f(-x)).to_bits(), "odd at {x}");
        }
        worst
    }

    #[test]
    fn stays_within_the_stated_error() {
        for f in [rational_tanh::<false>, rational_tanh::<true>] {
            let worst = worst(f);
            assert!(worst < f64::from(TANH_ERROR), "relative error {worst:e}");
        }
    }

    #[test]
    fn keeps_nan_zero_and_infinity() {
        assert!(rational_tanh::<false>(f32::NAN).is_nan());
        assert_eq!(rational_tanh::<false>(0.0), 0.0);
        assert!((rational_tanh::<false>(f32::INFINITY) - 1.0).abs() < TANH_ERROR);
    }
}
