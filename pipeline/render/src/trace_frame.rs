//! The same views by path tracing: what the nets' frames are judged by.

use crate::direct::Direct;
use crate::error::RenderError;
use crate::facts;
use crate::frame::Frame;
use crate::stages::Stages;
use crate::tile::Visible;
use crate::view::{Lights, View};
use glam::Vec3;
use rayon::prelude::*;
use rrf_metrics::color::luminance;
use rrf_metrics::relative::EPSILON_SHARE;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{
    Estimates, Queries, Reflections, Sampling, TraceError, Tracer, indirect, lamp_light,
};

/// Streams of the lamps; point light k has stream k.
const LAMPS: [u32; 2] = [u32::MAX, u32::MAX - 1];

/// Two independent halves of a row's pixels: direct light, then indirect.
type Row = [[Vec<Vec3>; 2]; 2];

/// Renders `view` by path tracing: direct light of point lights exactly, every other light by
/// `spp` paths a pixel and light, shared by its `aa` x `aa` camera rays. `spp` is a multiple of
/// 2 aa²: a pixel is the mean of two independent halves, which tell the frame's own noise
/// (attribute `rrf.relative_noise`). `progress` is told how many rows of pixels were done.
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
    if spp == 0 || !spp.is_multiple_of(2 * aa * aa) {
        return Err(RenderError::Samples { samples: spp, aa });
    }
    let sampling = Sampling {
        paths: spp / (aa * aa),
        replicates: 2,
    };
    let rows = (0..view.height).into_par_iter().map(|y| {
        let row = trace_row(tracer, view, lights, y, aa, sampling, seed)?;
        progress(1);
        Ok(row)
    });
    let rows = rows.collect::<Result<Vec<Row>, RenderError>>()?;
    let layer = |part: usize| -> Vec<Vec3> {
        let halves = rows
            .iter()
            .flat_map(|row| row[part][0].iter().zip(&row[part][1]));
        halves.map(|(&a, &b)| 0.5 * (a + b)).collect()
    };
    let (direct, reflected) = (layer(0), layer(1));
    let full: Vec<Vec3> = direct.iter().zip(&reflected).map(|(a, b)| a + b).collect();
    let mut attributes = facts::of_trace(view, lights, aa, spp, seed);
    let noise = relative_noise(&rows, &full);
    attributes.push(("rrf.relative_noise".into(), noise.to_string()));
    Ok(Frame {
        width: view.width,
        height: view.height,
        full,
        direct: Some(direct),
        indirect: Some(reflected),
        cell: None,
        trust: None,
        attributes,
    })
}

/// One row of pixels.
fn trace_row(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    y: u32,
    aa: u32,
    sampling: Sampling,
    seed: u64,
) -> Result<Row, TraceError> {
    let seen = Visible::of_row(tracer, view, y, aa);
    let viewers = &seen.viewers;
    let black = || vec![Vec3::ZERO; view.width as usize];
    let mut row = [[black(), black()], [black(), black()]];
    let weight = 1.0 / (aa * aa) as f32;
    let mut add = |part: usize, half: usize, values: &mut dyn Iterator<Item = Vec3>| {
        for (&pixel, value) in seen.pixel.iter().zip(values) {
            row[part][half][pixel as usize] += weight * value;
        }
    };

    let mut exact = Direct::default();
    exact.point_lights(tracer, &seen, &lights.points, &mut Stages::default());
    // every ray of the frame has its own index in a light's stream
    let first = u64::from(y) * u64::from(view.width) * u64::from(aa * aa);
    for half in 0..2 {
        add(0, half, &mut exact.radiance.iter().copied());
    }
    for (k, light) in (0u32..).zip(&lights.points) {
        let places = vec![light.position; viewers.len()];
        let queries = Queries {
            points: &seen.points,
            viewers,
            lights: &places,
        };
        let stream = Stream::new(seed, Stage::Frame, k);
        let Sampling { paths, replicates } = sampling;
        let estimates = indirect(tracer, queries, paths, replicates, stream, first)?;
        for half in 0..2 {
            add(
                1,
                half,
                &mut of_half(&estimates, half).map(|v| v * light.intensity),
            );
        }
    }
    if lights.area {
        for (part, reflections) in [Reflections::One, Reflections::More]
            .into_iter()
            .enumerate()
        {
            let stream = Stream::new(seed, Stage::Frame, LAMPS[part]);
            let estimates = lamp_light(
                tracer,
                &seen.points,
                viewers,
                reflections,
                sampling,
                stream,
                first,
            )?;
            for half in 0..2 {
                add(part, half, &mut of_half(&estimates, half));
            }
        }
        let shining = seen.points.iter().zip(viewers);
        let shining: Vec<Vec3> = shining.map(|(p, &v)| tracer.emission(p, v)).collect();
        for half in 0..2 {
            add(0, half, &mut shining.iter().copied());
        }
    }
    Ok(row)
}

fn of_half(estimates: &Estimates, half: usize) -> impl Iterator<Item = Vec3> + '_ {
    (0..estimates.len()).map(move |query| estimates.halves(query)[half])
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
