//! What tests decide by: z at a stated significance.

use crate::chi_square::chi_square_tail;
use glam::Vec3;

/// Two-sided z limit of one test among `tests` that together fail by chance once in 10^5 runs
/// (Šidák). Normal quantiles by bisection on [`normal_tail`].
pub fn z_limit(tests: usize) -> f64 {
    let alone = 1.0 - (1.0f64 - 1e-5).powf(1.0 / tests as f64);
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if 2.0 * normal_tail(middle) > alone {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// P(Z > z) of a standard normal: chi-square with one degree of freedom, halved.
fn normal_tail(z: f64) -> f64 {
    0.5 * chi_square_tail(z * z, 1.0)
}

/// Asserts that a Monte Carlo mean agrees with the truth in every channel. `slack` is a relative
/// difference that is known beforehand (a polygon for a circle).
pub fn assert_z(name: &str, mean: Vec3, error: Vec3, truth: Vec3, slack: f32, tests: usize) {
    let limit = z_limit(3 * tests) as f32;
    for c in 0..3 {
        let off = (mean[c] - truth[c]).abs() - slack * truth[c].abs();
        // Rounding of a few thousand f32 terms, where the variance is zero.
        let rounding = 1e-5 * truth[c].abs();
        assert!(
            off <= limit * error[c] + rounding,
            "{name}: channel {c}: {} with standard error {}, truth {}",
            mean[c],
            error[c],
            truth[c]
        );
    }
}

#[test]
fn tails_are_those_of_the_tables() {
    assert!((normal_tail(1.959_964) - 0.025).abs() < 1e-8);
    assert!((normal_tail(4.264_89) - 1e-5).abs() < 1e-9);
    assert!((chi_square_tail(18.307_038, 10.0) - 0.05).abs() < 1e-8);
    assert!((chi_square_tail(124.342_113, 100.0) - 0.05).abs() < 1e-8);
    assert!((z_limit(1) - 4.417_173).abs() < 1e-5);
}
