//! Narrow parts of points that are asked about one by one, each with lights of its own.

use super::part::Following;
use super::queue::{Launch, RayQueue};
use super::{FollowedPart, MOST_FOLLOWED};
use crate::direct::SampledLights;
use crate::error::RenderError;
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_field::columns::Columns;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{SurfacePoint, Tracer};

/// Points that are followed together: their rays' columns stay small.
const BLOCK: usize = 256;

/// Points asked about: parallel columns of one length.
#[derive(Clone, Copy, Debug)]
pub struct NarrowQueries<'a> {
    /// Surface points.
    pub points: &'a [SurfacePoint],
    /// Unit directions to the viewer.
    pub viewers: &'a [Vec3],
    /// Rays of each point into a lobe that is not as sharp as a mirror's.
    pub rays: u32,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Surface points that followed rays met: parallel columns.
#[derive(Clone, Copy, Debug)]
pub struct MetPoints<'a> {
    /// Which query each belongs to.
    pub query: &'a [u32],
    /// Surface points.
    pub points: &'a [SurfacePoint],
    /// Unit directions to where the ray came from.
    pub viewers: &'a [Vec3],
    /// Raw columns, the light's left at zero.
    pub rows: &'a Columns,
}

/// Radiance [W/(sr m²)] of each of some points but for what their narrow parts send from other surfaces:
/// direct light, and the model's answer for the broad part.
pub type AnswerMet<'a> = dyn FnMut(&MetPoints) -> Result<Vec<Vec3>, RenderError> + 'a;

/// Radiance [W/(sr m²)] that the narrow parts of some points send to their viewers from other surfaces,
/// followed as in frames. Emission that the rays meet is left out.
pub fn narrow_light(
    tracer: &Tracer,
    queries: NarrowQueries,
    answer: &mut AnswerMet,
) -> Result<Vec<Vec3>, RenderError> {
    let mut sums = vec![Vec3::ZERO; queries.points.len()];
    let (mut seen, mut queue) = (VisiblePoints::default(), RayQueue::default());
    let lights = SampledLights::default();
    for first in (0..queries.points.len()).step_by(BLOCK) {
        let end = (first + BLOCK).min(queries.points.len());
        let (points, viewers) = (&queries.points[first..end], &queries.viewers[first..end]);
        seen.read_points(tracer, points, viewers, first as u32);
        for depth in 0..MOST_FOLLOWED as u32 {
            let parts = parts(&seen, queries.rays, depth);
            let launch = Launch {
                tracer,
                lights: &lights,
                stream: Stream::new(queries.seed, Stage::Followed, depth),
                first: 0,
                gather: 0,
            };
            queue.clear();
            queue.launch(&launch, &mut seen, &parts);
            queue.trace(tracer);
            let rays = (&queue.rays, queue.carried.as_slice());
            seen.read_followed(tracer, rays, &queue.hits);
            if seen.points.is_empty() {
                break;
            }
            let radiance = answer(&MetPoints {
                query: &seen.pixel,
                points: &seen.points,
                viewers: &seen.viewers,
                rows: &seen.rows,
            })?;
            for (carried, radiance) in seen.carried.iter().zip(radiance) {
                sums[carried.pixel as usize] += carried.throughput * radiance;
            }
        }
    }
    Ok(sums)
}

/// The narrow part of each row.
fn parts(seen: &VisiblePoints, rays: u32, depth: u32) -> Vec<Option<FollowedPart>> {
    let following = Following {
        narrow: true,
        ..Following::default()
    };
    let rows = seen.normals.iter().zip(&seen.viewers).zip(&seen.materials);
    let part = |((&normal, &viewer), material)| {
        let mut part = following.part(material, (normal, viewer), 1.0, None)?;
        if depth == 0 && !part.is_sharp {
            part.rays = rays;
        }
        Some(part)
    };
    rows.map(part).collect()
}
