//! Same names, same bits.

use crate::scenes::cornell;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Queries, SurfacePoint, Tracer, indirect};

fn queries(tracer: &Tracer, count: u64) -> (Vec<SurfacePoint>, Vec<Vec3>, Vec<Vec3>) {
    let stream = Stream::new(81, Stage::Test, 0);
    let (mut points, mut viewers, mut lights) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..count {
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        points.push(point);
        // Into the room, whichever way the wall is wound.
        let inward = Vec3::new(0.0, 1.0, 0.0) - point.position;
        let side = point.normal.dot(inward).signum();
        viewers.push(point.normal * side);
        lights.push(Vec3::new(1.6 * w[0] - 0.8, 1.7, 1.6 * w[2] - 0.8));
    }
    (points, viewers, lights)
}

fn bits(values: &[Vec3]) -> Vec<[u32; 3]> {
    values
        .iter()
        .map(|v| v.to_array().map(f32::to_bits))
        .collect()
}

#[test]
fn threads_and_batches_do_not_matter() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, lights) = queries(&tracer, 77);
    let stream = Stream::new(82, Stage::Extract, 2);
    let run = |from: usize, to: usize| {
        let queries = Queries {
            points: &points[from..to],
            viewers: &viewers[from..to],
            lights: &lights[from..to],
        };
        let found = indirect(&tracer, queries, 96, 2, stream, 1_000 + from as u64).unwrap();
        bits(&found.values)
    };
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
    };
    let one = pool(1).install(|| run(0, 77));
    let two = pool(2).install(|| run(0, 77));
    let three = pool(3).install(|| run(0, 77));
    assert_eq!(one, two);
    assert_eq!(one, three);
    let parts: Vec<[u32; 3]> = [run(0, 1), run(1, 40), run(40, 77)].concat();
    assert_eq!(one, parts);
}

/// More paths a replicate than travel together: they come in several batches.
#[test]
fn long_rows_are_the_mean_of_their_paths() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, lights) = queries(&tracer, 3);
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let long = indirect(
        &tracer,
        queries,
        20_000,
        2,
        Stream::new(83, Stage::Test, 0),
        0,
    )
    .unwrap();
    let split = indirect(
        &tracer,
        queries,
        20_000,
        200,
        Stream::new(83, Stage::Test, 0),
        0,
    )
    .unwrap();
    for q in 0..points.len() {
        if split.mean(q) == Vec3::ZERO {
            // Under a box.
            assert_eq!(long.mean(q), Vec3::ZERO);
            continue;
        }
        // The long rows' errors are below those of the split ones: stratified over more points.
        let z = (long.mean(q) - split.mean(q)) / split.standard_error(q);
        assert!(z.abs().max_element() < 6.5, "query {q}: {z}");
    }
}

#[test]
fn seeds_and_indices_matter() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, lights) = queries(&tracer, 4);
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let run = |seed, index| {
        indirect(
            &tracer,
            queries,
            64,
            2,
            Stream::new(seed, Stage::Test, 0),
            index,
        )
        .unwrap()
    };
    assert_ne!(run(1, 0), run(2, 0));
    assert_ne!(run(1, 0), run(1, 1));
    assert_eq!(run(1, 0), run(1, 0));
}
