//! The same views by path tracing: what the nets' frames are judged by.

use crate::compare::EPSILON_SHARE;
use crate::error::RenderError;
use crate::facts;
use crate::frame::{Frame, luminance};
use crate::view::{check_lights, check_view};
use glam::Vec3;
use rayon::prelude::*;
use rrf_trace::{Layers, Lights, Stream, Tracer, View, trace_rows};

/// Stage number of the random streams.
const STAGE_FRAME: u32 = 5;

/// Renders `view` by path tracing with `spp` paths a pixel, shared by its `aa` x `aa` camera
/// rays: a multiple of 2 aa², since every pixel is the mean of two independent halves, which
/// tell the frame's own noise (attribute `rrf.relative_noise`). `progress` is told how many
/// rows of pixels were done.
pub fn trace_frame(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    spp: u32,
    aa: u32,
    seed: u64,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Frame, RenderError> {
    check_view(view)?;
    check_lights(lights)?;
    let stream = Stream::new(seed, STAGE_FRAME, 0);
    let rows = (0..view.height).into_par_iter().map(|y| {
        let layers = trace_rows(tracer, view, lights, y..y + 1, spp, aa, stream)?;
        progress(1);
        Ok(layers)
    });
    let rows = rows.collect::<Result<Vec<Layers>, RenderError>>()?;
    let mean = |pick: fn(&Layers) -> &[Vec<Vec3>; 2]| -> Vec<Vec3> {
        let pairs = rows.iter().map(pick).flat_map(|[a, b]| a.iter().zip(b));
        pairs.map(|(&a, &b)| 0.5 * (a + b)).collect()
    };
    let full = mean(|layers| &layers.full);
    let mut attributes = facts::of_trace(view, lights, aa, spp, seed);
    let noise = relative_noise(&rows, &full);
    attributes.push(("rrf.relative_noise".into(), noise.to_string()));
    Ok(Frame {
        width: view.width,
        height: view.height,
        full,
        direct: Some(mean(|layers| &layers.direct)),
        indirect: Some(mean(|layers| &layers.indirect)),
        cell: None,
        trust: None,
        attributes,
    })
}

/// Relative standard error of the frame's pixels, by the definition of the relative error:
/// the mean of two halves has the variance E[(a - b)²] / 4.
fn relative_noise(rows: &[Layers], full: &[Vec3]) -> f64 {
    let count = full.len().max(1) as f64;
    let mean = full.iter().map(|&p| f64::from(luminance(p))).sum::<f64>() / count;
    let pairs = rows
        .iter()
        .flat_map(|layers| layers.full[0].iter().zip(&layers.full[1]));
    let squares = pairs.zip(full).map(|((&a, &b), &p)| {
        let level = f64::from(luminance(p))
            .max(EPSILON_SHARE * mean)
            .max(f64::MIN_POSITIVE);
        f64::from((a - b).length_squared()) / 12.0 / (level * level)
    });
    (squares.sum::<f64>() / count).sqrt()
}
