//! Pixels that the nets were not trained for, path-traced after all.

use crate::error::RenderError;
use crate::frame::Frame;
use crate::tile::Visible;
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Queries, Sampling, TraceError, Tracer, indirect};

/// Replaces the indirect light of every pixel whose trust is below 1 by that of `spp` paths a
/// pixel and light (a multiple of 2 aa²), and sets its cell to none. Gives the number of pixels.
/// A frame without trust or indirect layer stays as it is. The same bits on any number of
/// threads.
pub fn trace_untrusted(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    frame: &mut Frame,
    spp: u32,
    aa: u32,
    seed: u64,
) -> Result<usize, RenderError> {
    let aa = aa.max(1);
    if spp == 0 || !spp.is_multiple_of(2 * aa * aa) {
        return Err(RenderError::Samples { samples: spp, aa });
    }
    let sampling = Sampling {
        paths: spp / (aa * aa),
        replicates: 2,
    };
    let (Some(trust), Some(layer)) = (frame.trust.as_ref(), frame.indirect.as_mut()) else {
        return Ok(0);
    };
    let width = view.width as usize;
    let rows = (0..view.height).into_par_iter().map(|y| {
        let first = y as usize * width;
        let wanted: Vec<bool> = trust[first..first + width]
            .iter()
            .map(|&t| t < 1.0)
            .collect();
        trace_row(tracer, view, lights, y, &wanted, aa, sampling, seed)
    });
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
        ("rrf.fallback".into(), "path tracing".into()),
        ("rrf.fallback_pixels".into(), count.to_string()),
        ("rrf.fallback_paths_per_pixel".into(), spp.to_string()),
    ];
    frame.attributes.extend(facts);
    Ok(count)
}

/// The wanted pixels of a row that see a surface, and their indirect light.
#[allow(clippy::too_many_arguments)]
fn trace_row(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    y: u32,
    wanted: &[bool],
    aa: u32,
    sampling: Sampling,
    seed: u64,
) -> Result<Vec<(usize, Vec3)>, TraceError> {
    if !wanted.contains(&true) {
        return Ok(Vec::new());
    }
    let seen = Visible::of_row(tracer, view, y, aa);
    let chosen: Vec<usize> = (0..seen.points.len())
        .filter(|&i| wanted[seen.pixel[i] as usize])
        .collect();
    let points: Vec<_> = chosen.iter().map(|&i| seen.points[i]).collect();
    let viewers: Vec<Vec3> = chosen.iter().map(|&i| seen.viewers[i]).collect();
    let mut sums = vec![None; view.width as usize];
    let weight = 1.0 / (aa * aa) as f32;
    // every ray of the frame has its own index in a light's stream
    let first = u64::from(y) * u64::from(view.width) * u64::from(aa * aa);
    for (k, light) in (0u32..).zip(&lights.points) {
        let places = vec![light.position; points.len()];
        let queries = Queries {
            points: &points,
            viewers: &viewers,
            lights: &places,
        };
        let stream = Stream::new(seed, Stage::Fallback, k);
        let Sampling { paths, replicates } = sampling;
        let estimates = indirect(tracer, queries, paths, replicates, stream, first)?;
        for (query, &i) in chosen.iter().enumerate() {
            let halves = estimates.halves(query);
            let value = 0.5 * weight * (halves[0] + halves[1]) * light.intensity;
            let sum = &mut sums[seen.pixel[i] as usize];
            *sum = Some(sum.unwrap_or(Vec3::ZERO) + value);
        }
    }
    let pixels = sums.into_iter().enumerate();
    let start = y as usize * view.width as usize;
    Ok(pixels
        .filter_map(|(x, sum)| sum.map(|sum| (start + x, sum)))
        .collect())
}
