//! Sampled direct light against closed forms, exact shadow rays and the path tracer.

#![allow(clippy::unwrap_used)]

mod dark;
mod support;
mod window;

use glam::Vec3;
use rrf_lights::{DistantLight, Environment, Falloff, LightSource, OwnLight, SpotLight};
use rrf_render::{
    Lights, OFF_CENTRE, Part, PathOptions, RenderOptions, ShadowRays, render, trace_frame,
};
use rrf_scene::{INVALID, PointLight, Scene};
use rrf_trace::Tracer;
use std::f64::consts::TAU;
use support::*;

/// Form factor from a small patch to a parallel rectangle a by b at height h whose corner is
/// straight above the patch, odd in a and in b (Howell, configuration factors, B-3).
fn corner_form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / TAU
}

#[test]
fn rectangle_over_a_floor() {
    // y by x: the lamp shines down
    let (x0, y0, x1, y1, h) = (-0.8f64, 0.2f64, 0.9f64, 1.0f64, 1.5f64);
    let at = |x: f64, y: f64| Vec3::new(x as f32, y as f32, h as f32);
    let lamp = [
        at(x0, y0),
        Vec3::Y * (y1 - y0) as f32,
        Vec3::X * (x1 - x0) as f32,
    ];
    let radiance = 3.0;
    let lit = scene(&[floor()], &[lamp], radiance);
    let tracer = Tracer::new(&lit).unwrap();
    let view = view();
    let mut truth = Vec::new();
    for pixel in 0..SIZE[0] * SIZE[1] {
        let x = (pixel % SIZE[0]) as f32 + 0.5 + OFF_CENTRE[0];
        let y = (pixel / SIZE[0]) as f32 + 0.5 + OFF_CENTRE[1];
        let direction = view.direction(x, y);
        let (mut rays, mut hits) = (rrf_trace::Rays::default(), rrf_trace::Hits::default());
        rays.push(view.eye, direction, f32::INFINITY);
        tracer.closest(&rays, &mut hits);
        if hits.triangle[0] == INVALID {
            truth.push((0.0, 0.0));
            continue;
        }
        let p = (view.eye + hits.t[0] * direction).as_dvec3();
        assert!(p.z < 1e-3, "the lamp is out of the picture");
        let factor = |x: f64, y: f64| corner_form_factor(x - p.x, y - p.y, h);
        let factor = factor(x1, y1) - factor(x0, y1) - factor(x1, y0) + factor(x0, y0);
        let value = f64::from(ALBEDO * radiance) * factor;
        truth.push((value, 0.0));
    }
    assert!(truth.iter().filter(|t| t.0 > 0.05).count() > 100);
    let lights = Lights {
        points: Vec::new(),
        area: true,
        ..Lights::default()
    };
    for adaptive in [false, true] {
        let frames = frames(&lit, &lights, 10, adaptive);
        assert_unbiased(&format!("adaptive {adaptive}"), &frames, &truth);
    }
}

/// A hundred point lights of very different strength, boards between them and the floor.
fn hundred() -> (Scene, Lights) {
    let board = |x: f32| [Vec3::new(x, -1.0, 0.3), Vec3::X * 0.5, Vec3::Y * 2.0];
    let scene = scene(&[floor(), board(-1.2), board(0.3)], &[], 0.0);
    let points = (0..100u32).map(|k| {
        let turn = |step: f64| (f64::from(k) * step).fract() as f32;
        PointLight {
            position: Vec3::new(
                4.0 * turn(0.754_877_67) - 2.0,
                4.0 * turn(0.569_840_29) - 2.0,
                0.4 + turn(0.381_966_01),
            ),
            intensity: Vec3::splat(0.05 * 20f32.powf(turn(0.618_033_99))),
        }
    });
    let lights = Lights {
        points: points.collect(),
        area: false,
        ..Lights::default()
    };
    (scene, lights)
}

#[test]
fn a_hundred_lights_against_exact_shadow_rays() {
    let (scene, lights) = hundred();
    let tracer = Tracer::new(&scene).unwrap();
    let options = RenderOptions {
        part: Part::Direct,
        ..RenderOptions::default()
    };
    let exact = render(&tracer, &field(), &view(), &lights, &options).unwrap();
    let truth: Vec<(f64, f64)> = exact.full.iter().map(|p| (f64::from(p.x), 0.0)).collect();
    for rays in [16, 48] {
        let uniform = frames(&scene, &lights, rays, false);
        let adaptive = frames(&scene, &lights, rays, true);
        assert_unbiased("uniform", &uniform, &truth);
        assert_unbiased("adaptive", &adaptive, &truth);
        assert_smaller_errors(&adaptive, &uniform, &truth);
    }
}

/// Whole frames' mean squared errors against an exact truth are smaller on average: Welch's t of
/// two times 64 independent frames. With at least 63 degrees of freedom, chance exceeds 4.0 less
/// than once in 10,000 times.
fn assert_smaller_errors(some: &[Vec<f64>], others: &[Vec<f64>], truth: &[(f64, f64)]) {
    let of = |frames: &[Vec<f64>]| {
        let error = |frame: &Vec<f64>| {
            let squares = frame.iter().zip(truth).map(|(x, m)| (x - m.0).powi(2));
            vec![squares.sum::<f64>()]
        };
        moments(&frames.iter().map(error).collect::<Vec<_>>())[0]
    };
    let ((a, a_se2), (b, b_se2)) = (of(some), of(others));
    let t = (b - a) / (a_se2 + b_se2).sqrt();
    assert!(t > 4.0, "{a} against {b}, t {t}");
}

#[test]
fn a_large_hidden_lamp_against_the_path_tracer() {
    let lamp = [Vec3::new(-2.0, -2.0, 1.5), Vec3::Y * 4.0, Vec3::X * 4.0];
    // leaves a slit of the lamp to be seen from the floor
    let board = [Vec3::new(-2.5, -2.5, 1.2), Vec3::X * 3.8, Vec3::Y * 5.0];
    let lit = scene(&[floor(), board], &[lamp], 2.0);
    let lights = Lights {
        points: Vec::new(),
        area: true,
        ..Lights::default()
    };
    let tracer = Tracer::new(&lit).unwrap();
    let traced: Vec<Vec<f64>> = (1..=SEEDS)
        .map(|seed| {
            let options = PathOptions {
                spp: 16,
                aa: 1,
                seed,
            };
            let frame = trace_frame(&tracer, &view(), &lights, options, &|_| {}).unwrap();
            frame
                .direct
                .unwrap()
                .iter()
                .map(|p| f64::from(p.x))
                .collect()
        })
        .collect();
    let truth = moments(&traced);
    for adaptive in [false, true] {
        let frames = frames(&lit, &lights, 16, adaptive);
        assert_unbiased(&format!("adaptive {adaptive}"), &frames, &truth);
    }
}

/// Thirty lamps of every strength under a ceiling of boards, a spot, a sky and a sun.
fn many_lamps() -> (Scene, Lights) {
    let board = |x: f32| [Vec3::new(x, -1.5, 0.5), Vec3::X * 0.4, Vec3::Y * 3.0];
    let lamp = |k: u32| {
        let turn = |step: f64| (f64::from(k) * step).fract() as f32;
        let (x, y) = (
            4.0 * turn(0.754_877_67) - 2.0,
            4.0 * turn(0.569_840_29) - 2.0,
        );
        let side = 0.02 + 0.2 * turn(0.381_966_01);
        // y by x: the lamp shines down
        let corner = Vec3::new(x, y, 0.6 + 0.3 * turn(0.618_033_99));
        [corner, Vec3::Y * side, Vec3::X * side]
    };
    let lamps: Vec<[Vec3; 3]> = (0..30).map(lamp).collect();
    let scene = scene(&[floor(), board(-1.4), board(0.2)], &lamps, 4.0);
    let spot = SpotLight {
        position: Vec3::new(0.5, -0.5, 0.8),
        axis: Vec3::NEG_Z,
        intensity: Vec3::splat(0.2),
        inner: 0.3,
        outer: 0.6,
        falloff: Falloff::Squared,
    };
    let sun = DistantLight {
        diameter: 8.0,
        ..DistantLight::sun(Vec3::new(0.5, -0.4, 0.7).normalize(), Vec3::splat(0.7))
    };
    let sky = Environment::constant(Vec3::splat(0.1));
    let sources: [(&str, LightSource); 3] = [
        ("spot", spot.into()),
        ("sun", sun.into()),
        ("sky", sky.into()),
    ];
    let lights = Lights {
        area: true,
        sources: sources.map(|(name, source)| own(name, source)).to_vec(),
        ..Lights::default()
    };
    (scene, lights)
}

fn own(name: &str, source: LightSource) -> OwnLight {
    OwnLight {
        name: name.into(),
        source,
    }
}

/// A number of rays that follows what the first ones found biases nothing, and the noise comes
/// down to the bound: its root mean square over pixels that have rays to spare is at most a
/// tenth above it.
#[test]
fn many_lamps_down_to_a_bound() {
    let (scene, lights) = many_lamps();
    let truth = traced(&scene, &lights);
    for bound in [0.02f32, 0.006] {
        let rays = ShadowRays {
            count: 2048,
            noise: Some(bound),
            ..ShadowRays::default()
        };
        let frames = frames_by(&scene, &lights, rays);
        assert_unbiased(&format!("bound {bound}"), &frames, &truth);
        let found = moments(&frames);
        let variance = found.iter().map(|(_, se2)| se2 * SEEDS as f64);
        let noise = (variance.sum::<f64>() / found.len() as f64).sqrt();
        assert!(noise < 1.1 * f64::from(bound), "{noise} over {bound}");
    }
}

/// The sampled light of one point alone is the exact one, whatever the number of rays.
#[test]
fn one_point_light_has_no_noise() {
    let scene = scene(&[floor()], &[], 0.0);
    let lights = Lights {
        points: vec![PointLight {
            position: Vec3::Z,
            intensity: Vec3::ONE,
        }],
        area: false,
        ..Lights::default()
    };
    let options = RenderOptions {
        part: Part::Direct,
        ..RenderOptions::default()
    };
    let tracer = Tracer::new(&scene).unwrap();
    let exact = render(&tracer, &field(), &view(), &lights, &options).unwrap();
    let frames = frames(&scene, &lights, 5, true);
    for (pixel, (mean, _)) in exact.full.iter().zip(moments(&frames)) {
        assert!(
            (f64::from(pixel.x) - mean).abs() <= 1e-5 * mean,
            "{pixel} {mean}"
        );
    }
}
