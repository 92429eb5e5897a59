//! The same views by path tracing: what the nets' frames are judged by.

use crate::direct::point_lights;
use crate::error::RenderError;
use crate::facts;
use crate::frame::Frame;
use crate::tile::{Tile, Visible};
use crate::view::{Lights, View};
use glam::Vec3;
use rrf_trace::{Queries, Stream, Tracer, indirect};

/// Stage number of the random streams.
const STAGE_FRAME: u32 = 5;

/// Renders `view` by path tracing: direct light of point lights exactly, indirect light by
/// `spp` paths a pixel, shared by its `aa` x `aa` camera rays. `progress` is told how many
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
    view.check()?;
    lights.check()?;
    let aa = aa.max(1);
    if spp == 0 || !spp.is_multiple_of(aa * aa) {
        return Err(RenderError::Samples { samples: spp, aa });
    }
    if lights.area && !tracer.scene().area_lights.is_empty() {
        return Err(RenderError::AreaLights);
    }
    let (mut direct, mut reflected) = (Vec::new(), Vec::new());
    for y in 0..view.height {
        let row = trace_row(tracer, view, lights, y, [spp / (aa * aa), aa], seed)?;
        direct.extend(row.0);
        reflected.extend(row.1);
        progress(1);
    }
    Ok(Frame {
        width: view.width,
        height: view.height,
        full: direct.iter().zip(&reflected).map(|(a, b)| a + b).collect(),
        direct: Some(direct),
        indirect: Some(reflected),
        cell: None,
        trust: None,
        attributes: facts::of_trace(view, lights, aa, spp, seed),
    })
}

/// Direct and indirect light of one row of pixels.
fn trace_row(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    y: u32,
    [paths, aa]: [u32; 2],
    seed: u64,
) -> Result<(Vec<Vec3>, Vec<Vec3>), RenderError> {
    let tile = Tile {
        x: 0,
        y,
        width: view.width,
        height: 1,
    };
    let seen = Visible::shoot(tracer, view, tile, aa);
    let weight = 1.0 / (aa * aa) as f32;
    let viewers: Vec<Vec3> = (0..seen.points.len()).map(|r| seen.viewer(r)).collect();
    let mut direct = vec![Vec3::ZERO; tile.pixels()];
    let exact = point_lights(tracer, &seen, &lights.points);
    seen.gather(exact.into_iter(), weight, &mut direct);

    let mut reflected = vec![Vec3::ZERO; tile.pixels()];
    // Every ray of the frame has its own index in the light's stream.
    let first = u64::from(y) * u64::from(view.width) * u64::from(aa * aa);
    for (k, light) in lights.points.iter().enumerate() {
        let places = vec![light.position; viewers.len()];
        let queries = Queries {
            points: &seen.points,
            viewers: &viewers,
            lights: &places,
        };
        let stream = Stream::new(seed, STAGE_FRAME, k as u32);
        let estimates = indirect(tracer, queries, paths, 1, stream, first)?;
        let values = (0..estimates.len()).map(|r| light.intensity * estimates.mean(r));
        seen.gather(values, weight, &mut reflected);
    }
    Ok((direct, reflected))
}
