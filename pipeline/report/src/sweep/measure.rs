//! Errors of a run: its frame against a path-traced reference, its answers against a table.

use super::results::SweepRow;
use crate::ReportError;
use arrow::array::AsArray;
use arrow::datatypes::Float32Type;
use rrf_metrics::estimate::{ErrorEstimate, SquareError, by_halves, less_variance};
use rrf_metrics::relative::{channel_mean, epsilon_of, inverse_level, root_mean};
use rrf_metrics::{Picture, compare};
use rrf_render::exr;
use rrf_store::Limits;
use rrf_store::points;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Errors of a frame against the reference.
#[derive(Clone, Debug)]
pub(super) struct FrameErrors {
    /// Relative error of the indirect light, the reference's noise taken out.
    pub(super) indirect: f64,
    /// Figures of the whole frame by metric.
    pub(super) whole: BTreeMap<String, f64>,
}

impl FrameErrors {
    /// A run's row with its frame's errors.
    pub(super) fn with(self, row: SweepRow) -> SweepRow {
        let figure = |metric: &str| self.whole.get(metric).copied().unwrap_or(f64::NAN);
        SweepRow {
            frame_error: self.indirect,
            flip: figure("flip"),
            delta_e_2000: figure("delta_e_2000"),
            ..row
        }
    }
}

/// Two independent halves of a path-traced frame.
pub(super) struct Reference {
    indirect: [Picture; 2],
    full: Picture,
}

impl Reference {
    pub(super) fn read(halves: &[PathBuf; 2]) -> Result<Reference, ReportError> {
        let indirect = [
            exr::read_exr_layer(&halves[0], "indirect")?,
            exr::read_exr_layer(&halves[1], "indirect")?,
        ];
        let full = mean(&exr::read_exr(&halves[0])?, &exr::read_exr(&halves[1])?);
        Ok(Reference { indirect, full })
    }

    /// `frame` is independent of both halves, so (p - a)(p - b) has the mean (p - m)².
    pub(super) fn errors(&self, frame: &Path) -> Result<FrameErrors, ReportError> {
        let indirect = exr::read_exr_layer(frame, "indirect")?;
        let comparison = compare(&self.full, &exr::read_exr(frame)?, None)?;
        let [a, b] = &self.indirect;
        if indirect.pixels.len() != a.pixels.len() || a.pixels.len() != b.pixels.len() {
            let told = "it is of another size than the reference; remove the sweep's folder";
            return Err(ReportError::file(frame, "be compared", told));
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

/// Relative error of answers at the rows of a reference table, the table's noise taken out, and
/// its standard error.
pub(super) fn points_error(answers: &Path, table: &Path) -> Result<(f64, f64), ReportError> {
    let p = columns(answers, ["r", "g", "b"])?;
    let m = columns(table, ["r", "g", "b"])?;
    let se = columns(table, ["r_se", "g_se", "b_se"])?;
    Ok(points_relative_error(&p, &m, &se))
}

/// Three columns of a points table.
fn columns(path: &Path, names: [&str; 3]) -> Result<[Vec<f64>; 3], ReportError> {
    let table = points::read_points(path, Limits::default())?;
    let mut out = [Vec::new(), Vec::new(), Vec::new()];
    for (out, name) in out.iter_mut().zip(names) {
        let array = table.batch.column_by_name(name);
        let numbers = array.and_then(|array| array.as_primitive_opt::<Float32Type>());
        let numbers = numbers.ok_or_else(|| {
            ReportError::input(
                path,
                format!("no float32 column {name}: not a table of reference radiance"),
            )
        })?;
        out.extend(numbers.values().iter().map(|&x| f64::from(x)));
    }
    Ok(out)
}

/// The relative error over rows and its standard error, the reference's noise taken out.
fn points_relative_error(p: &[Vec<f64>; 3], m: &[Vec<f64>; 3], se: &[Vec<f64>; 3]) -> (f64, f64) {
    let row = |columns: &[Vec<f64>; 3], i: usize| [0, 1, 2].map(|c| columns[c][i]);
    let rows = 0..m[0].len();
    let floor = epsilon_of(rows.clone().map(|i| row(m, i)));
    let square = |i| {
        let level = channel_mean(row(m, i));
        less_variance(
            row(p, i),
            row(m, i),
            row(se, i),
            inverse_level(level, floor),
        )
    };
    let squares: Vec<f64> = rows.map(square).collect();
    SquareError::from(ErrorEstimate::of(&squares)).relative()
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
