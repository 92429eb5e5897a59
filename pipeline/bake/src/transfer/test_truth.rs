//! The path tracer's answer to test rows.

use glam::Vec3;
use rrf_lights::{DistantLight, PointLight};
use rrf_sampling::Stream;
use rrf_trace::{
    Estimates, Estimator, Illumination, Queries, Reflections, Sampling, SurfacePoint, TraceError,
    Tracer, indirect_with, own_light, sun_light,
};
use rrf_transfer::RowPoint;

/// How paths to lights are made.
const ESTIMATOR: Estimator = Estimator::Connected;

/// A light that shines on test rows.
pub(super) enum Shining<'a> {
    /// A point.
    Point(PointLight),
    /// A sun.
    Sun(DistantLight),
    /// The lights of this tracer's scene, with their lamps in it.
    Own(&'a Tracer<'a>),
}

/// Indirect light of rows of `tracer`'s scene, whose triangles are those of `kept` in the whole one; row i draws
/// at index `first + i` of the stream.
pub(super) fn truth(
    tracer: &Tracer,
    light: &Shining,
    kept: &[usize],
    rows: &[RowPoint],
    (sampling, stream, first): (Sampling, Stream, u64),
) -> Result<Estimates, TraceError> {
    let viewers: Vec<Vec3> = rows.iter().map(|row| row.viewer).collect();
    let points: Vec<SurfacePoint> = rows.iter().map(|row| row.point).collect();
    let (points, viewers) = (&points[..], &viewers[..]);
    match light {
        Shining::Point(point) => {
            let queries = Queries {
                points,
                viewers,
                lights: &vec![point.position; rows.len()],
            };
            indirect_with(tracer, queries, sampling, ESTIMATOR, stream, first)
        }
        Shining::Sun(sun) => {
            let queries = Queries {
                points,
                viewers,
                lights: &vec![sun.toward; rows.len()],
            };
            sun_light(tracer, queries, (ESTIMATOR, sampling), stream, first)
        }
        Shining::Own(whole) => {
            let sources = whole.scene().lights.iter();
            let sources = sources.map(|light| light.source.clone());
            let lights = whole.light_set(None, sources)?;
            let illumination = Illumination {
                lights: &lights,
                reflections: Reflections::More,
                estimator: ESTIMATOR,
            };
            let renamed = |point: &SurfacePoint| SurfacePoint {
                triangle: kept[point.triangle as usize] as u32,
                ..*point
            };
            let points: Vec<SurfacePoint> = points.iter().map(renamed).collect();
            own_light(
                whole,
                illumination,
                &points,
                viewers,
                sampling,
                stream,
                first,
            )
        }
    }
}
