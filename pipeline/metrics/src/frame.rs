//! The metrics of two frames: a metric is an entry in a file of this folder and a line in
//! [`FRAME_METRICS`]. Printing, `--json` and the tables of sweeps follow from that list.

mod delta_e;
mod flip;
mod pair;
mod rel_mse;
mod relative_error;

pub use pair::{FrameMetric, Pair};
pub(crate) use rel_mse::EPSILON as REL_MSE_EPSILON;

/// All frame metrics, in the order printed.
pub const FRAME_METRICS: &[FrameMetric] = &[
    relative_error::RMS,
    relative_error::MEDIAN,
    relative_error::PERCENTILE_95,
    relative_error::WORST_SHARE,
    rel_mse::METRIC,
    delta_e::AB,
    delta_e::CIEDE2000,
    flip::METRIC,
];

impl FrameMetric {
    /// The metric `name`.
    pub fn named(name: &str) -> Option<&'static FrameMetric> {
        FRAME_METRICS.iter().find(|metric| metric.name == name)
    }
}
