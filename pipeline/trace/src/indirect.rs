//! Indirect light at points: the quantity that is learned.
//!
//! For a surface point p, a viewer direction v and an isotropic point light of 1 W/sr at l,
//! s+(p, v, l) is the radiance that leaves p toward v after two or more reflections
//! (Ren et al. 2013, eq. 2): the light that reaches p straight from l is left out.

use crate::TraceError;
use crate::rng::Stream;
use crate::sobol::Table;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::wave::{Batch, Row, Wave};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Paths that travel together: their columns stay in a core's own cache.
const BATCH: usize = 1024;

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

/// Estimates s+ at every query with `paths` paths of unlimited depth, split evenly over
/// `replicates` independent estimates (2 give two halves; 16 or more give a usable standard
/// error). Query i draws its numbers at index `first_index + i` of `stream`, whatever
/// the batch it stands in.
pub fn indirect(
    tracer: &Tracer,
    queries: Queries,
    paths: u32,
    replicates: u32,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    queries.check()?;
    if replicates == 0 || paths == 0 || !paths.is_multiple_of(replicates) {
        return Err(TraceError::Paths { paths, replicates });
    }
    let each = (paths / replicates) as usize;
    let rows = rows(&queries, replicates, first_index);
    let table = Table::new(each);
    let mut values = vec![Vec3::ZERO; rows.len()];
    let at_once = (BATCH / each).max(1);
    values
        .par_chunks_mut(at_once)
        .zip(rows.par_chunks(at_once))
        .for_each_init(
            || Wave::new(tracer),
            |wave, (values, rows)| {
                let mut sums = vec![DVec3::ZERO; rows.len()];
                for first_path in (0..each).step_by(BATCH) {
                    let paths = BATCH.min(each - first_path);
                    wave.run(&Batch {
                        tracer,
                        rows,
                        paths,
                        replicate_paths: each,
                        first_path,
                        stream,
                        table: &table,
                    });
                    for (sum, paths) in sums.iter_mut().zip(wave.sums.chunks(paths)) {
                        *sum += paths.iter().map(|v| v.as_dvec3()).sum::<DVec3>();
                    }
                }
                for (value, sum) in values.iter_mut().zip(sums) {
                    *value = (sum / each as f64).as_vec3();
                }
            },
        );
    Ok(Estimates {
        replicates: replicates as usize,
        values,
    })
}

/// One row for every replicate of every query.
fn rows(queries: &Queries, replicates: u32, first_index: u64) -> Vec<Row> {
    let columns = queries
        .points
        .iter()
        .zip(queries.viewers)
        .zip(queries.lights);
    columns
        .enumerate()
        .flat_map(|(query, ((&point, &viewer), &light))| {
            (0..replicates).map(move |replicate| Row {
                point,
                viewer,
                light,
                index: first_index + query as u64,
                replicate,
            })
        })
        .collect()
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
}
