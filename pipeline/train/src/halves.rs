//! Errors free of Monte Carlo noise, from two independent half estimates.
//!
//! With y₁ = m + e₁ and y₂ = m + e₂, e₁ and e₂ independent with mean 0 and p independent of
//! both, E[(p − y₁)(p − y₂)] = (p − m)².

use serde::{Deserialize, Serialize};

/// A mean squared relative error and how well it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Mean over rows and channels of (p − y₁)(p − y₂) / max(channel mean, ε)²; can be negative.
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

/// Mean over the channels of (p − y₁)(p − y₂) times `divisor`².
pub fn product(p: [f64; 3], y1: [f32; 3], y2: [f32; 3], divisor: f64) -> f64 {
    let sum: f64 = (0..3)
        .map(|c| (p[c] - f64::from(y1[c])) * (p[c] - f64::from(y2[c])))
        .sum();
    sum / 3.0 * divisor * divisor
}
