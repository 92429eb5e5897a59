//! Views by path tracing, which the nets' frames are compared with.

mod fallback;
mod paths;

pub use fallback::trace_untrusted;
pub use paths::PathOptions;

use crate::direct::PointLighting;
use crate::error::RenderError;
use crate::frame::Frame;
use crate::origin;
use crate::timings::Stopwatch;
use crate::view::{Lights, View};
use glam::Vec3;
use paths::Paths;
use rayon::prelude::*;
use rrf_metrics::color::luminance;
use rrf_metrics::relative::EPSILON_SHARE;
use rrf_sampling::Stage;
use rrf_trace::{Reflections, TraceError, Tracer};

/// Two independent halves of a row's pixels: direct light, then indirect.
type Row = [[Vec<Vec3>; 2]; 2];

/// Renders `view` by path tracing: direct light of few sharp lights exactly, all other light
/// by paths. A pixel is the mean of two independent halves, which tell the frame's own noise
/// (attribute `rrf.relative_noise`). `progress` is told how many rows of pixels were done.
pub fn trace_frame(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    options: PathOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Frame, RenderError> {
    let paths = Paths::new(tracer, view, lights, options, Stage::Frame)?;
    let rows = (0..view.height).into_par_iter().map(|y| {
        let row = trace_row(&paths, y)?;
        progress(1);
        Ok(row)
    });
    let rows = rows.collect::<Result<Vec<Row>, RenderError>>()?;
    let layer = |part: usize| -> Vec<Vec3> {
        let halves = rows.iter().map(|row| &row[part]);
        let halves = halves.flat_map(|[a, b]| a.iter().zip(b));
        halves.map(|(&a, &b)| 0.5 * (a + b)).collect()
    };
    let (direct, indirect) = (layer(0), layer(1));
    let full: Vec<Vec3> = direct.iter().zip(&indirect).map(|(a, b)| a + b).collect();
    let mut attributes = origin::of_trace(view, lights, paths.aa, options.spp, options.seed);
    let noise = relative_noise(&rows, &full);
    attributes.push(("rrf.relative_noise".into(), noise.to_string()));
    Ok(Frame {
        width: view.width,
        height: view.height,
        full,
        direct: Some(direct),
        indirect: Some(indirect),
        attributes,
        ..Frame::default()
    })
}

/// One row of pixels.
fn trace_row(paths: &Paths, y: u32) -> Result<Row, TraceError> {
    let seen = paths.visible(y);
    let mut row: Row = Default::default();
    for half in row.iter_mut().flatten() {
        half.resize(paths.view.width as usize, Vec3::ZERO);
    }
    // values in two halves, a point each
    let mut add = |part: usize, values: &dyn Fn(usize) -> [Vec3; 2]| {
        let [a, b] = &mut row[part];
        for (point, &pixel) in seen.pixel.iter().enumerate() {
            let [first, second] = values(point);
            a[pixel as usize] += paths.weight() * first;
            b[pixel as usize] += paths.weight() * second;
        }
    };
    let mut exact = PointLighting::default();
    let (points, sharp) = (paths.exact.0, paths.exact.1.as_slice());
    exact.shade(
        paths.tracer,
        &seen,
        (points, sharp),
        &mut Stopwatch::default(),
    );
    add(0, &|point| [exact.radiance[point]; 2]);
    for (k, light) in (0..).zip(paths.alone) {
        let estimates = paths.of_point_light((k, light), &seen.points, &seen.viewers, y)?;
        add(1, &|point| {
            estimates.halves(point).map(|v| v * light.intensity)
        });
    }
    for (part, reflections) in [Reflections::One, Reflections::More]
        .into_iter()
        .enumerate()
    {
        let estimates = paths.of_other_lights(reflections, &seen.points, &seen.viewers, y)?;
        add(part, &|point| estimates.halves(point));
    }
    add(0, &|point| {
        let (place, viewer) = (&seen.points[point], seen.viewers[point]);
        [paths.tracer.emission_of(&paths.direct, place, viewer); 2]
    });
    for &(pixel, direction) in &seen.missed {
        let sky = paths.weight() * paths.direct.radiance_from_afar(direction);
        let [a, b] = &mut row[0];
        a[pixel as usize] += sky;
        b[pixel as usize] += sky;
    }
    Ok(row)
}

/// Relative standard error of the frame's pixels, by the definition of the relative error:
/// the mean of two halves has the variance E[(a - b)²] / 4.
fn relative_noise(rows: &[Row], full: &[Vec3]) -> f64 {
    let count = full.len().max(1) as f64;
    let mean = full.iter().map(|&p| f64::from(luminance(p))).sum::<f64>() / count;
    let halves = rows.iter().flat_map(|[direct, indirect]| {
        let difference = |part: &[Vec<Vec3>; 2], i: usize| part[0][i] - part[1][i];
        (0..direct[0].len()).map(move |i| difference(direct, i) + difference(indirect, i))
    });
    let squares = halves.zip(full).map(|(difference, &p)| {
        let level = f64::from(luminance(p))
            .max(EPSILON_SHARE * mean)
            .max(f64::MIN_POSITIVE);
        f64::from(difference.length_squared()) / 12.0 / (level * level)
    });
    (squares.sum::<f64>() / count).sqrt()
}
