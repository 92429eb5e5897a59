//! Closed rooms and constant fields, where radiance follows from a sum.

use crate::scenes::{Builder, lambert, principled};
use crate::statistics::assert_z;
use glam::Vec3;
use rrf_materials::{Bsdf, ShadingFrame};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Material, Scene};
use rrf_trace::{
    Estimates, Estimator, Illumination, Queries, Reflections, Sampling, SurfacePoint, Tracer,
    indirect, lamp_light, own_light,
};

const SAMPLING: Sampling = Sampling {
    paths: 16_384,
    replicates: 64,
};

/// Mean over all queries and its standard error, the queries being independent.
fn pooled(estimates: &Estimates) -> (Vec3, Vec3) {
    let count = estimates.len() as f32;
    let mean = (0..estimates.len())
        .map(|q| estimates.mean(q))
        .sum::<Vec3>()
        / count;
    let variance: Vec3 = (0..estimates.len())
        .map(|q| estimates.standard_error(q) * estimates.standard_error(q))
        .sum();
    let error = variance.to_array().map(|v| v.sqrt() / count);
    (mean, error.into())
}

/// Points on the surface and viewers on the side `inward` of their normals.
fn places(tracer: &Tracer, count: u64, side: f32) -> (Vec<SurfacePoint>, Vec<Vec3>) {
    let stream = Stream::new(41, Stage::Test, 0);
    (0..count)
        .map(|i| {
            let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
            let point = tracer.sample_area([u[0], u[1], u[2]]);
            let v = Vec3::new(w[0] - 0.5, w[1] - 0.5, w[2] - 0.5).normalize();
            let up = point.normal.dot(v) * side > 0.0;
            (point, if up { v } else { -v })
        })
        .unzip()
}

/// A closed box that glows with radiance 1 on its inside.
fn furnace(material: Material) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(material);
    let light = builder.light(Vec3::ONE, false);
    builder.cuboid(
        Vec3::new(-1.0, 0.0, -2.0),
        Vec3::new(1.0, 1.5, 1.0),
        true,
        material,
        light,
    );
    builder.scene
}

/// In a closed room of albedo a whose walls emit 1, every reflection gives back the share a:
/// radiance is 1 + a + a^2 + ... = 1 / (1 - a); direct light is a, indirect a^2 / (1 - a).
#[test]
fn white_furnace() {
    let albedos = [Vec3::new(0.2, 0.5, 0.8), Vec3::new(0.9, 0.0, 0.7)];
    for a in albedos {
        let scene = furnace(lambert(a));
        let tracer = Tracer::new(&scene).unwrap();
        let (points, viewers) = places(&tracer, 20, 1.0);
        let light = |reflections, seed| {
            let stream = Stream::new(seed, Stage::Test, 0);
            lamp_light(&tracer, &points, &viewers, reflections, SAMPLING, stream, 0).unwrap()
        };
        for (point, &v) in points.iter().zip(&viewers) {
            assert_eq!(tracer.emission(point, v), Vec3::ONE);
            assert_eq!(tracer.emission(point, -v), Vec3::ZERO);
        }
        let tests = 2 * albedos.len();
        let (mean, error) = pooled(&light(Reflections::One, 1));
        assert_z("direct", mean, error, a, 0.0, tests);
        let (mean, error) = pooled(&light(Reflections::More, 2));
        assert_z("indirect", mean, error, a * a / (Vec3::ONE - a), 0.0, tests);
    }
}

/// Paths of more than 128 reflections, which end by chance, carry 8 % of the light where the
/// walls reflect 98 % of it: without them, or with too much of them, the sum is missed by more than
/// eight standard errors, by either way of tracing. The room's walls emit 1, so indirect light is
/// a^2 / (1 - a).
#[test]
fn long_paths_are_ended_without_bias() {
    let a = Vec3::new(0.95, 0.97, 0.98);
    let scene = furnace(lambert(a));
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers) = places(&tracer, 6, 1.0);
    let stream = Stream::new(17, Stage::Test, 0);
    let lights = tracer.light_set(None, []).unwrap();
    for estimator in [Estimator::Connected, Estimator::Bidirectional] {
        let illumination = Illumination {
            lights: &lights,
            reflections: Reflections::More,
            estimator,
        };
        let light = own_light(
            &tracer,
            illumination,
            &points,
            &viewers,
            SAMPLING,
            stream,
            0,
        );
        let (mean, error) = pooled(&light.unwrap());
        let truth = a * a / (Vec3::ONE - a);
        assert_z(&format!("{estimator:?}"), mean, error, truth, 0.0, 2);
        assert!((error / truth).z < 0.01, "the test has no power: {error}");
    }
}

/// An estimate that is told to give up is an error, soon: here after the first look.
#[test]
fn a_halted_tracer_gives_no_estimates() {
    let scene = furnace(lambert(Vec3::ONE));
    let halt = || true;
    let tracer = Tracer::new(&scene).unwrap().until(&halt);
    let (points, viewers) = places(&tracer, 4, 1.0);
    let stream = Stream::new(1, Stage::Test, 0);
    let more = Reflections::More;
    let found = lamp_light(&tracer, &points, &viewers, more, SAMPLING, stream, 0);
    assert_eq!(found, Err(rrf_trace::TraceError::Halted));
    assert!(!rrf_trace::TraceError::Halted.is_bad_input());
}

/// Share of a constant field that leaves toward `v`: midpoints over the hemisphere, equal in
/// solid angle, of the scattering values alone.
fn albedo(material: &Material, n: Vec3, v: Vec3) -> Vec3 {
    const STEPS: u32 = 512;
    let (frame, bsdf) = (ShadingFrame::new(n), Bsdf::of(material));
    let mut sum = glam::DVec3::ZERO;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let z = (i as f32 + 0.5) / STEPS as f32;
            let (s, c) = ((j as f32 + 0.5) / STEPS as f32 * std::f32::consts::TAU).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let l = frame.to_world(Vec3::new(r * c, r * s, z));
            sum += bsdf.eval(n, v, l).as_dvec3();
        }
    }
    (sum * std::f64::consts::TAU / f64::from(STEPS * STEPS)).as_vec3()
}

/// A glossy furnace: direct light is the material's albedo toward the viewer. A metal never
/// gives back more than it gets, so all its light stays below the Lambert furnace's 1 / (1 - a)
/// of its base colour a = 0.8.
#[test]
fn glossy_furnace() {
    let materials = [(0.3, 1.0), (0.7, 1.0), (0.4, 0.0), (0.8, 0.5)];
    for (roughness, metallic) in materials {
        let material = principled(Vec3::new(0.8, 0.5, 0.3), roughness, metallic, 0.5);
        let scene = furnace(material.clone());
        let tracer = Tracer::new(&scene).unwrap();
        let (points, viewers) = places(&tracer, 12, 1.0);
        let light = |reflections| {
            let stream = Stream::new(3, Stage::Test, 0);
            lamp_light(&tracer, &points, &viewers, reflections, SAMPLING, stream, 0).unwrap()
        };
        let (one, more) = (light(Reflections::One), light(Reflections::More));
        for (q, (point, &v)) in points.iter().zip(&viewers).enumerate() {
            let truth = albedo(&material, point.normal, v);
            let (mean, error) = (one.mean(q), 1.25 * one.standard_error(q));
            let name = format!("roughness {roughness}, metallic {metallic}, query {q}");
            // Midpoints of a lobe of width alpha = 0.09 by steps of 1 / 512.
            assert_z(
                &name,
                mean,
                error,
                truth,
                1e-3,
                materials.len() * points.len(),
            );
        }
        let (mean, error) = pooled(&more);
        if metallic == 1.0 {
            // The albedo of base colour 0.8 may reach 0.81 or so at grazing angles.
            assert!(mean.x <= 0.9 * 0.9 / 0.1 + 5.0 * error.x, "{mean}");
        }
        assert!(mean.is_finite() && mean.min_element() > 0.0, "{mean}");
    }
}

/// A convex body in a black room that glows with radiance 1 all around reflects its albedo.
#[test]
fn sphere_in_a_constant_field() {
    let a = Vec3::new(0.75, 0.3, 0.0);
    let mut builder = Builder::default();
    let white = builder.material(lambert(a));
    let black = builder.material(lambert(Vec3::ZERO));
    let light = builder.light(Vec3::ONE, true);
    builder.sphere(Vec3::ZERO, 0.5, 12, white, INVALID);
    let sphere = builder.scene.triangles.len() as u32;
    builder.cuboid(Vec3::splat(-2.0), Vec3::splat(1.5), false, black, light);
    // Facets without smooth normals: the body is a polyhedron, and the sum exact.
    builder.scene.normals.fill(Vec3::ZERO);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers) = places(&tracer, 2_000, 1.0);
    let on_sphere: Vec<usize> = (0..points.len())
        .filter(|&i| points[i].triangle < sphere)
        .collect();
    let points: Vec<SurfacePoint> = on_sphere.iter().map(|&i| points[i]).collect();
    let viewers: Vec<Vec3> = on_sphere.iter().map(|&i| viewers[i]).collect();
    assert!(points.len() > 20);
    let light = |reflections| {
        let stream = Stream::new(4, Stage::Test, 0);
        lamp_light(&tracer, &points, &viewers, reflections, SAMPLING, stream, 0).unwrap()
    };
    let (mean, error) = pooled(&light(Reflections::One));
    assert_z("direct", mean, error, a, 0.0, 1);
    assert_eq!(pooled(&light(Reflections::More)).0, Vec3::ZERO);
}

/// Inside a Lambert sphere of radius R and albedo a, light that leaves any place arrives evenly
/// everywhere. Of the flux 4 pi I of a point light, a^2 + a^3 + ... = a^2 / (1 - a) leaves after two
/// or more reflections, spread over 4 pi R^2, as radiance over pi: wherever light and point
/// are, s+ = a^2 / (1 - a) / (pi R^2).
#[test]
fn point_light_in_a_sphere() {
    const N: u32 = 128;
    let radius = 1.5f32;
    let a = Vec3::new(0.5, 0.8, 0.1);
    let mut builder = Builder::default();
    let material = builder.material(lambert(a));
    builder.sphere(Vec3::new(0.2, 0.1, -0.3), radius, N, material, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let (points, viewers) = places(&tracer, 24, -1.0);
    let stream = Stream::new(42, Stage::Test, 0);
    let lights: Vec<Vec3> = (0..points.len() as u64)
        .map(|i| {
            // From the middle to a fiftieth of the radius off the wall.
            let u = stream.units(i, 0, 0);
            let away = Vec3::new(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5).normalize();
            Vec3::new(0.2, 0.1, -0.3) + away * radius * 0.98 * u[3].sqrt()
        })
        .collect();
    let queries = Queries {
        points: &points,
        viewers: &viewers,
        lights: &lights,
    };
    let estimates = indirect(&tracer, queries, 16_384, 64, stream, 0).unwrap();
    let truth = a * a / (Vec3::ONE - a) / (std::f32::consts::PI * radius * radius);
    // The polyhedron's area falls short of the sphere's by about (pi / N)^2 / 4, and where it
    // is lit and seen its facets lie within (pi / N)^2 of the sphere.
    let slack = 2.0 * (std::f32::consts::PI / N as f32).powi(2);
    let (mean, error) = pooled(&estimates);
    assert_z("sphere", mean, error, truth, slack, 1 + points.len());
    for q in 0..points.len() {
        let (mean, error) = (estimates.mean(q), estimates.standard_error(q));
        // 64 replicates: Student's t, whose tail at the limit is a quarter longer.
        assert_z(
            &format!("query {q}"),
            mean,
            1.25 * error,
            truth,
            slack,
            1 + points.len(),
        );
    }
}
