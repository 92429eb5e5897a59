//! Glass, panes and alpha masks against closed forms.

use crate::scenes::{Builder, lambert};
use crate::statistics::assert_z;
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_materials::{Material, Opacity};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, PointLight, Scene};
use rrf_trace::{Estimator, Illumination, Reflections, Sampling, SurfacePoint, Tracer, own_light};
use std::f32::consts::PI;

const SAMPLING: Sampling = Sampling {
    paths: 8_192,
    replicates: 32,
};

/// All light of lamps and `points` at surface points, direct and indirect: mean and standard error.
fn light(tracer: &Tracer, points: &[PointLight], at: &[(SurfacePoint, Vec3)]) -> Vec<(Vec3, Vec3)> {
    let sources = points.iter().map(|&p| LightSource::from(p));
    let set = tracer.light_set(None, sources).unwrap();
    let (places, viewers): (Vec<_>, Vec<_>) = at.iter().copied().unzip();
    let parts = [Reflections::One, Reflections::More].map(|reflections| {
        let illumination = Illumination {
            lights: &set,
            reflections,
            estimator: Estimator::Connected,
        };
        let stream = Stream::new(81, Stage::Test, reflections as u32);
        own_light(tracer, illumination, &places, &viewers, SAMPLING, stream, 0).unwrap()
    });
    let sum = |k| {
        let [a, b] = [&parts[0], &parts[1]].map(|part| (part.mean(k), part.standard_error(k)));
        let squares: Vec3 = a.1 * a.1 + b.1 * b.1;
        (a.0 + b.0, squares.map(f32::sqrt))
    };
    (0..at.len()).map(sum).collect()
}

fn glass(ior: f32, absorption: Vec3) -> Material {
    Material::dielectric("glass", ior, Vec3::ONE, absorption)
}

/// A scene within walls that all shine alike.
fn in_white(add: impl FnOnce(&mut Builder)) -> Scene {
    let mut builder = Builder::default();
    let black = builder.material(lambert(Vec3::ZERO));
    let lamp = builder.light(Vec3::new(1.0, 2.0, 3.0), true);
    builder.cuboid(Vec3::splat(-10.0), Vec3::splat(10.0), true, black, lamp);
    add(&mut builder);
    builder.scene
}

/// Where all radiance is alike, a body that loses none of it cannot be seen.
#[test]
fn lossless_glass_is_invisible() {
    let white = Vec3::new(1.0, 2.0, 3.0);
    let boxes = in_white(|builder| {
        let clear = builder.material(glass(1.5, Vec3::ZERO));
        let dense = builder.material(glass(2.4, Vec3::ZERO));
        builder.cuboid(Vec3::splat(-1.0), Vec3::splat(1.0), false, clear, INVALID);
        builder.cuboid(Vec3::splat(-0.4), Vec3::splat(0.5), false, dense, INVALID);
        let thin = builder.material(Material::thin_dielectric("pane", 1.5, Vec3::ONE));
        builder.quad(
            Vec3::new(-3.0, 2.0, -3.0),
            Vec3::X * 6.0,
            Vec3::Z * 6.0,
            thin,
            INVALID,
        );
    });
    let ball = in_white(|builder| {
        let clear = builder.material(glass(1.5, Vec3::ZERO));
        builder.sphere(Vec3::ZERO, 1.0, 64, clear, INVALID);
    });
    // bent normals of the ball's facets lose the light whose side they do not agree about
    for (name, scene, slack) in [("boxes", &boxes, 0.0), ("ball", &ball, 0.01)] {
        let tracer = Tracer::new(scene).unwrap();
        let stream = Stream::new(82, Stage::Test, 0);
        let mut at = Vec::new();
        for k in 0..20_000 {
            let u = stream.units(k, 0, 0);
            let point = tracer.sample_area([u[0], u[1], u[2]]);
            // in glass radiance is alike too, but as much more as the index squared
            let outside = (0.9..9.0).contains(&point.position.abs().max_element());
            if outside && at.len() < 24 {
                let out = point.normal;
                let v = (out + 0.9 * Vec3::new(u[3] - 0.5, 0.3, 0.5 - u[0])).normalize();
                at.push((point, v));
            }
        }
        assert!(at.len() > 8, "{name}: {} points", at.len());
        for (k, (mean, error)) in light(&tracer, &[], &at).into_iter().enumerate() {
            assert_z(&format!("{name} {k}"), mean, error, white, slack, 48);
        }
    }
}

/// A lamp behind slabs along x, seen along their normals through a window at x = 0.
fn slabs(add: impl FnOnce(&mut Builder)) -> (Vec3, Vec3) {
    let mut builder = Builder::default();
    add(&mut builder);
    let black = builder.material(lambert(Vec3::ZERO));
    let lamp = builder.light(Vec3::ONE, true);
    let corner = Vec3::new(5.0, -500.0, -500.0);
    builder.quad(corner, Vec3::Y * 1000.0, Vec3::Z * 1000.0, black, lamp);
    let tracer = Tracer::new(&builder.scene).unwrap();
    let at = tracer
        .locate(Vec3::new(0.0, 0.1, 0.2), Vec3::NEG_X)
        .unwrap();
    light(&tracer, &[], &[(at, Vec3::NEG_X)])[0]
}

fn slab(builder: &mut Builder, from: f32, to: f32, material: Material) {
    let id = builder.material(material);
    let (a, b) = (Vec3::new(from, -200.0, -200.0), Vec3::new(to, 200.0, 200.0));
    builder.cuboid(a, b, false, id, INVALID);
}

/// (1 - r)² e^-τ / (1 - r² e^-2τ): what passes a slab of optical thickness τ whose faces reflect r.
fn passed(r: f32, thickness: Vec3) -> Vec3 {
    let once = (-thickness).exp();
    once * (1.0 - r) * (1.0 - r) / (Vec3::ONE - once * once * (r * r))
}

#[test]
fn slabs_absorb_and_reflect() {
    let absorption = Vec3::new(0.2, 1.0, 3.0);
    for (ior, r) in [(1.0, 0.0), (1.5, 0.04), (2.0, 1.0 / 9.0)] {
        let (mean, error) = slabs(|b| slab(b, 0.0, 0.7, glass(ior, absorption)));
        let truth = passed(r, absorption * 0.7);
        assert_z(&format!("slab of {ior}"), mean, error, truth, 0.0, 5);
    }
    // where two solids overlap, the one entered last counts, and their borders reflect nothing
    // where the index is the same
    let other = Vec3::new(0.5, 0.1, 0.3);
    let (mean, error) = slabs(|b| {
        slab(b, 0.0, 1.0, glass(1.5, absorption));
        slab(b, 0.5, 1.5, glass(1.5, other));
    });
    let truth = passed(0.04, absorption * 0.5 + other);
    assert_z("overlapping slabs", mean, error, truth, 0.0, 5);
    // water in glass, without a gap and without an overlap of their walls
    let (mean, error) = slabs(|b| {
        slab(b, 0.0, 1.0, glass(1.5, absorption));
        slab(b, 0.3, 0.6, glass(1.5, Vec3::ZERO));
    });
    let truth = passed(0.04, absorption * 0.7);
    assert_z("a slab in a slab", mean, error, truth, 0.0, 5);
}

/// A floor under a quad, lit by a point through it: the light that remains.
fn floor_under(material: Material) -> (Vec3, Vec3, Vec3) {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::splat(0.5)));
    builder.quad(
        Vec3::new(-5.0, 0.0, 5.0),
        Vec3::X * 10.0,
        Vec3::Z * -10.0,
        white,
        INVALID,
    );
    let id = builder.material(material);
    builder.quad(
        Vec3::new(-9.0, 1.0, 9.0),
        Vec3::X * 18.0,
        Vec3::Z * -18.0,
        id,
        INVALID,
    );
    let tracer = Tracer::new(&builder.scene).unwrap();
    let place = tracer.locate(Vec3::ZERO, Vec3::Y).unwrap();
    let lamp = Vec3::new(1.5, 2.0, 0.0);
    let points = [PointLight {
        position: lamp,
        intensity: Vec3::ONE,
    }];
    let set = tracer
        .light_set(None, points.map(LightSource::from))
        .unwrap();
    let illumination = Illumination {
        lights: &set,
        reflections: Reflections::One,
        estimator: Estimator::Connected,
    };
    let stream = Stream::new(83, Stage::Test, 0);
    let found = own_light(
        &tracer,
        illumination,
        &[place],
        &[Vec3::Y],
        SAMPLING,
        stream,
        0,
    );
    let found = found.unwrap();
    let (distance2, cosine) = (lamp.length_squared(), lamp.normalize().y);
    let open = Vec3::splat(0.5 / PI * cosine / distance2);
    (found.mean(0), found.standard_error(0), open)
}

#[test]
fn shadow_rays_pass_panes_and_masks() {
    let tint = Vec3::new(1.0, 0.8, 0.5);
    let (mean, error, open) = floor_under(Material::thin_dielectric("pane", 1.5, tint));
    // Fresnel's equations at an incidence whose cosine is 0.8, in f64
    let (cosine, eta) = (0.8f64, 1.5f64);
    let inside = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).sqrt();
    let s = (cosine - eta * inside) / (cosine + eta * inside);
    let p = (inside - eta * cosine) / (inside + eta * cosine);
    let once = 0.5 * (s * s + p * p);
    let share = (1.0 - 2.0 * once / (1.0 + once)) as f32;
    assert_z("pane", mean, error, open * tint * share, 0.0, 3);
    let veil = |cutoff| Material {
        opacity: Opacity {
            value: 0.3,
            texture: INVALID,
            cutoff,
        },
        ..lambert(Vec3::ONE)
    };
    let (mean, error, open) = floor_under(veil(None));
    assert_z("veil", mean, error, open * 0.7, 0.0, 3);
    let (mean, error, open) = floor_under(veil(Some(0.5)));
    assert_z("hole", mean, error, open, 0.0, 3);
}

/// A veil of opacity a before a lamp shows 1 - a of it and hides a of itself: paths and shadow rays
/// agree with the lamp seen through a pane or a veil from a floor.
#[test]
fn lamps_are_seen_through_veils_once() {
    let veil = Material {
        opacity: Opacity {
            value: 0.4,
            texture: INVALID,
            cutoff: None,
        },
        ..lambert(Vec3::ZERO)
    };
    let total = |material: Option<Material>| {
        let mut builder = Builder::default();
        let white = builder.material(lambert(Vec3::splat(0.5)));
        builder.quad(
            Vec3::new(-5.0, 0.0, 5.0),
            Vec3::X * 10.0,
            Vec3::Z * -10.0,
            white,
            INVALID,
        );
        let black = builder.material(lambert(Vec3::ZERO));
        let lamp = builder.light(Vec3::ONE, true);
        builder.quad(
            Vec3::new(-1.0, 2.0, 1.0),
            Vec3::X * 2.0,
            Vec3::Z * -2.0,
            black,
            lamp,
        );
        if let Some(material) = material {
            let id = builder.material(material);
            builder.quad(
                Vec3::new(-9.0, 1.0, 9.0),
                Vec3::X * 18.0,
                Vec3::Z * -18.0,
                id,
                INVALID,
            );
        }
        let tracer = Tracer::new(&builder.scene).unwrap();
        let place = tracer.locate(Vec3::ZERO, Vec3::Y).unwrap();
        light(&tracer, &[], &[(place, Vec3::Y)])[0]
    };
    let ((open, e), (veiled, f)) = (total(None), total(Some(veil)));
    let error = (e * e * 0.36 + f * f).map(f32::sqrt);
    assert_z("veiled lamp", veiled, error, open * 0.6, 0.0, 1);
}
