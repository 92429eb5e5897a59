//! The relative error: of rows and pixels, against a reference free of noise.
//!
//! With p the answer and m the truth of a row, both radiance [W·sr⁻¹·m⁻²] in three channels, it
//! is [`FORMULA`] over rows and channels. The divisor is a row's channel mean and not its
//! luminance: a green wall and a blue one count alike. ε keeps dark rows from counting without
//! bound.

/// The share of the mean radiance of what is judged that serves as ε.
pub const EPSILON_SHARE: f64 = 0.05;

/// The definition, as it is printed.
pub const FORMULA: &str = "sqrt(mean((p - m)² / max(c(m), ε)²)), \
    c the mean of the three channels, ε = 5 % of the mean of c";

/// The mean of the three channels.
#[inline]
pub fn channel_mean(rgb: [f64; 3]) -> f64 {
    rgb.iter().sum::<f64>() / 3.0
}

/// ε in radiance from the mean radiance of what is judged; 1 where all is black, so that errors
/// are then absolute.
#[inline]
pub fn epsilon(share: f64, mean: f64) -> f64 {
    match mean > 0.0 {
        true => share * mean,
        false => 1.0,
    }
}

/// ε in radiance of the rows that are judged.
pub fn epsilon_of(rows: impl IntoIterator<Item = [f64; 3]>) -> f64 {
    epsilon(EPSILON_SHARE, mean_level(rows))
}

/// Mean channel mean of some rows; 0 without rows.
fn mean_level(rows: impl IntoIterator<Item = [f64; 3]>) -> f64 {
    mean(rows.into_iter().map(channel_mean))
}

/// What a row's error is multiplied with: 1 / max(level, ε).
#[inline]
pub fn inverse_level(level: f64, epsilon: f64) -> f64 {
    1.0 / level.max(epsilon)
}

/// Squared relative error of a row: the mean over the channels of (p − m)² times
/// `inverse_level`².
#[inline]
pub fn square(p: [f64; 3], m: [f64; 3], inverse_level: f64) -> f64 {
    let sum: f64 = (0..3).map(|c| (p[c] - m[c]) * (p[c] - m[c])).sum();
    sum / 3.0 * inverse_level * inverse_level
}

/// Root of the mean of squares, 0 where noise makes it negative.
pub fn root_mean(squares: &[f64]) -> f64 {
    mean(squares.iter().copied()).max(0.0).sqrt()
}

/// Median of the rows' relative errors.
pub fn median(squares: &[f64]) -> f64 {
    quantile(squares, 0.5)
}

/// 95th percentile of the rows' relative errors.
pub fn percentile_95(squares: &[f64]) -> f64 {
    quantile(squares, 0.95)
}

/// The share of the squared error that the worst 1 % of the rows make, at least one row; 0 where
/// there is no error.
pub fn worst_share(squares: &[f64]) -> f64 {
    let total: f64 = squares.iter().sum();
    if total.is_nan() || total <= 0.0 {
        return 0.0;
    }
    let mut sorted = squares.to_vec();
    sorted.sort_unstable_by(|a, b| b.total_cmp(a));
    sorted[..squares.len().div_ceil(100)].iter().sum::<f64>() / total
}

/// Quantile of the square roots, linear between neighbours; 0 without rows.
fn quantile(squares: &[f64], share: f64) -> f64 {
    let mut sorted = squares.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = share * sorted.len().saturating_sub(1) as f64;
    let value = |i: usize| sorted.get(i).map_or(0.0, |s| s.max(0.0).sqrt());
    let low = value(at as usize);
    low + at.fract() * (value(at.ceil() as usize) - low)
}

pub(crate) fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let sum_count = |(sum, count), x| (sum + x, count + 1u64);
    let (sum, count) = values.into_iter().fold((0.0, 0), sum_count);
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Greys 1 and 0.01 (below ε = 0.05 · 0.505), off by 0.1 and 0.02.
    #[test]
    fn equals_the_formula_by_hand() {
        let (m, p) = ([[1.0; 3], [0.01; 3]], [[1.1; 3], [0.03; 3]]);
        let epsilon = epsilon_of(m);
        assert!((epsilon - 0.02525).abs() < 1e-12);
        assert_eq!(super::epsilon(0.05, 0.0), 1.0);
        let squares: Vec<f64> = p
            .iter()
            .zip(m)
            .map(|(&p, m)| square(p, m, inverse_level(channel_mean(m), epsilon)))
            .collect();
        let wanted = ((0.1f64.powi(2) + (0.02 / 0.02525f64).powi(2)) / 2.0).sqrt();
        assert!((root_mean(&squares) - wanted).abs() < 1e-12);
    }

    /// The divisor is the channel mean: the same error of a green and a blue wall counts alike.
    #[test]
    fn channels_count_alike() {
        let of = |m: [f64; 3]| square(m.map(|x| 1.1 * x), m, inverse_level(channel_mean(m), 0.0));
        assert!((of([0.0, 1.0, 0.0]) - of([0.0, 0.0, 1.0])).abs() < 1e-12);
    }

    /// Errors 0.01, 0.02 ... 2.00: quantiles as numpy's, and the two worst rows' share.
    #[test]
    fn tails_are_those_of_the_rows() {
        let errors: Vec<f64> = (1..=200).rev().map(|i| 0.01 * f64::from(i)).collect();
        let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
        assert!((median(&squares) - 1.005).abs() < 1e-12);
        assert!((percentile_95(&squares) - 1.9005).abs() < 1e-12);
        let total = 1e-4 * (200.0 * 201.0 * 401.0 / 6.0);
        let worst = (2.0f64.powi(2) + 1.99f64.powi(2)) / total;
        assert!((worst_share(&squares) - worst).abs() < 1e-12);
        assert_eq!(worst_share(&[0.0; 3]), 0.0);
        assert_eq!([median(&[]), percentile_95(&[]), root_mean(&[])], [0.0; 3]);
        assert_eq!(worst_share(&[]), 0.0);
    }
}
