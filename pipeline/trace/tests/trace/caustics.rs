//! A polished ball and a flat metal that throw light of every kind onto a floor: paths from both ends
//! against plain next-event estimation, which knows of neither.

use crate::scenes::{Builder, lambert, principled};
use crate::statistics::assert_z;
use glam::Vec3;
use rrf_lights::{DistantLight, Environment, Falloff, LightSource, PointLight, SpotLight};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Estimator, Illumination, Reflections, Sampling, SurfacePoint, Tracer, own_light};

/// A floor, a flat metal behind it, a ball of metal over it, a roof with a hole, and a lamp of two
/// sides under the roof. Narrow enough to count as mirrors, wide enough for plain paths.
fn scene() -> Scene {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::new(0.8, 0.7, 0.6)));
    let metal = builder.material(principled(Vec3::new(0.9, 0.7, 0.5), 0.5, 1.0, 0.5));
    let gloss = builder.material(principled(Vec3::new(0.3, 0.5, 0.4), 0.5, 0.2, 0.5));
    let lamp = builder.light(Vec3::new(9.0, 8.0, 7.0), true);
    let (x, y, z) = (Vec3::X * 3.0, Vec3::Y * 2.0, Vec3::Z * 3.0);
    let corner = Vec3::new(-1.5, 0.0, -1.5);
    builder.quad(corner, z, x, gloss, INVALID);
    builder.quad(corner, x, y, metal, INVALID);
    builder.quad(corner + y, x * 0.6, z, white, INVALID);
    let lamp_corner = Vec3::new(-0.9, 1.6, 0.3);
    builder.quad(lamp_corner, Vec3::X * 0.3, Vec3::Z * 0.2, white, lamp);
    builder.sphere(Vec3::new(0.1, 0.5, 0.0), 0.4, 24, metal, INVALID);
    builder.scene
}

fn sources() -> Vec<LightSource> {
    let sun = DistantLight {
        diameter: 12.0,
        ..DistantLight::sun(Vec3::new(0.7, 0.6, 0.5).normalize(), Vec3::splat(3.0))
    };
    let spot = SpotLight {
        position: Vec3::new(0.6, 1.6, 0.9),
        axis: Vec3::new(-0.4, -0.8, -0.6).normalize(),
        intensity: Vec3::new(2.0, 1.5, 1.0),
        inner: 0.3,
        outer: 0.7,
        falloff: Falloff::Squared,
    };
    let point = PointLight {
        position: Vec3::new(-0.5, 1.2, 0.8),
        intensity: Vec3::new(0.4, 0.6, 0.9),
    };
    let sky = Environment::constant(Vec3::new(0.3, 0.5, 0.8));
    vec![sun.into(), spot.into(), point.into(), sky.into()]
}

#[test]
fn paths_from_both_ends_find_what_plain_paths_find() {
    let scene = scene();
    let tracer = Tracer::new(&scene).unwrap();
    assert!(tracer.has_mirrors());
    let places = [
        (Vec3::new(0.9, 0.0, 0.5), Vec3::Y),
        (Vec3::new(-0.5, 0.0, -0.3), Vec3::Y),
        (Vec3::new(-0.8, 2.0, 0.1), Vec3::NEG_Y),
    ];
    let points = places.map(|(p, n)| tracer.locate(p, n).unwrap());
    let viewers = places.map(|(_, n)| (n + Vec3::new(0.3, 0.0, 0.4)).normalize());
    let dark = [Vec3::ZERO];
    let alone = sources().into_iter().map(|source| {
        let set = tracer.light_set(Some(&dark), [source.clone()]).unwrap();
        (source.kind().to_string(), set)
    });
    let lamp = ("lamp".to_string(), tracer.light_set(None, []).unwrap());
    let all = (
        "all".to_string(),
        tracer.light_set(None, sources()).unwrap(),
    );
    let cases: Vec<_> = alone.chain([lamp, all]).collect();
    let tests = cases.len() * points.len();
    for (k, (name, lights)) in (0u64..).zip(&cases) {
        let run = |estimator, paths: u32, seed: u64| {
            let illumination = Illumination {
                lights,
                reflections: Reflections::More,
                estimator,
            };
            let sampling = Sampling {
                paths,
                replicates: 128,
            };
            let stream = Stream::new(seed, Stage::Test, 0);
            let points: &[SurfacePoint] = &points;
            own_light(&tracer, illumination, points, &viewers, sampling, stream, 0).unwrap()
        };
        let joined = run(Estimator::Bidirectional, 1 << 16, 100 + k);
        let plain = run(Estimator::NextEvent, 1 << 20, 200 + k);
        for q in 0..points.len() {
            let (a, b) = (joined.standard_error(q), plain.standard_error(q));
            // Student's t of 128 replicates has a tail a tenth longer at the limit
            let error = 1.1 * Vec3::from((a * a + b * b).to_array().map(f32::sqrt));
            let name = format!("{name}, place {q}");
            assert_z(&name, joined.mean(q), error, plain.mean(q), 0.0, tests);
        }
    }
}
