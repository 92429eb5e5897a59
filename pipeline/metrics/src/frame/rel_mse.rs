//! relMSE, as other renderers tell it.

use super::pair::{FrameMetric, mean};

/// Added to the squared reference (Rousselle, Knaus, Zwicker 2011).
pub(crate) const EPSILON: f64 = 0.01;

/// Relative mean square error.
pub(super) const METRIC: FrameMetric = FrameMetric {
    name: "rel_mse",
    unit: "1",
    definition: "mean((p - m)² / (m² + 0.01)) over pixels and channels, m the reference",
    pixels: |pair| {
        let pixels = pair.reference.pixels.iter().zip(&pair.test.pixels);
        let pixels = pixels.map(|(m, p)| (m.as_dvec3(), p.as_dvec3()));
        pixels
            .map(|(m, p)| ((p - m) * (p - m) / (m * m + EPSILON)).element_sum() / 3.0)
            .collect()
    },
    figure: mean,
};
