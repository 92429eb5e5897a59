//! Indirect light at points: the quantity that is learned.
//!
//! For a surface point p, a viewer direction v and an isotropic point light of 1 W/sr at l,
//! s+(p, v, l) is the radiance that leaves p toward v after two or more reflections
//! (Ren et al. 2013, eq. 2): the light that reaches p straight from l is left out.

use crate::TraceError;
use crate::rng::Stream;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use glam::Vec3;
use rayon::prelude::*;

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
    let each = paths / replicates;
    let mut values = vec![Vec3::ZERO; queries.points.len() * replicates as usize];
    values
        .par_chunks_mut(replicates as usize)
        .enumerate()
        .for_each(|(query, row)| {
            let index = first_index + query as u64;
            for (replicate, value) in row.iter_mut().enumerate() {
                let first = replicate as u32 * each;
                let sum: Vec3 = (first..first + each)
                    .map(|path| trace(tracer, &queries, query, stream, index, path))
                    .sum();
                *value = sum / each as f32;
            }
        });
    Ok(Estimates {
        replicates: replicates as usize,
        values,
    })
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

/// One path from a query.
fn trace(
    tracer: &Tracer,
    queries: &Queries,
    query: usize,
    stream: Stream,
    index: u64,
    path: u32,
) -> Vec3 {
    let (mut at, mut v) = (queries.points[query], queries.viewers[query]);
    let light = queries.lights[query];
    let (mut sum, mut throughput) = (Vec3::ZERO, Vec3::ONE);
    for bounce in 0u32.. {
        let u = stream.units(index, path, bounce);
        let (frame, bsdf) = (tracer.frame_at(&at, v), tracer.material_at(&at));
        let local = frame.to_local(v);
        if bounce > 0 {
            let to = light - at.position;
            let distance2 = to.length_squared();
            let l = to / distance2.sqrt();
            let value = bsdf.eval(local, frame.to_local(l));
            if value != Vec3::ZERO {
                let origin = tracer.lift(at.triangle, at.position, l);
                if !tracer.occluded(origin, light - origin, 1.0) {
                    sum += throughput * value / distance2;
                }
            }
        }
        let scatter = bsdf.sample(local, [u[0], u[1], u[2]]);
        throughput *= scatter.weight;
        if bounce > 2 {
            let survival = throughput.max_element().min(0.95);
            if u[3] >= survival {
                break;
            }
            throughput /= survival;
        }
        if throughput == Vec3::ZERO {
            break;
        }
        let l = frame.to_world(scatter.l);
        let origin = tracer.lift(at.triangle, at.position, l);
        let hit = tracer.closest(origin, l, f32::INFINITY);
        let Some(next) = tracer.point_of(&hit) else {
            break;
        };
        (at, v) = (next, -l);
    }
    sum
}
