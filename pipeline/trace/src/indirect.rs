//! Indirect light at points: the quantity that is learned.
//!
//! For a surface point p, a viewer direction v and an isotropic point light of 1 W/sr at l,
//! s+(p, v, l) is the radiance that leaves p toward v after two or more reflections
//! (Ren et al. 2013, eq. 2): the light that reaches p straight from l is left out.

use crate::TraceError;
use crate::bidirectional;
use crate::estimates::{Estimates, Sampling, same_length};
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::wave::{KEEP, Part, Row, Source, estimate};
use glam::Vec3;
use rrf_sampling::Stream;

/// Queries of indirect light: parallel columns of one length.
#[derive(Clone, Copy, Debug)]
pub struct Queries<'a> {
    /// Surface points.
    pub points: &'a [SurfacePoint],
    /// Unit directions to the viewer, world frame.
    pub viewers: &'a [Vec3],
    /// Positions of the isotropic 1 W/sr point lights, world frame.
    pub lights: &'a [Vec3],
}

/// How paths to lights are made. All ways are unbiased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// Next-event estimation at every vertex, connections to a point that the light's own
    /// ray met (a bidirectional tracer with one light vertex; Veach and Guibas 1995), and to points of
    /// flat glossy surfaces that show it the light, weighted by the balance heuristic. Lights near
    /// surfaces and caustics of flat surfaces do no harm.
    #[default]
    Connected,
    /// Light subpaths of up to three vertices, joined to the paths in every way, and points of flat
    /// glossy surfaces that show them a light of any kind: for caustics of all shapes, lamps
    /// beside surfaces, and light that comes in by a second reflection. Dearer a path.
    Bidirectional,
    /// Next-event estimation alone, as most path tracers do it: 1 / distance^2 makes the
    /// variance of lights near surfaces unbounded, and the standard error too small where the
    /// peak was missed.
    NextEvent,
}

/// [`indirect_with`] the default estimator.
pub fn indirect(
    tracer: &Tracer,
    queries: Queries,
    paths: u32,
    replicates: u32,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let sampling = Sampling { paths, replicates };
    let estimator = Estimator::default();
    indirect_with(tracer, queries, sampling, estimator, stream, first_index)
}

/// Estimates s+ at every query. Query i draws its numbers at index `first_index + i` of
/// `stream`, whatever the batch it stands in: any part can be made again alone, and the number
/// of threads does not matter.
pub fn indirect_with(
    tracer: &Tracer,
    queries: Queries,
    sampling: Sampling,
    estimator: Estimator,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let part = Part {
        tracer,
        source: Source::Point {
            connect: estimator != Estimator::NextEvent,
        },
        direct: false,
        broad: false,
        keep: KEEP,
        openings: None,
        stream,
    };
    estimate_queries((&part, estimator), queries, sampling, first_index)
}

/// [`indirect`] of the broad part of each query's surface alone
/// ([`rrf_materials::Bsdf::broad`]): the light that its narrow part sends is left out, whether it came from
/// a mirror or not. The same bits as [`indirect`] where a surface has no narrow part.
pub fn broad_indirect(
    tracer: &Tracer,
    queries: Queries,
    sampling: Sampling,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let part = Part {
        tracer,
        source: Source::Point { connect: true },
        direct: false,
        broad: true,
        keep: KEEP,
        openings: None,
        stream,
    };
    let estimator = Estimator::Connected;
    estimate_queries((&part, estimator), queries, sampling, first_index)
}

fn estimate_queries(
    (part, estimator): (&Part, Estimator),
    queries: Queries,
    sampling: Sampling,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    queries.check()?;
    let each = sampling.each()?;
    let rows = queries.rows(sampling.replicates, first_index);
    Ok(Estimates {
        replicates: sampling.replicates as usize,
        values: part
            .tracer
            .unless_halted(estimator.estimate(part, &rows, each))?,
    })
}

impl Estimator {
    /// Mean of `each` paths at every row.
    pub(crate) fn estimate(self, part: &Part, rows: &[Row], each: usize) -> Vec<Vec3> {
        match self {
            // one reflection has one vertex: there is nothing to join
            Estimator::Bidirectional if !part.direct => bidirectional::estimate(part, rows, each),
            Estimator::NextEvent => {
                let by_map = Part {
                    openings: None,
                    ..*part
                };
                estimate(&by_map, rows, each)
            }
            _ => estimate(part, rows, each),
        }
    }
}

impl Queries<'_> {
    pub(crate) fn check(&self) -> Result<(), TraceError> {
        let expected = self.points.len();
        same_length("viewers", self.viewers.len(), expected)?;
        same_length("lights", self.lights.len(), expected)
    }

    /// One row for every replicate of every query.
    pub(crate) fn rows(&self, replicates: u32, first_index: u64) -> Vec<Row> {
        let columns = self.points.iter().zip(self.viewers).zip(self.lights);
        let queries = columns.zip(first_index..);
        queries
            .flat_map(|(((&point, &viewer), &light), index)| {
                (0..replicates).map(move |replicate| Row {
                    point,
                    viewer,
                    light,
                    index,
                    replicate,
                })
            })
            .collect()
    }
}
