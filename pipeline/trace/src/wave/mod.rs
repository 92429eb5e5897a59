//! Many paths at once, one bounce after another.
//!
//! Live paths are rows; a bounce takes them sixty-four at a time through the shading kernels,
//! collects the shadow rays and the next rays of all of them, and traces each collection as one
//! batch. Rows keep their order, so sums are folded in the order of the paths.

mod kernels;
mod path;
mod random;
mod run;
mod tile;

use crate::rng::Stream;
use crate::sobol::Table;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use run::{Batch, Wave};

/// Paths that travel together: their columns stay in a core's own cache.
const BATCH: usize = 1024;

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Each row's own point light of 1 W/sr.
    Point {
        /// Whether paths are also connected to what the light's own rays met.
        connect: bool,
    },
    /// The scene's emitting triangles.
    Lamps,
}

/// Which part of the light is wanted of all rows.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) source: Source,
    /// One reflection only, or else two or more.
    pub(crate) direct: bool,
    pub(crate) stream: Stream,
}

/// Where paths start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) point: SurfacePoint,
    /// Unit direction to the viewer.
    pub(crate) viewer: Vec3,
    /// Position of the point light, if that is what shines.
    pub(crate) light: Vec3,
    /// Index of the sample in its stream.
    pub(crate) index: u64,
    /// Which independent part of the sample this is.
    pub(crate) replicate: u32,
}

/// Mean of `each` paths at every row. A row's bits depend on the row, not on the others.
pub(crate) fn estimate(part: &Part, rows: &[Row], each: usize) -> Vec<Vec3> {
    let table = Table::new(each);
    let mut values = vec![Vec3::ZERO; rows.len()];
    let at_once = (BATCH / each).max(1);
    values
        .par_chunks_mut(at_once)
        .zip(rows.par_chunks(at_once))
        .for_each_init(
            || Wave::new(part.tracer),
            |wave, (values, rows)| {
                for (value, mean) in values.iter_mut().zip(means(wave, part, &table, rows, each)) {
                    *value = mean;
                }
            },
        );
    values
}

/// [`estimate`] on one thread, at most [`BATCH`] paths of a row at a time.
fn means(wave: &mut Wave, part: &Part, table: &Table, rows: &[Row], each: usize) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; rows.len()];
    for first_path in (0..each).step_by(BATCH) {
        let paths = BATCH.min(each - first_path);
        let values = wave.run(&Batch {
            part: *part,
            rows,
            paths,
            replicate_paths: each,
            first_path,
            table,
        });
        for (sum, paths) in sums.iter_mut().zip(values.chunks(paths)) {
            *sum += paths.iter().map(|v| v.as_dvec3()).sum::<DVec3>();
        }
    }
    sums.iter().map(|s| (s / each as f64).as_vec3()).collect()
}
