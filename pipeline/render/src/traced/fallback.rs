//! Pixels that the nets were not trained for, path-traced after all.

use super::paths::{PathOptions, Paths};
use crate::error::RenderError;
use crate::frame::Frame;
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_sampling::Stage;
use rrf_trace::{Reflections, TraceError, Tracer};

/// Replaces the indirect light of every pixel whose trust is below 1 by that of paths, and sets its
/// cell to none. Gives the number of pixels. A frame without trust or indirect layer stays as it
/// is. The same bits on any number of threads.
pub fn trace_untrusted(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    frame: &mut Frame,
    options: PathOptions,
) -> Result<usize, RenderError> {
    let paths = Paths::new(tracer, view, lights, options, Stage::Fallback)?;
    let (Some(trust), Some(layer)) = (frame.trust.as_ref(), frame.indirect.as_mut()) else {
        return Ok(0);
    };
    let width = view.width as usize;
    let rows = trust.par_chunks(width).enumerate();
    let rows = rows.map(|(y, trust)| trace_row(&paths, y as u32, trust));
    let rows = rows.collect::<Result<Vec<Vec<(usize, Vec3)>>, TraceError>>()?;
    let mut count = 0;
    for (pixel, value) in rows.into_iter().flatten() {
        if let Some(full) = frame.full.get_mut(pixel) {
            *full += value - layer[pixel];
        }
        layer[pixel] = value;
        if let Some(cell) = frame.cell.as_mut() {
            cell[pixel] = u32::MAX;
        }
        count += 1;
    }
    let facts = [
        ("rrf.fallback", "path tracing".to_string()),
        ("rrf.fallback_pixels", count.to_string()),
        ("rrf.fallback_paths_per_pixel", options.spp.to_string()),
    ];
    let facts = facts.map(|(name, value)| (name.to_string(), value));
    frame.attributes.extend(facts);
    Ok(count)
}

/// The pixels of a row that are not trusted and see a surface, and their indirect light.
fn trace_row(paths: &Paths, y: u32, trust: &[f32]) -> Result<Vec<(usize, Vec3)>, TraceError> {
    if trust.iter().all(|&t| t >= 1.0) {
        return Ok(Vec::new());
    }
    let seen = paths.visible(y);
    let chosen: Vec<usize> = (0..seen.points.len())
        .filter(|&i| trust[seen.pixel[i] as usize] < 1.0)
        .collect();
    let points: Vec<_> = chosen.iter().map(|&i| seen.points[i]).collect();
    let viewers: Vec<Vec3> = chosen.iter().map(|&i| seen.viewers[i]).collect();
    let mut sums = vec![None; trust.len()];
    for (k, light) in (0..).zip(paths.alone) {
        let estimates = paths.of_point_light((k, light), &points, &viewers, y)?;
        for (query, &i) in chosen.iter().enumerate() {
            let [a, b] = estimates.halves(query);
            let value = 0.5 * paths.weight() * (a + b) * light.intensity;
            let sum = &mut sums[seen.pixel[i] as usize];
            *sum = Some(sum.unwrap_or(Vec3::ZERO) + value);
        }
    }
    if !paths.indirect.is_dark() {
        let estimates = paths.of_other_lights(Reflections::More, &points, &viewers, y)?;
        for (query, &i) in chosen.iter().enumerate() {
            let sum = &mut sums[seen.pixel[i] as usize];
            let value = paths.weight() * estimates.mean(query);
            *sum = Some(sum.unwrap_or(Vec3::ZERO) + value);
        }
    }
    let start = y as usize * trust.len();
    let pixels = sums.into_iter().enumerate();
    let pixels = pixels.filter_map(|(x, sum)| Some((start + x, sum?)));
    Ok(pixels.collect())
}
