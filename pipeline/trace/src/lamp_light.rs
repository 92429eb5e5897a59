//! Light from the scene's own emitting triangles.

use crate::TraceError;
use crate::estimates::{Estimates, Sampling, same_length};
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::wave::{KEEP, Part, Row, Source, estimate};
use glam::Vec3;
use rrf_sampling::Stream;

/// How often the light of lamps was reflected before it reached the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reflections {
    /// Once: direct light. What a point itself emits is not in it ([`Tracer::emission`]).
    One,
    /// Twice or more: indirect light.
    More,
}

/// Estimates the radiance [W/(sr m^2)] that points send to their viewers when the scene's
/// emitting triangles shine, by unit directions `viewers` (world frame).
///
/// Lamps are found by choosing a point on them by power and by the path's own directions,
/// weighted by the balance heuristic. Zero without lamps. Point i draws its numbers at index
/// `first_index + i` of `stream`.
pub fn lamp_light(
    tracer: &Tracer,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    reflections: Reflections,
    sampling: Sampling,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    same_length("viewers", viewers.len(), points.len())?;
    let each = sampling.each()?;
    let replicates = sampling.replicates;
    let rows: Vec<Row> = points
        .iter()
        .zip(viewers)
        .zip(first_index..)
        .flat_map(|((&point, &viewer), index)| {
            (0..replicates).map(move |replicate| Row {
                point,
                viewer,
                light: Vec3::ZERO,
                index,
                replicate,
            })
        })
        .collect();
    let part = Part {
        tracer,
        source: Source::Lamps,
        direct: reflections == Reflections::One,
        keep: KEEP,
        stream,
    };
    let values = if tracer.lamps.is_empty() {
        vec![Vec3::ZERO; rows.len()]
    } else {
        estimate(&part, &rows, each)
    };
    Ok(Estimates {
        replicates: replicates as usize,
        values,
    })
}
