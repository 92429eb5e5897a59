//! Frames against a path-traced reference.

use crate::ChartError;
use rrf_metrics::estimate::by_halves;
use rrf_metrics::relative::{channel_mean, epsilon_of, inverse_level, root_mean};
use rrf_metrics::{Picture, compare};
use rrf_render::exr;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How far a frame is from the reference.
#[derive(Clone, Debug)]
pub(crate) struct FrameErrors {
    /// Relative error of the indirect light, the reference's noise taken out.
    pub(crate) indirect: f64,
    /// Figures of the whole frame by metric.
    pub(crate) whole: BTreeMap<String, f64>,
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
        let whole = comparison.measures.iter();
        Ok(FrameErrors {
            indirect: relative_error(&indirect, a, b),
            whole: whole.map(|m| (m.name.into(), m.value)).collect(),
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

/// The relative error of `p`, the noise of the reference's halves `a` and `b` taken out.
fn relative_error(p: &Picture, a: &Picture, b: &Picture) -> f64 {
    let m = mean(a, b);
    let rows = m.pixels.iter().map(|m| m.as_dvec3().to_array());
    let floor = epsilon_of(rows.clone());
    let pixels = p.pixels.iter().zip(&a.pixels).zip(&b.pixels).zip(rows);
    let squares = pixels.map(|(((p, a), b), m)| {
        let inverse = inverse_level(channel_mean(m), floor);
        by_halves(p.as_dvec3().to_array(), a.to_array(), b.to_array(), inverse)
    });
    root_mean(&squares.collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rrf_sampling::{Stage, Stream};

    /// A constant frame off by a tenth, halves of the reference with independent noise of a
    /// half: the tenth comes out, not the noise.
    #[test]
    fn the_references_noise_is_taken_out() {
        let mut random = Stream::new(7, Stage::Test, 0).dimensions(0);
        let size = 200;
        let mut noisy = || Picture {
            width: size,
            height: size,
            pixels: (0..size * size)
                .map(|_| Vec3::splat(1.0 + (random.next_f32() - 0.5) * 0.2))
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
