//! The relative error of the radiance, and its spread over pixels.

use super::pair::{FrameMetric, Pair};
use crate::relative::{self, FORMULA, channel_mean, inverse_level, square};

/// The relative error.
pub(super) const RMS: FrameMetric = FrameMetric {
    name: "relative_error",
    unit: "1",
    definition: FORMULA,
    pixels: squares,
    figure: relative::root_mean,
};

/// The median pixel's.
pub(super) const MEDIAN: FrameMetric = FrameMetric {
    name: "relative_error_median",
    definition: "median over pixels of the relative error",
    figure: relative::median,
    ..RMS
};

/// That which 95 % of the pixels stay below.
pub(super) const PERCENTILE_95: FrameMetric = FrameMetric {
    name: "relative_error_p95",
    definition: "95th percentile over pixels of the relative error",
    figure: relative::percentile_95,
    ..RMS
};

/// How much of it comes from few pixels.
pub(super) const WORST_SHARE: FrameMetric = FrameMetric {
    name: "worst_1_percent_share",
    definition: "share of the squared relative error that the worst 1 % of pixels make",
    figure: relative::worst_share,
    ..RMS
};

/// Squared relative error of every pixel.
fn squares(pair: &Pair) -> Vec<f64> {
    let pixels = pair.reference.pixels.iter().zip(&pair.test.pixels);
    let pixels = pixels.map(|(m, p)| [m, p].map(|x| x.as_dvec3().to_array()));
    pixels
        .map(|[m, p]| square(p, m, inverse_level(channel_mean(m), pair.epsilon)))
        .collect()
}
