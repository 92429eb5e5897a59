//! How far one picture is from another.

use crate::color;
use crate::error::RenderError;
use crate::flip;
use crate::frame::{Picture, luminance};
use crate::tone::Exposure;
use glam::{DVec3, Vec3};

/// The share of the reference's mean luminance that serves as ε of the relative error.
pub const EPSILON_SHARE: f64 = 0.05;
/// Added to the squared reference in relMSE (Rousselle, Knaus, Zwicker 2011).
pub const REL_MSE_EPSILON: f64 = 0.01;

/// Differences of a test picture from a reference, over all pixels.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Exposure of both pictures in the colour differences and FLIP.
    pub exposure: Exposure,
    /// Mean luminance of the reference.
    pub reference_luminance: f64,
    /// Mean luminance of the test picture.
    pub test_luminance: f64,
    /// The measures, in the order printed.
    pub measures: Vec<Measure>,
}

/// One figure and what it means.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Measure {
    /// Short name.
    pub name: &'static str,
    /// The figure; 0 for equal pictures.
    pub value: f64,
    /// How it is computed.
    pub definition: String,
}

/// Compares `test` with `reference`. Without an exposure, the reference's automatic one serves
/// both pictures.
pub fn compare(
    reference: &Picture,
    test: &Picture,
    exposure: Option<Exposure>,
) -> Result<Comparison, RenderError> {
    let sizes = [reference, test].map(|p| (p.width, p.height));
    if sizes[0] != sizes[1] {
        return Err(RenderError::SizeMismatch {
            first: sizes[0],
            second: sizes[1],
        });
    }
    let (width, height) = sizes[0];
    if reference.pixels.is_empty() {
        return Err(RenderError::Size { width, height });
    }
    reference.check_finite("first")?;
    test.check_finite("second")?;
    let mean_luminance = |p: &Picture| mean(p.pixels.iter().map(|&p| f64::from(luminance(p))));
    let reference_luminance = mean_luminance(reference);
    if reference_luminance <= 0.0 {
        return Err(RenderError::BlackReference);
    }
    let exposure = exposure.unwrap_or_else(|| Exposure::automatic(reference));
    let mut measures = linear_measures(reference, test, reference_luminance);
    measures.extend(shown_measures(reference, test, exposure));
    Ok(Comparison {
        width,
        height,
        exposure,
        reference_luminance,
        test_luminance: mean_luminance(test),
        measures,
    })
}

impl Comparison {
    /// The value of the measure `name`.
    pub fn value(&self, name: &str) -> Option<f64> {
        let measure = self.measures.iter().find(|m| m.name == name);
        measure.map(|m| m.value)
    }
}

/// Measures of the radiance itself, over pixels and channels.
fn linear_measures(reference: &Picture, test: &Picture, mean_luminance: f64) -> Vec<Measure> {
    let epsilon = EPSILON_SHARE * mean_luminance;
    let mut relative = Vec::with_capacity(reference.pixels.len());
    let mut rel_mse = Vec::with_capacity(reference.pixels.len());
    for (m, p) in reference.pixels.iter().zip(&test.pixels) {
        let square = (p.as_dvec3() - m.as_dvec3()).powf(2.0);
        let level = f64::from(luminance(*m)).max(epsilon);
        relative.push(square.element_sum() / 3.0 / (level * level));
        let weight = m.as_dvec3() * m.as_dvec3() + REL_MSE_EPSILON;
        rel_mse.push((square / weight).element_sum() / 3.0);
    }
    vec![
        Measure {
            name: "relative_error",
            value: mean(relative).sqrt(),
            definition: format!(
                "sqrt(mean((p - m)^2 / max(lum(m), e)^2)) over pixels and channels, \
                 m the reference, e = {epsilon:.6} = {} % of its mean luminance",
                100.0 * EPSILON_SHARE
            ),
        },
        Measure {
            name: "rel_mse",
            value: mean(rel_mse),
            definition: format!(
                "mean((p - m)^2 / (m^2 + {REL_MSE_EPSILON})) over pixels and channels, m the reference"
            ),
        },
    ]
}

/// Measures of what a display shows.
fn shown_measures(reference: &Picture, test: &Picture, exposure: Exposure) -> Vec<Measure> {
    // What the sRGB display emits: encoding and decoding cancel, exposure and clip remain.
    let shown = |p: &Picture| -> Vec<DVec3> {
        let pixels = p.pixels.iter();
        pixels
            .map(|&p: &Vec3| exposure.apply(p).as_dvec3())
            .collect()
    };
    let (m, p) = (shown(reference), shown(test));
    let lab = |rgb: &[DVec3]| -> Vec<DVec3> {
        rgb.iter().map(|&rgb| color::lab(color::xyz(rgb))).collect()
    };
    let (lab_m, lab_p) = (lab(&m), lab(&p));
    let rms = |difference: fn(DVec3, DVec3) -> f64| {
        let pairs = lab_m.iter().zip(&lab_p);
        mean(pairs.map(|(&m, &p)| difference(m, p).powi(2))).sqrt()
    };
    let flip = flip::flip(&m, &p, reference.width as usize, flip::PIXELS_PER_DEGREE);
    let tone = format!(
        "exposure {:+.3} stops, clipped to [0, 1], sRGB",
        exposure.ev
    );
    vec![
        Measure {
            name: "delta_e_ab",
            value: rms(color::delta_e_ab),
            definition: format!("sqrt(mean(dE*ab^2)) over pixels; {tone}, CIELAB (D65)"),
        },
        Measure {
            name: "delta_e_2000",
            value: rms(color::delta_e_2000),
            definition: format!("sqrt(mean(dE00^2)) over pixels; {tone}, CIELAB (D65)"),
        },
        Measure {
            name: "flip",
            value: mean(flip),
            definition: format!(
                "mean LDR-FLIP (Andersson et al. 2020) at {:.2} pixels per degree; {tone}",
                flip::PIXELS_PER_DEGREE
            ),
        },
    ]
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0u64), |(sum, count), x| (sum + x, count + 1));
    sum / count as f64
}
