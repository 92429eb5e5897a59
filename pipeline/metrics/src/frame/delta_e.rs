//! Colour differences of what is shown.

use super::pair::{FrameMetric, Pair, root_mean_square};
use crate::color;
use glam::DVec3;

/// Euclidean distance in CIELAB (1976).
pub(super) const AB: FrameMetric = FrameMetric {
    name: "delta_e_ab",
    unit: "ΔE*ab",
    definition: "sqrt(mean(dE*ab²)) over pixels as shown: exposed, clipped to [0, 1], sRGB; CIELAB (D65)",
    pixels: |pair| differences(pair, color::delta_e_ab),
    figure: root_mean_square,
};

/// CIEDE2000.
pub(super) const CIEDE2000: FrameMetric = FrameMetric {
    name: "delta_e_2000",
    unit: "ΔE00",
    definition: "sqrt(mean(dE00²)) over pixels as shown: exposed, clipped to [0, 1], sRGB; CIELAB (D65)",
    pixels: |pair| differences(pair, color::delta_e_2000),
    figure: root_mean_square,
};

fn differences(pair: &Pair, difference: fn(DVec3, DVec3) -> f64) -> Vec<f64> {
    let [reference, test] = &pair.lab;
    let pixels = reference.iter().zip(test);
    pixels.map(|(&m, &p)| difference(m, p)).collect()
}
