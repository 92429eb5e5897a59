//! Frames against a path-traced reference.

use crate::ChartError;
use rrf_render::{Picture, compare, exr};
use std::path::{Path, PathBuf};

/// How far a frame is from the reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameErrors {
    /// Relative error of the indirect light, the reference's noise taken out.
    pub(crate) indirect: f64,
    /// Mean LDR-FLIP of the whole frame.
    pub(crate) flip: f64,
    /// Root mean square of CIEDE2000.
    pub(crate) delta_e_2000: f64,
}

/// Two independent halves of a path-traced frame.
pub(crate) struct Reference {
    indirect: [Picture; 2],
    full: Picture,
}

impl Reference {
    pub(crate) fn read(halves: &[PathBuf; 2]) -> Result<Reference, ChartError> {
        let indirect = [
            exr::read_layer(&halves[0], "indirect")?,
            exr::read_layer(&halves[1], "indirect")?,
        ];
        let full = mean(&exr::read(&halves[0])?, &exr::read(&halves[1])?);
        Ok(Reference { indirect, full })
    }

    /// `frame` is independent of both halves, so (p - a)(p - b) has the mean (p - m)².
    pub(crate) fn judge(&self, frame: &Path) -> Result<FrameErrors, ChartError> {
        let indirect = exr::read_layer(frame, "indirect")?;
        let comparison = compare(&self.full, &exr::read(frame)?, None)?;
        let [a, b] = &self.indirect;
        if indirect.pixels.len() != a.pixels.len() || a.pixels.len() != b.pixels.len() {
            return Err(ChartError::file(
                frame,
                "be compared",
                "it is of another size than the reference: remove the sweep's folder",
            ));
        }
        let value = |name| comparison.value(name).unwrap_or(f64::NAN);
        Ok(FrameErrors {
            indirect: relative_error(&indirect, a, b),
            flip: value("flip"),
            delta_e_2000: value("delta_e_2000"),
        })
    }
}

fn mean(a: &Picture, b: &Picture) -> Picture {
    let pixels = a.pixels.iter().zip(&b.pixels);
    Picture {
        pixels: pixels.map(|(&a, &b)| 0.5 * (a + b)).collect(),
        ..a.clone()
    }
}

/// sqrt(mean((p - a)(p - b) / max(lum, ε)²)) over pixels and channels, lum the mean of r, g and b
/// of both halves, ε 5 % of its mean; 0 where the estimate is negative.
fn relative_error(p: &Picture, a: &Picture, b: &Picture) -> f64 {
    let m = mean(a, b);
    let luminance: Vec<f64> = (m.pixels.iter())
        .map(|m| m.as_dvec3().element_sum() / 3.0)
        .collect();
    let count = luminance.len().max(1) as f64;
    let floor = 0.05 * luminance.iter().sum::<f64>() / count;
    let squares = (p
        .pixels
        .iter()
        .zip(&a.pixels)
        .zip(&b.pixels)
        .zip(&luminance))
    .map(|(((p, a), b), &luminance)| {
        let square = (p.as_dvec3() - a.as_dvec3()) * (p.as_dvec3() - b.as_dvec3());
        square.element_sum() / 3.0 / luminance.max(floor).powi(2)
    });
    (squares.sum::<f64>() / count).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A constant frame off by a tenth, halves of the reference with independent noise of a
    /// half: the tenth comes out, not the noise.
    #[test]
    fn the_references_noise_is_taken_out() {
        let mut state = 7u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let size = 200;
        let mut noisy = || Picture {
            width: size,
            height: size,
            pixels: (0..size * size)
                .map(|_| Vec3::splat(1.0 + (uniform() - 0.5) * 0.2))
                .collect(),
        };
        let (a, b) = (noisy(), noisy());
        let p = Picture {
            pixels: vec![Vec3::splat(1.1); (size * size) as usize],
            ..a.clone()
        };
        // With s² = 0.2²/12 the variance of a half, d = 0.1: lum is of the halves too, so to second
        // order the mean is d² + 2 d s² + 1.5 d² s² + 1.5 s⁴. A pixel's standard deviation is
        // sqrt(2 d² s² + s⁴); what is left out is of the order of s⁴.
        let (d, s2) = (0.1f64, 0.04 / 12.0);
        let wanted = d * d + 2.0 * d * s2 + 1.5 * d * d * s2 + 1.5 * s2 * s2;
        let se = (2.0 * d * d * s2 + s2 * s2).sqrt() / f64::from(size);
        let error = relative_error(&p, &a, &b);
        let off = (error.powi(2) - wanted).abs();
        assert!(off < 5.0 * se + 4.0 * s2 * s2, "{error}");
    }
}
