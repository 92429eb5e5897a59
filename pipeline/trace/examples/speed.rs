//! How fast the tracer is in the Cornell box: rays, paths, and what a path is worth.
//!
//!     cargo run --release -p rrf-trace --example speed [SCENE]
//!
//! Rays: nanoseconds each on one thread. Paths: indirect light at surface points seen from the
//! room, point lights under the ceiling; millions of paths a second on all threads, the
//! relative variance of one path, and their quotient in microseconds: the time in which a
//! relative variance of 1 is reached (standard error 1 % in 10^4 times that).

use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{LoadOptions, load};
use rrf_trace::{Estimator, Hits, Queries, Rays, Sampling, SurfacePoint, Tracer, indirect_with};
use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

const RAYS: u64 = 200_000;
const PATHS: u64 = 1 << 19;
const REPETITIONS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let default = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    let path = std::env::args_os()
        .nth(1)
        .map_or(PathBuf::from(default), PathBuf::from);
    let scene = load(&path, &LoadOptions::default())?.unlit();
    let bounds = scene.bounds().ok_or("a scene without extent")?;
    let tracer = Tracer::new(&scene)?;
    println!("{}: {} triangles", path.display(), scene.triangles.len());
    let middle = 0.5 * (Vec3::from(bounds.min) + Vec3::from(bounds.max));
    let size = 0.5 * (Vec3::from(bounds.max) - Vec3::from(bounds.min));
    time_rays(&tracer, middle);
    for estimator in [Estimator::NextEvent, Estimator::Connected] {
        for paths in [128, 1024] {
            time_paths(&tracer, middle, size, estimator, paths)?;
        }
    }
    Ok(())
}

/// Points all over the surface, seen from the side of the room's middle.
fn points(tracer: &Tracer, middle: Vec3, count: u64) -> Vec<(SurfacePoint, Vec3, [f32; 4])> {
    let stream = Stream::new(1, Stage::Test, 0);
    (0..count)
        .map(|i| {
            let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
            let point = tracer.sample_area([u[0], u[1], u[2]]);
            let side = point.normal * point.normal.dot(middle - point.position).signum();
            let aside = Vec3::new(w[0], w[1], w[2]) * 2.0 - 1.0;
            (
                point,
                (side * 1.5 + aside).normalize(),
                stream.units(i, 0, 2),
            )
        })
        .collect()
}

fn time_rays(tracer: &Tracer, middle: Vec3) {
    let mut rays = Rays::default();
    for (point, direction, _) in points(tracer, middle, RAYS) {
        let origin = tracer.lift(point.triangle, point.position, direction);
        rays.push(origin, direction, f32::INFINITY);
    }
    let (mut hits, mut blocked) = (Hits::default(), Vec::new());
    let best = |work: &mut dyn FnMut()| {
        let seconds = (0..REPETITIONS).map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        });
        seconds.fold(f64::INFINITY, f64::min) * 1e9 / RAYS as f64
    };
    let closest = best(&mut || tracer.closest(&rays, &mut hits));
    let shadow = best(&mut || tracer.occluded(&rays, &mut blocked));
    println!("rays: closest {closest:.0} ns, any {shadow:.0} ns");
}

fn time_paths(
    tracer: &Tracer,
    middle: Vec3,
    size: Vec3,
    estimator: Estimator,
    paths: u32,
) -> Result<(), Box<dyn Error>> {
    let (mut places, mut viewers, mut lights) = (Vec::new(), Vec::new(), Vec::new());
    for (point, viewer, u) in points(tracer, middle, PATHS / u64::from(paths)) {
        places.push(point);
        viewers.push(viewer);
        let low = Vec3::new(-0.6, 0.3, -0.6);
        let high = Vec3::new(0.6, 0.8, 0.6);
        lights.push(middle + size * (low + (high - low) * Vec3::new(u[0], u[1], u[2])));
    }
    let queries = Queries {
        points: &places,
        viewers: &viewers,
        lights: &lights,
    };
    let sampling = Sampling {
        paths,
        replicates: 16,
    };
    let mut best = f64::INFINITY;
    let mut variance = 0.0;
    for _ in 0..REPETITIONS {
        let start = Instant::now();
        let stream = Stream::new(2, Stage::Test, 0);
        let found = indirect_with(tracer, queries, sampling, estimator, stream, 0)?;
        best = best.min(start.elapsed().as_secs_f64());
        variance = relative_variance(&found, paths);
    }
    let million = PATHS as f64 / best * 1e-6;
    println!(
        "{estimator:?}, {paths} paths: {million:.2} M paths/s, relative variance a path \
         {variance:.2}, quotient {:.2} us",
        variance / million
    );
    Ok(())
}

/// Median over the lit queries of one path's variance, relative to the squared mean.
fn relative_variance(found: &rrf_trace::Estimates, paths: u32) -> f64 {
    let mut all: Vec<f64> = (0..found.len())
        .filter(|&q| found.mean(q).max_element() > 0.0)
        .map(|q| {
            let error = f64::from(found.standard_error(q).element_sum());
            let mean = f64::from(found.mean(q).element_sum());
            (error / mean).powi(2) * f64::from(paths)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}
