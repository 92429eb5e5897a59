//! The relative error against a noisy reference, with that noise taken out.
//!
//! With y₁ = m + e₁ and y₂ = m + e₂, e₁ and e₂ independent with mean 0 and p independent of
//! both, E[(p − y₁)(p − y₂)] = (p − m)². With one estimate y and its standard error s,
//! E[(p − y)² − s²] = (p − m)².

use serde::{Deserialize, Serialize};

/// A mean squared relative error and how well it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Mean of the rows' squared relative errors; can be negative.
    pub square: f64,
    /// Standard error of `square`.
    pub square_se: f64,
    /// Rows.
    pub rows: usize,
}

impl ErrorEstimate {
    /// The mean of one value a row and its standard error.
    pub fn of(values: &[f64]) -> ErrorEstimate {
        let n = values.len() as f64;
        if values.is_empty() {
            return ErrorEstimate::default();
        }
        let mean = values.iter().sum::<f64>() / n;
        let spread: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        ErrorEstimate {
            square: mean,
            square_se: (spread / (n - 1.0).max(1.0) / n).sqrt(),
            rows: values.len(),
        }
    }

    /// Relative RMS error, √max(square, 0).
    pub fn relative(&self) -> f64 {
        self.square.max(0.0).sqrt()
    }

    /// Standard error of [`ErrorEstimate::relative`], to first order.
    pub fn relative_se(&self) -> f64 {
        let relative = self.relative();
        if relative > 0.0 {
            self.square_se / (2.0 * relative)
        } else {
            self.square_se.sqrt()
        }
    }
}

/// A mean relative square error with the Monte Carlo noise taken out, so that it may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareError {
    /// The estimate.
    pub mean: f64,
    /// Its standard error.
    pub se: f64,
}

impl SquareError {
    /// The relative error, 0 where the estimate is negative, and its standard error: that of a
    /// square root, se / (2 error), which near 0 gives way to its upper limit sqrt(se).
    pub fn relative(self) -> (f64, f64) {
        let error = self.mean.max(0.0).sqrt();
        let limit = self.se.max(0.0).sqrt();
        let se = if error > 0.0 {
            (self.se / (2.0 * error)).min(limit)
        } else {
            limit
        };
        (error, se)
    }
}

impl From<ErrorEstimate> for SquareError {
    fn from(estimate: ErrorEstimate) -> SquareError {
        SquareError {
            mean: estimate.square,
            se: estimate.square_se,
        }
    }
}

/// Squared relative error of a row by two half estimates: the mean over the channels of
/// (p − y₁)(p − y₂) times `inverse_level`².
#[inline]
pub fn by_halves(p: [f64; 3], y1: [f32; 3], y2: [f32; 3], inverse_level: f64) -> f64 {
    let sum: f64 = (0..3)
        .map(|c| (p[c] - f64::from(y1[c])) * (p[c] - f64::from(y2[c])))
        .sum();
    sum / 3.0 * inverse_level * inverse_level
}

/// Squared relative error of a row whose reference y has the standard errors `se`: the mean over
/// the channels of (p − y)² − se² times `inverse_level`².
#[inline]
pub fn less_variance(p: [f64; 3], y: [f64; 3], se: [f64; 3], inverse_level: f64) -> f64 {
    let sum: f64 = (0..3)
        .map(|c| (p[c] - y[c]) * (p[c] - y[c]) - se[c] * se[c])
        .sum();
    sum / 3.0 * inverse_level * inverse_level
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    /// An answer off by a tenth of a truth of 1, and references with uniform noise of a variance
    /// of 1/12 and 1/24: the hundredth comes out, within five standard errors (6e-7).
    #[test]
    fn the_references_noise_is_taken_out() {
        let random = Stream::new(1, Stage::Test, 0);
        let halves = |i: u64| [0, 1].map(|h| [0, 1, 2].map(|c| random.f32(i, 3 * h + c) + 0.5));
        let (rows, p) = (40_000, [1.1; 3]);
        let values = (0..rows).map(|i| {
            let [y1, y2] = halves(i);
            by_halves(p, y1, y2, 1.0)
        });
        let se = [(1.0f64 / 24.0).sqrt(); 3];
        let known = (0..rows).map(|i| {
            let [y1, y2] = halves(i).map(|y| y.map(f64::from));
            less_variance(p, [0, 1, 2].map(|c| 0.5 * (y1[c] + y2[c])), se, 1.0)
        });
        for values in [values.collect::<Vec<_>>(), known.collect()] {
            let found = ErrorEstimate::of(&values);
            assert!(
                (found.square - 0.01).abs() < 5.0 * found.square_se,
                "{found:?}"
            );
            assert!(found.square_se < 1e-3 && found.rows == rows as usize);
        }
    }

    /// d√x = dx / 2√x, and never more than √dx.
    #[test]
    fn standard_errors_of_the_root() {
        let known = SquareError {
            mean: 0.04,
            se: 0.004,
        };
        assert_eq!(known.relative(), (0.2, 0.01));
        let near_zero = SquareError {
            mean: 1e-8,
            se: 1e-4,
        };
        assert_eq!(near_zero.relative().1, 0.01);
        let negative = SquareError {
            mean: -1.0,
            se: 1e-4,
        };
        assert_eq!(negative.relative(), (0.0, 0.01));
    }
}
