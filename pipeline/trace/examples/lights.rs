//! Cost of lights to a path, and gain of knowing where they come in.
//!
//!     cargo run --release -p rrf-trace --example lights                     1,000 emitters against 10
//!     cargo run --release -p rrf-trace --example lights -- SCENE SKY.exr    a sky seen through windows
//!
//! Emitters: a closed room with small lamps all over its ceiling; nanoseconds of processor time a path, all threads together.
//! Sky: indirect light at points that the scene's camera sees, by every estimator; relative variance
//! of a path times its time, averaged over the points. `next-event` samples the sky by its map alone.

use glam::Vec3;
use rrf_lights::LightSource;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{AreaLight, INVALID, LoadOptions, Material, Scene, SkyOption, SkySource, load};
use rrf_trace::{
    Estimates, Estimator, Hits, Illumination, LightSet, Rays, Reflections, Sampling, SurfacePoint,
    Tracer, own_light,
};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

const ESTIMATORS: [Estimator; 3] = [
    Estimator::NextEvent,
    Estimator::Connected,
    Estimator::Bidirectional,
];
/// Points along each side of the picture.
const SIDE: usize = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    match arguments.as_slice() {
        [] => emitters(),
        [scene, sky] => through_windows(scene, sky),
        _ => Err("give nothing, or SCENE SKY.exr".into()),
    }
}

/// Nanoseconds a path with few and with many lamps.
fn emitters() -> Result<(), Box<dyn Error>> {
    for estimator in ESTIMATORS {
        let mut times = Vec::new();
        for count in [10, 1_000] {
            let scene = room(count);
            let tracer = Tracer::new(&scene)?;
            let lights = tracer.light_set(None, [])?;
            let stream = Stream::new(2, Stage::Test, 0);
            let points: Vec<SurfacePoint> = (0..256)
                .map(|i| {
                    let u = stream.units(i, 0, 0);
                    tracer.sample_area([u[0], u[1], u[2]])
                })
                .collect();
            let viewers: Vec<Vec3> = points.iter().map(|point| point.normal).collect();
            let best = (0..3)
                .map(|_| Ok(time(&tracer, &lights, estimator, &points, &viewers, 512)?.0))
                .collect::<Result<Vec<f64>, Box<dyn Error>>>()?;
            let best = best.into_iter().fold(f64::INFINITY, f64::min);
            println!("{estimator:?}, {count} emitters: {best:.0} ns a path");
            times.push(best);
        }
        println!("{estimator:?}: {:.2} times as long", times[1] / times[0]);
    }
    Ok(())
}

/// A white room of 2 m with `count` square lamps below its ceiling.
fn room(count: usize) -> Scene {
    let mut scene = Scene::default();
    scene
        .materials
        .push(Material::lambert("white", Vec3::splat(0.7)));
    scene.objects.push("room".into());
    let mut quad = |corner: Vec3, a: Vec3, b: Vec3, light: u32| {
        let first = scene.positions.len() as u32;
        for at in [corner, corner + a, corner + a + b, corner + b] {
            scene.positions.push(at);
            scene.normals.push(Vec3::ZERO);
            scene.uvs.push(glam::Vec2::ZERO);
        }
        for corners in [[0, 1, 2], [0, 2, 3]] {
            scene.triangles.push(corners.map(|v| first + v));
            scene.triangle_material.push(0);
            scene.triangle_light.push(light);
            scene.triangle_object.push(0);
        }
    };
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * 2.0);
    for (corner, a, b) in [
        (Vec3::ZERO, z, x),
        (y, x, z),
        (Vec3::ZERO, y, z),
        (x, z, y),
        (Vec3::ZERO, x, y),
        (z, y, x),
    ] {
        quad(corner, a, b, INVALID);
    }
    let side = (count as f32).sqrt().ceil();
    for k in 0..count as u32 {
        let (column, row) = (k as f32 % side, (k as f32 / side).floor());
        let at = Vec3::new((column + 0.3) / side, 0.98, (row + 0.3) / side) * 2.0;
        let edge = 0.8 / side;
        quad(at, Vec3::X * edge, Vec3::Z * edge, k);
    }
    for k in 0..count {
        let radiance = Vec3::splat(1.0 + (k % 7) as f32);
        scene.area_lights.push(AreaLight {
            radiance,
            two_sided: false,
        });
        scene.area_light_names.push(format!("lamp{k}"));
    }
    scene
}

/// Nanoseconds a path, and what was found.
fn time(
    tracer: &Tracer,
    lights: &LightSet,
    estimator: Estimator,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    paths: u32,
) -> Result<(f64, Estimates), Box<dyn Error>> {
    let illumination = Illumination {
        lights,
        reflections: Reflections::More,
        estimator,
    };
    let sampling = Sampling {
        paths,
        replicates: 16,
    };
    let stream = Stream::new(1, Stage::Test, 0);
    let start = processor_seconds();
    let found = own_light(tracer, illumination, points, viewers, sampling, stream, 0)?;
    let taken = processor_seconds() - start;
    let paths = points.len() as f64 * f64::from(paths);
    Ok((1e9 * taken / paths, found))
}

/// Variance times time under a sky.
fn through_windows(path: &Path, sky: &Path) -> Result<(), Box<dyn Error>> {
    let options = LoadOptions {
        sky: Some(SkyOption {
            source: SkySource::Picture(sky.to_path_buf()),
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    let scene = load(path, &options)?;
    let tracer = Tracer::new(&scene)?;
    let skies = scene.lights.iter().map(|light| light.source.clone());
    let skies: Vec<LightSource> = skies.filter(|l| l.kind() == "environment").collect();
    let dark = vec![Vec3::ZERO; scene.area_lights.len()];
    let lights = tracer.light_set(Some(&dark), skies)?;
    let camera = scene.cameras.first().ok_or("the scene has no camera")?;
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    let tangent = (0.5 * camera.fov.to_radians()).tan();
    for k in 0..SIDE * SIDE {
        let at = |k: usize| ((k as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0) * tangent;
        let aside = camera.right * at(k % SIDE) + camera.up * at(k / SIDE);
        let direction = (camera.forward + aside).normalize();
        rays.push(camera.eye, direction, f32::INFINITY);
    }
    tracer.closest(&rays, &mut hits);
    let (mut points, mut viewers) = (Vec::new(), Vec::new());
    for (k, &triangle) in hits.triangle.iter().enumerate() {
        if triangle != INVALID {
            points.push(tracer.point(triangle, hits.barycentrics[k]));
            viewers.push(-rays.direction[k]);
        }
    }
    // a mean that all agree on, by the estimator with the least noise
    let (_, truth) = time(
        &tracer,
        &lights,
        Estimator::Bidirectional,
        &points,
        &viewers,
        16_384,
    )?;
    let mut first = None;
    for estimator in ESTIMATORS {
        let (taken, found) = time(&tracer, &lights, estimator, &points, &viewers, 4_096)?;
        // variance of a path by the spread of the replicates, over the squared mean
        let relative = (0..points.len()).filter_map(|q| {
            let mean = truth.mean(q).element_sum();
            let error = found.standard_error(q);
            (mean > 0.0).then(|| f64::from((error * error).element_sum() / (mean * mean)) * 4_096.0)
        });
        let mut relative: Vec<f64> = relative.collect();
        relative.sort_by(f64::total_cmp);
        let count = relative.len().max(1) as f64;
        let mean = relative.iter().sum::<f64>() / count;
        let median = relative.get(relative.len() / 2).copied().unwrap_or(0.0);
        let costs = [mean, median].map(|variance| variance * taken / 1e3);
        let first = *first.get_or_insert(costs);
        println!(
            "{estimator:?}: {taken:.0} ns a path, relative variance {mean:.2} (median {median:.2}), times time \
             {:.2} µs (median {:.2} µs), {:.2} (median {:.2}) times less than by the map",
            costs[0],
            costs[1],
            first[0] / costs[0],
            first[1] / costs[1],
        );
    }
    Ok(())
}

/// Processor time of this process so far, where the system tells it in ticks of 10 ms; else the time since
/// the first call.
fn processor_seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let start = START.get_or_init(Instant::now);
    let told = std::fs::read_to_string("/proc/self/stat").ok();
    let ticks = told.and_then(|line| {
        let fields: Vec<&str> = line.rsplit(')').next()?.split_whitespace().collect();
        let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
        Some(ticks(11)? + ticks(12)?)
    });
    ticks.map_or_else(|| start.elapsed().as_secs_f64(), |ticks| ticks / 100.0)
}
