//! Two frames to compare, and what a metric of them is.

use crate::color;
use crate::picture::Picture;
use crate::relative;
use crate::tone::Exposure;
use glam::DVec3;

/// A figure that tells two frames apart; 0 for equal ones.
#[derive(Clone, Copy)]
pub struct FrameMetric {
    /// Name in `--json` and in tables.
    pub name: &'static str,
    /// Unit of the figure.
    pub unit: &'static str,
    /// How it is computed.
    pub definition: &'static str,
    /// One value a pixel, row-major.
    pub pixels: fn(&Pair) -> Vec<f64>,
    /// The figure from those.
    pub figure: fn(&[f64]) -> f64,
}

impl FrameMetric {
    /// The figure for a pair.
    pub fn value(&self, pair: &Pair) -> f64 {
        (self.figure)(&(self.pixels)(pair))
    }
}

/// A reference and a test picture of the same size, as radiance and as a display shows them.
pub struct Pair<'a> {
    /// The reference.
    pub reference: &'a Picture,
    /// The picture that is compared with it.
    pub test: &'a Picture,
    /// Exposure of both where colours are compared.
    pub exposure: Exposure,
    /// ε of the relative error [W·sr⁻¹·m⁻²].
    pub epsilon: f64,
    /// Linear RGB in [0, 1] that the display emits: sRGB encoding and decoding cancel, exposure
    /// and clip remain. Reference and test.
    pub shown: [Vec<DVec3>; 2],
    /// CIELAB (D65) of that.
    pub lab: [Vec<DVec3>; 2],
}

impl<'a> Pair<'a> {
    /// Prepares two pictures of the same size.
    pub fn new(reference: &'a Picture, test: &'a Picture, exposure: Exposure) -> Pair<'a> {
        let levels = reference.pixels.iter().map(|m| m.as_dvec3().to_array());
        let shown = [reference, test].map(|picture| -> Vec<DVec3> {
            let pixels = picture.pixels.iter();
            pixels.map(|&p| exposure.apply(p).as_dvec3()).collect()
        });
        let lab = |rgb: &Vec<DVec3>| rgb.iter().map(|&rgb| color::lab(color::xyz(rgb))).collect();
        Pair {
            reference,
            test,
            exposure,
            epsilon: relative::epsilon_of(levels),
            lab: [lab(&shown[0]), lab(&shown[1])],
            shown,
        }
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    relative::mean(values.iter().copied())
}

pub(super) fn root_mean_square(values: &[f64]) -> f64 {
    relative::mean(values.iter().map(|x| x * x)).sqrt()
}
