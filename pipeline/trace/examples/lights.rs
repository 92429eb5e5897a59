//! Cost of lights to a path, and gain of knowing where they come in.
//!
//!     cargo run --release -p rrf-trace --example lights                     1,000 emitters against 10
//!     cargo run --release -p rrf-trace --example lights -- SCENE SKY.exr    a sky seen through windows
//!
//! Emitters: a closed room with small lamps all over its ceiling; nanoseconds of processor time a path, all threads together.
//! Sky: direct, indirect and full light at points that the scene's camera sees, by the sky's map alone
//! (`next-event`), by openings too (`connected`, as frames are traced), and, with a third word, by paths from both ends;
//! relative variance of a path times its time, averaged over the points.

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
const PARTS: [Reflections; 2] = [Reflections::One, Reflections::More];
/// Paths a point.
const PATHS: u32 = 1_024;
/// Points along each side of the picture.
const SIDE: usize = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [one, two, three] = ESTIMATORS;
    match arguments.as_slice() {
        [] => emitters(),
        [scene, sky] => through_windows(scene, sky, &[one, two]),
        [scene, sky, _] => through_windows(scene, sky, &[one, two, three]),
        _ => Err("give nothing, or SCENE SKY.exr [both]".into()),
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
                .map(|_| {
                    let asked = (&lights, Reflections::More, estimator);
                    Ok(time(&tracer, asked, &points, &viewers, 512)?.0)
                })
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
    (lights, reflections, estimator): (&LightSet, Reflections, Estimator),
    points: &[SurfacePoint],
    viewers: &[Vec3],
    paths: u32,
) -> Result<(f64, Estimates), Box<dyn Error>> {
    let illumination = Illumination {
        lights,
        reflections,
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
fn through_windows(
    path: &Path,
    sky: &Path,
    estimators: &[Estimator],
) -> Result<(), Box<dyn Error>> {
    let source = match sky.to_str() {
        Some("constant") => SkySource::Constant([1.0; 3]),
        _ => SkySource::Picture(sky.to_path_buf()),
    };
    let options = LoadOptions {
        sky: Some(SkyOption {
            source,
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    let scene = load(path, &options)?;
    let tracer = Tracer::new(&scene)?;
    let skies = scene.lights.iter().map(|light| light.source.clone());
    let skies: Vec<LightSource> = skies.filter(|l| l.kind() == "environment").collect();
    let dark = vec![Vec3::ZERO; scene.area_lights.len()];
    let mut lights = tracer.light_set(Some(&dark), skies)?;
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
    tracer.find_openings(
        &mut lights,
        &points,
        &viewers,
        Stream::new(3, Stage::Test, 0),
    );
    // means that all agree on
    let truth = PARTS.map(|part| {
        let asked = (&lights, part, Estimator::Connected);
        time(&tracer, asked, &points, &viewers, 4 * PATHS)
    });
    let [direct, indirect] = truth;
    let (direct, indirect) = (direct?.1, indirect?.1);
    let mut first: Option<Vec<f64>> = None;
    for &estimator in estimators {
        let [direct_found, indirect_found] = PARTS.map(|part| {
            let asked = (&lights, part, estimator);
            time(&tracer, asked, &points, &viewers, PATHS)
        });
        let (direct_found, indirect_found) = (direct_found?, indirect_found?);
        let mut costs = Vec::new();
        for (name, parts) in [
            ("direct", vec![(&direct, &direct_found)]),
            ("indirect", vec![(&indirect, &indirect_found)]),
            (
                "full",
                vec![(&direct, &direct_found), (&indirect, &indirect_found)],
            ),
        ] {
            let taken: f64 = parts.iter().map(|(_, (taken, _))| taken).sum();
            // variance of a path by the spread of the replicates, over the squared mean
            let relative = (0..points.len()).filter_map(|q| {
                let mean: f32 = parts
                    .iter()
                    .map(|(truth, _)| truth.mean(q).element_sum())
                    .sum();
                let squares = parts.iter().map(|(_, (_, found))| {
                    let error = found.standard_error(q);
                    (error * error).element_sum()
                });
                let variance = f64::from(squares.sum::<f32>() / (mean * mean));
                (mean > 0.0).then_some(variance * f64::from(PATHS))
            });
            let mut relative: Vec<f64> = relative.collect();
            relative.sort_by(f64::total_cmp);
            let mean = relative.iter().sum::<f64>() / relative.len().max(1) as f64;
            let median = relative.get(relative.len() / 2).copied().unwrap_or(0.0);
            costs.extend([mean, median].map(|variance| variance * taken / 1e3));
            let k = costs.len() - 2;
            let gain = |k: usize| first.as_ref().map_or(1.0, |first| first[k] / costs[k]);
            println!(
                "{estimator:?}, {name}: {taken:.0} ns a path, relative variance {mean:.2} (median {median:.2}), times \
                 time {:.2} times less (median {:.2}) than by the map",
                gain(k),
                gain(k + 1),
            );
        }
        first.get_or_insert(costs);
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
