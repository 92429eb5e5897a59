//! Many paths at once, one bounce after another.
//!
//! Live paths are rows; a bounce takes them sixty-four at a time through the shading kernels,
//! collects the shadow rays and the next rays of all of them, and traces each collection as one
//! batch. Rows keep their order, so sums are folded in the order of the paths.

mod kernels;
mod lanes;
mod light_subpath;
mod load;
mod part;
mod path;
mod random;
mod run;
mod shade;
mod specular;
mod tile;

use glam::{DVec3, Vec3};
pub(crate) use part::{Part, Row, Source};
use rayon::prelude::*;
use rrf_sampling::sobol::Table;
use run::{Batch, Wave};

/// Paths that travel together: their columns stay in a core's own cache.
const BATCH: usize = 1024;

/// From its second reflection on, a path goes on with probability KEEP times its throughput
/// relative to the first one (at most 1). Larger: longer paths, less variance each; the
/// product with the time they take is flat about here.
pub(crate) const KEEP: f32 = 1.5;

/// Mean of `each` paths at every row. A row's bits depend on the row, not on the others. A tracer
/// that is told to give up leaves values of no meaning: the caller has to ask it.
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
        if part.tracer.is_halted() {
            break;
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracer::Tracer;
    use rrf_sampling::{Stage, Stream};
    use rrf_scene::{LoadOptions, load};
    use std::path::Path;

    /// Roulette changes how long paths are, not what they find: means of eight queries with
    /// short paths, long paths and paths that end in the open only.
    #[test]
    fn roulette_is_unbiased() {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
        let scene = load(&path, &LoadOptions::default()).unwrap().unlit();
        let tracer = Tracer::new(&scene).unwrap();
        let rows: Vec<Row> = (0..8 * 64)
            .map(|row| {
                let u = Stream::new(91, Stage::Test, 0).units(row / 64, 0, 0);
                let point = tracer.sample_area([u[0], u[1], u[2]]);
                let inward = Vec3::new(0.0, 1.0, 0.0) - point.position;
                Row {
                    point,
                    viewer: point.normal * point.normal.dot(inward).signum(),
                    light: Vec3::new(0.5 - u[3], 1.7, 0.3 * u[0]),
                    index: row / 64,
                    replicate: (row % 64) as u32,
                }
            })
            .collect();
        let run = |keep, seed| {
            let part = Part {
                tracer: &tracer,
                source: Source::Point { connect: true },
                direct: false,
                broad: false,
                keep,
                openings: None,
                stream: Stream::new(seed, Stage::Test, 0),
            };
            let values = estimate(&part, &rows, 128);
            values.chunks(64).map(statistics).collect::<Vec<_>>()
        };
        let never = run(f32::INFINITY, 1);
        for (keep, seed) in [(KEEP, 2), (0.4, 3)] {
            for ((a, va), (b, vb)) in never.iter().zip(run(keep, seed)) {
                // 24 differences a run: Šidák at 1e-5 for all 48 is 5.1; Student's t with about
                // 100 degrees of freedom adds a tenth.
                let error = Vec3::from((*va + vb + 1e-30).to_array().map(f32::sqrt));
                let z = (*a - b) / error;
                assert!(z.abs().max_element() < 5.6, "keep {keep}: {a} {b}");
            }
        }
    }

    /// Mean of replicates and its variance.
    fn statistics(values: &[Vec3]) -> (Vec3, Vec3) {
        let n = values.len() as f32;
        let mean = values.iter().sum::<Vec3>() / n;
        let squares: Vec3 = values.iter().map(|v| (*v - mean) * (*v - mean)).sum();
        (mean, squares / (n * (n - 1.0)))
    }
}
