//! Indirect light at points: the quantity that is learned.
//!
//! For a surface point p, a viewer direction v and an isotropic point light of 1 W/sr at l,
//! s+(p, v, l) is the radiance that leaves p toward v after two or more reflections
//! (Ren et al. 2013, eq. 2): the light that reaches p straight from l is left out.

use crate::TraceError;
use crate::rng::Stream;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::wave::{Part, Row, Source, estimate};
use glam::Vec3;

/// What to estimate: parallel columns of one length.
#[derive(Clone, Copy, Debug)]
pub struct Queries<'a> {
    /// Surface points.
    pub points: &'a [SurfacePoint],
    /// Unit directions to the viewer, world frame.
    pub viewers: &'a [Vec3],
    /// Positions of the isotropic 1 W/sr point lights, world frame.
    pub lights: &'a [Vec3],
}

/// How a point light's paths are made. Both ways are unbiased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// Next-event estimation at every vertex, and connections to a point that the light's own
    /// ray met, weighted by the balance heuristic (a bidirectional tracer with one light vertex;
    /// Veach and Guibas 1995). Lights near surfaces do no harm.
    #[default]
    Connected,
    /// Next-event estimation alone, as most path tracers do it: 1 / distance^2 makes the
    /// variance of lights near surfaces unbounded, and the standard error too small where the
    /// peak was missed.
    NextEvent,
}

/// How much to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Paths a query, of unlimited depth.
    pub paths: u32,
    /// Independent estimates that the paths are split into: 2 give two halves, 16 or more a
    /// usable standard error. Paths of one replicate are stratified together.
    pub replicates: u32,
    /// How paths are made.
    pub estimator: Estimator,
}

/// Independent unbiased estimates of s+ [W/(sr m^2)] at every query.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// How many independent estimates a query has.
    pub replicates: usize,
    /// Shape [queries, replicates], row-major: each the mean of paths / replicates paths.
    pub values: Vec<Vec3>,
}

impl Estimates {
    /// How many queries.
    pub fn len(&self) -> usize {
        self.values.len() / self.replicates.max(1)
    }

    /// Whether there is no query.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Two independent estimates of a query: the mean of the even replicates and of the odd.
    pub fn halves(&self, query: usize) -> [Vec3; 2] {
        let row = self.row(query);
        let mean = |first: usize| {
            let picked = row.iter().skip(first).step_by(2);
            let count = picked.clone().count().max(1);
            picked.copied().sum::<Vec3>() / count as f32
        };
        [mean(0), mean(1)]
    }

    /// Mean of all paths of a query.
    pub fn mean(&self, query: usize) -> Vec3 {
        let row = self.row(query);
        row.iter().copied().sum::<Vec3>() / row.len().max(1) as f32
    }

    /// Standard error of [`Estimates::mean`] a channel, from the spread of the replicates.
    pub fn standard_error(&self, query: usize) -> Vec3 {
        let row = self.row(query);
        let mean = self.mean(query);
        let count = row.len().max(2) as f32;
        let squares: Vec3 = row.iter().map(|&v| (v - mean) * (v - mean)).sum();
        let variance = squares / (count - 1.0) / count;
        Vec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt())
    }

    fn row(&self, query: usize) -> &[Vec3] {
        let first = query * self.replicates;
        self.values
            .get(first..first + self.replicates)
            .unwrap_or(&[])
    }
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
    let sampling = Sampling {
        paths,
        replicates,
        estimator: Estimator::default(),
    };
    indirect_with(tracer, queries, sampling, stream, first_index)
}

/// Estimates s+ at every query. Query i draws its numbers at index `first_index + i` of
/// `stream`, whatever the batch it stands in: any part can be made again alone, and the number
/// of threads does not matter.
pub fn indirect_with(
    tracer: &Tracer,
    queries: Queries,
    sampling: Sampling,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    queries.check()?;
    let each = sampling.each()?;
    let part = Part {
        tracer,
        source: Source::Point {
            connect: sampling.estimator == Estimator::Connected,
        },
        direct: false,
        stream,
    };
    let rows = queries.rows(sampling.replicates, first_index);
    Ok(Estimates {
        replicates: sampling.replicates as usize,
        values: estimate(&part, &rows, each),
    })
}

impl Sampling {
    /// Paths a replicate.
    pub(crate) fn each(&self) -> Result<usize, TraceError> {
        let (paths, replicates) = (self.paths, self.replicates);
        if replicates == 0 || paths == 0 || !paths.is_multiple_of(replicates) {
            return Err(TraceError::Paths { paths, replicates });
        }
        Ok((paths / replicates) as usize)
    }
}

impl Queries<'_> {
    fn check(&self) -> Result<(), TraceError> {
        let expected = self.points.len();
        for (column, found) in [
            ("viewers", self.viewers.len()),
            ("lights", self.lights.len()),
        ] {
            if found != expected {
                return Err(TraceError::Queries {
                    column,
                    found,
                    reference: "points",
                    expected,
                });
            }
        }
        Ok(())
    }

    /// One row for every replicate of every query.
    fn rows(&self, replicates: u32, first_index: u64) -> Vec<Row> {
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
