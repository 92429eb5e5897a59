//! The estimators against the plain reference, and against each other.

use crate::chi_square::chi_square_tail;
use crate::reference::{Plain, Random, mean_of};
use crate::scenes::{Builder, cornell, lambert, principled};
use crate::statistics::assert_z;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{
    Estimator, Queries, Rays, Reflections, Sampling, SurfacePoint, Tracer, indirect, indirect_with,
    lamp_light,
};

/// A room open to the front, of two metals, a glossy dielectric and Lambert walls, with a box
/// inside it and a lamp under the ceiling.
pub fn room(lamp: bool) -> Scene {
    let mut builder = Builder::default();
    let red = builder.material(lambert(Vec3::new(0.7, 0.1, 0.05)));
    let floor = builder.material(principled(Vec3::new(0.5, 0.6, 0.7), 0.4, 0.0, 0.8));
    let steel = builder.material(principled(Vec3::splat(0.8), 0.5, 1.0, 0.5));
    let brass = builder.material(principled(Vec3::new(0.9, 0.7, 0.3), 0.6, 0.7, 0.5));
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    builder.quad(corner, z, x, floor, INVALID);
    builder.quad(corner + y, x, z, red, INVALID);
    builder.quad(corner, x, y, steel, INVALID);
    builder.quad(corner, y, z, red, INVALID);
    builder.quad(corner + x, z, y, brass, INVALID);
    let low = Vec3::new(-0.3, 0.0, -0.4);
    builder.cuboid(low, low + Vec3::new(0.6, 0.7, 0.5), false, steel, INVALID);
    if lamp {
        let black = builder.material(lambert(Vec3::ZERO));
        let light = builder.light(Vec3::new(3.0, 2.0, 1.0), false);
        let corner = Vec3::new(-0.6, 1.9, -0.6);
        builder.quad(corner, Vec3::X * 1.2, Vec3::Z * 1.2, black, light);
    }
    builder.scene
}

/// Points that are seen from the open front, and lights, some of them near the box and the
/// walls.
pub fn views(tracer: &Tracer, count: u64) -> (Vec<SurfacePoint>, Vec<Vec3>, Vec<Vec3>) {
    let eye = Vec3::new(0.2, 1.0, 2.5);
    let stream = Stream::new(71, Stage::Test, 0);
    let (mut points, mut viewers, mut lights) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0.. {
        if points.len() as u64 == count {
            break;
        }
        let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        let v = (eye - point.position).normalize();
        let mut sight = Rays::default();
        sight.push(
            tracer.lift(point.triangle, point.position, v),
            eye - point.position,
            1.0,
        );
        let mut blocked = Vec::new();
        tracer.occluded(&sight, &mut blocked);
        if point.normal.dot(v).abs() > 0.1 && !blocked[0] {
            points.push(point);
            viewers.push(v);
            // Above the boxes; some of them a centimetre from a wall.
            let at = Vec3::new(1.98 * w[0], 1.25 + 0.74 * w[1], 1.98 * w[2]);
            lights.push(at - Vec3::new(0.99, 0.0, 0.99));
        }
    }
    (points, viewers, lights)
}

const SAMPLING: Sampling = Sampling {
    paths: 65_536,
    replicates: 128,
};

#[test]
fn indirect_light_is_that_of_the_plain_tracer() {
    let scene = room(false);
    let tracer = Tracer::new(&scene).unwrap();
    assert!(
        tracer.has_mirrors(),
        "the steel is to be looked at on purpose"
    );
    let (points, viewers, lights) = views(&tracer, 8);
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let plain = Plain { scene: &scene };
    let truth: Vec<(Vec3, Vec3)> = (0..points.len())
        .map(|q| {
            let mut random = Random::new(1_000 + q as u64);
            let point = &points[q];
            let (position, v) = (point.position.as_dvec3(), viewers[q].as_dvec3());
            let start = plain.place(point.triangle as usize, position, v);
            mean_of(100_000, || {
                plain.indirect(start, lights[q].as_dvec3(), &mut random)
            })
        })
        .collect();
    for estimator in [Estimator::Connected, Estimator::NextEvent] {
        let stream = Stream::new(72, Stage::Test, 0);
        let found = indirect_with(&tracer, queries, SAMPLING, estimator, stream, 0).unwrap();
        for (q, &(mean, error)) in truth.iter().enumerate() {
            let own = found.standard_error(q);
            let both = (own * own + error * error).to_array().map(f32::sqrt);
            let name = format!("{estimator:?}, query {q}");
            assert_z(
                &name,
                found.mean(q),
                both.into(),
                mean,
                0.0,
                2 * truth.len(),
            );
        }
    }
}

/// Emitted plus direct plus indirect light is the full light that a path finds by chance.
#[test]
fn lamp_light_is_that_of_the_plain_tracer() {
    let scene = room(true);
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, _) = views(&tracer, 8);
    let plain = Plain { scene: &scene };
    let light = |reflections, seed| {
        let stream = Stream::new(seed, Stage::Test, 0);
        lamp_light(&tracer, &points, &viewers, reflections, SAMPLING, stream, 0).unwrap()
    };
    let (one, more) = (light(Reflections::One, 1), light(Reflections::More, 2));
    for (q, point) in points.iter().enumerate() {
        let mut random = Random::new(2_000 + q as u64);
        let (position, v) = (point.position.as_dvec3(), viewers[q].as_dvec3());
        let start = plain.place(point.triangle as usize, position, v);
        let (truth, error) = mean_of(100_000, || plain.lamps(start, &mut random));
        let sum = tracer.emission(point, viewers[q]) + one.mean(q) + more.mean(q);
        let (e1, e2) = (one.standard_error(q), more.standard_error(q));
        let all = (e1 * e1 + e2 * e2 + error * error)
            .to_array()
            .map(f32::sqrt);
        assert_z(
            &format!("query {q}"),
            sum,
            all.into(),
            truth,
            0.0,
            points.len(),
        );
    }
}

/// Two independent runs differ by what their standard errors say: over 400 queries the squares
/// of the differences, in units of both errors, sum to 400 or so. Squares of Student's t with
/// 63 degrees of freedom have mean 63 / 61 and a variance of 2.2.
#[test]
fn standard_errors_are_honest() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, lights) = views(&tracer, 400);
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let run = |seed| {
        indirect(
            &tracer,
            queries,
            2_048,
            64,
            Stream::new(seed, Stage::Test, 0),
            0,
        )
        .unwrap()
    };
    let (a, b) = (run(1), run(2));
    let sum: f64 = (0..points.len())
        .map(|q| {
            let (x, y) = (a.standard_error(q).x, b.standard_error(q).x);
            let z = (a.mean(q).x - b.mean(q).x) / (x * x + y * y).sqrt();
            f64::from(z * z) * 61.0 / 63.0
        })
        .sum();
    let p = chi_square_tail(sum / 1.1, points.len() as f64 / 1.1);
    assert!(
        p > 1e-6 && p < 1.0 - 1e-6,
        "squares sum to {sum:.1}, p = {p:.2e}"
    );
}

/// The two halves of a query know nothing of each other: their deviations from a long run are
/// uncorrelated over 400 queries (z of the correlation).
#[test]
fn halves_are_independent() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, lights) = views(&tracer, 400);
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let short = indirect(&tracer, queries, 128, 2, Stream::new(3, Stage::Test, 0), 0).unwrap();
    let long = indirect(
        &tracer,
        queries,
        16_384,
        2,
        Stream::new(4, Stage::Test, 0),
        0,
    )
    .unwrap();
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for q in 0..points.len() {
        let truth = long.mean(q);
        let [x, y] = short
            .halves(q)
            .map(|h| f64::from((h.y - truth.y) / truth.y));
        xy += x * y;
        xx += x * x;
        yy += y * y;
    }
    let z = xy / (xx * yy).sqrt() * (points.len() as f64).sqrt();
    assert!(z.abs() < 4.9, "correlation of the halves: z = {z:.2}");
}

/// A light in a closed box reaches nothing outside it, not even where the box's bottom lies
/// 3e-8 from the floor: exact zeros.
#[test]
fn sealed_lights_do_not_leak() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers, _) = views(&tracer, 200);
    for light in [
        Vec3::new(0.33, 0.3, 0.37),
        Vec3::new(0.33, 0.001, 0.37),
        Vec3::new(-0.33, 0.6, -0.29),
        Vec3::new(-0.33, 1.199, -0.29),
    ] {
        let lights = vec![light; points.len()];
        let queries = Queries {
            points: &points,
            viewers: &viewers,
            lights: &lights,
        };
        let found = indirect(&tracer, queries, 256, 2, Stream::new(5, Stage::Test, 0), 0).unwrap();
        let lit = found.values.iter().filter(|v| **v != Vec3::ZERO).count();
        assert_eq!(lit, 0, "light at {light}");
    }
}
