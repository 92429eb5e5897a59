//! How far one picture is from another.

use crate::color::luminance;
use crate::error::MetricsError;
use crate::frame::{FRAME_METRICS, Pair};
use crate::picture::Picture;
use crate::relative::mean;
use crate::tone::Exposure;

/// Differences of a test picture from a reference, over all pixels.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Exposure of both pictures in the colour differences and FLIP.
    pub exposure: Exposure,
    /// Mean luminance (Rec. 709) of the reference.
    pub reference_luminance: f64,
    /// Mean luminance (Rec. 709) of the test picture.
    pub test_luminance: f64,
    /// ε of the relative error [W·sr⁻¹·m⁻²].
    pub epsilon: f64,
    /// The metrics, in the order printed.
    pub measures: Vec<Measure>,
}

/// A metric's figure and how it is computed.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Measure {
    /// Short name.
    pub name: &'static str,
    /// The figure; 0 for equal pictures.
    pub value: f64,
    /// Unit of the figure.
    pub unit: &'static str,
    /// How it is computed.
    pub definition: &'static str,
}

/// Compares `test` with `reference`. Without an exposure, the reference's automatic one serves
/// both pictures.
pub fn compare(
    reference: &Picture,
    test: &Picture,
    exposure: Option<Exposure>,
) -> Result<Comparison, MetricsError> {
    check_pair(reference, test)?;
    let exposure = exposure.unwrap_or_else(|| Exposure::automatic(reference));
    let pair = Pair::new(reference, test, exposure);
    let measures = FRAME_METRICS.iter().map(|metric| Measure {
        name: metric.name,
        value: metric.value(&pair),
        unit: metric.unit,
        definition: metric.definition,
    });
    Ok(Comparison {
        width: reference.width,
        height: reference.height,
        exposure,
        reference_luminance: mean_luminance(reference),
        test_luminance: mean_luminance(test),
        epsilon: pair.epsilon,
        measures: measures.collect(),
    })
}

fn mean_luminance(picture: &Picture) -> f64 {
    mean(picture.pixels.iter().map(|&p| f64::from(luminance(p))))
}

/// Whether two pictures can be compared.
pub(crate) fn check_pair(reference: &Picture, test: &Picture) -> Result<(), MetricsError> {
    let [first, second] = [reference, test].map(|p| (p.width, p.height));
    if first != second {
        return Err(MetricsError::SizeMismatch { first, second });
    }
    if reference.pixels.is_empty() {
        return Err(MetricsError::Empty);
    }
    reference.check_finite("reference")?;
    test.check_finite("tested")?;
    match mean_luminance(reference) > 0.0 {
        true => Ok(()),
        false => Err(MetricsError::BlackReference),
    }
}

impl Comparison {
    /// The value of the measure `name`.
    pub fn value(&self, name: &str) -> Option<f64> {
        let measure = self.measures.iter().find(|m| m.name == name);
        measure.map(|m| m.value)
    }
}
