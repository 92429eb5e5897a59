//! LDR-FLIP of what is shown.

use super::pair::{FrameMetric, mean};
use crate::flip::{PIXELS_PER_DEGREE, flip};

/// Mean LDR-FLIP.
pub(super) const METRIC: FrameMetric = FrameMetric {
    name: "flip",
    unit: "1",
    definition: "mean LDR-FLIP (Andersson et al. 2020) of what is shown: exposed, clipped to [0, 1], sRGB; \
        67.02 pixels per degree",
    pixels: |pair| {
        let [reference, test] = &pair.shown;
        let width = pair.reference.width as usize;
        flip(reference, test, width, PIXELS_PER_DEGREE)
    },
    figure: mean,
};
