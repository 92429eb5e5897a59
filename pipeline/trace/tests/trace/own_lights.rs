//! A scene's own lights against the plain reference, one by one and all at once.

use crate::estimators::{room, views};
use crate::reference::{Plain, Random, mean_of};
use crate::scenes::{Builder, lambert};
use crate::statistics::assert_z;
use glam::{Mat3, Vec3};
use rrf_lights::{
    DistantLight, Environment, EnvironmentMap, Falloff, LightSource, Mapping, PointLight, SpotLight,
};
use rrf_sampling::{Stage, Stream};
use rrf_scene::INVALID;
use rrf_trace::{
    Estimates, Estimator, Illumination, LightSet, Queries, Reflections, Sampling, SurfacePoint,
    Tracer, indirect_with, own_light, sun_light,
};

const SAMPLING: Sampling = Sampling {
    paths: 65_536,
    replicates: 128,
};

const ESTIMATORS: [Estimator; 3] = [
    Estimator::Connected,
    Estimator::NextEvent,
    Estimator::Bidirectional,
];

/// A wide sun and a sky that come in at the room's open front, a spot and a point inside.
fn sources() -> Vec<LightSource> {
    let level = |k: u32| 0.1 + (k * 37 % 11) as f32;
    let texels = (0..128).map(|k| Vec3::new(level(k), 1.0, level(k + 5)) * 0.2);
    let (mapping, frame) = (Mapping::LatLong, Mat3::IDENTITY);
    let sky = EnvironmentMap::new((16, 8), texels.collect(), mapping, frame).unwrap();
    let sun = DistantLight {
        diameter: 25.0,
        ..DistantLight::sun(
            Vec3::new(0.3, 0.5, 1.0).normalize(),
            Vec3::new(4.0, 3.5, 3.0),
        )
    };
    let spot = SpotLight {
        position: Vec3::new(0.5, 1.8, 0.6),
        axis: Vec3::new(-0.3, -1.0, -0.5).normalize(),
        intensity: Vec3::new(3.0, 2.5, 2.0),
        inner: 0.3,
        outer: 0.8,
        falloff: Falloff::Squared,
    };
    let point = PointLight {
        position: Vec3::new(-0.7, 1.5, 0.2),
        intensity: Vec3::new(0.3, 0.5, 0.9),
    };
    let sky = Environment::of_map(sky);
    vec![sky.into(), sun.into(), spot.into(), point.into()]
}

struct Asked {
    points: Vec<SurfacePoint>,
    viewers: Vec<Vec3>,
}

impl Asked {
    fn new(tracer: &Tracer, count: u64) -> Asked {
        let (points, viewers, _) = views(tracer, count);
        Asked { points, viewers }
    }

    fn find_openings(&self, tracer: &Tracer, lights: &mut LightSet) {
        let stream = Stream::new(6, Stage::Test, 0);
        tracer.find_openings(lights, &self.points, &self.viewers, stream);
    }

    fn of(
        &self,
        tracer: &Tracer,
        lights: &LightSet,
        (reflections, estimator): (Reflections, Estimator),
        seed: u64,
    ) -> Estimates {
        let illumination = Illumination {
            lights,
            reflections,
            estimator,
        };
        let stream = Stream::new(seed, Stage::Test, 0);
        let (points, viewers) = (&self.points, &self.viewers);
        own_light(tracer, illumination, points, viewers, SAMPLING, stream, 0).unwrap()
    }
}

fn root(squares: Vec3) -> Vec3 {
    squares.to_array().map(f32::sqrt).into()
}

/// Emitted plus direct plus indirect light is the full light that a plain path finds, of each
/// kind alone and of all together, by either estimator.
#[test]
fn own_light_is_that_of_the_plain_tracer() {
    let (lit, unlit) = (room(true), room(false));
    let mut cases: Vec<(bool, Vec<LightSource>)> =
        sources().into_iter().map(|s| (false, vec![s])).collect();
    cases.push((true, sources()));
    let tests = cases.len() * 3 * 5;
    for (k, (lamp, sources)) in cases.into_iter().enumerate() {
        let scene = if lamp { &lit } else { &unlit };
        let tracer = Tracer::new(scene).unwrap();
        let asked = Asked::new(&tracer, 5);
        let mut set = tracer.light_set(None, sources.clone()).unwrap();
        // connected paths aim there too, next-event estimation does not
        asked.find_openings(&tracer, &mut set);
        let plain = Plain { scene };
        let truth = |q: usize| {
            let mut random = Random::new(5_000 + 10 * k as u64 + q as u64);
            let point = &asked.points[q];
            let (position, v) = (point.position.as_dvec3(), asked.viewers[q].as_dvec3());
            let start = plain.place(point.triangle as usize, position, v);
            mean_of(60_000, || plain.own(start, &sources, &mut random))
        };
        let truth: Vec<(Vec3, Vec3)> = (0..asked.points.len()).map(truth).collect();
        let one = (Reflections::One, Estimator::Connected);
        let one = asked.of(&tracer, &set, one, 10 + k as u64);
        for estimator in ESTIMATORS {
            let more = (Reflections::More, estimator);
            let more = asked.of(&tracer, &set, more, 20 + k as u64);
            for (q, &(truth, error)) in truth.iter().enumerate() {
                let emitted = tracer.emission_of(&set, &asked.points[q], asked.viewers[q]);
                let (e1, e2) = (one.standard_error(q), more.standard_error(q));
                let both = root(e1 * e1 + e2 * e2 + error * error);
                let name = format!("case {k}, {estimator:?}, query {q}");
                let mean = emitted + one.mean(q) + more.mean(q);
                assert_z(&name, mean, both, truth, 0.0, tests);
            }
        }
    }
}

/// All lights at once are the sum of them one by one.
#[test]
fn lights_add_up() {
    let scene = room(true);
    let tracer = Tracer::new(&scene).unwrap();
    let asked = Asked::new(&tracer, 6);
    let all = tracer.light_set(None, sources()).unwrap();
    let dark = [Vec3::ZERO];
    let alone = sources()
        .into_iter()
        .map(|source| tracer.light_set(Some(&dark), [source]).unwrap());
    let lamp = tracer.light_set(None, []).unwrap();
    let alone: Vec<LightSet> = alone.chain([lamp]).collect();
    for reflections in [Reflections::One, Reflections::More] {
        let which = (reflections, Estimator::Connected);
        let together = asked.of(&tracer, &all, which, 1);
        let parts: Vec<Estimates> = (2..)
            .zip(&alone)
            .map(|(seed, set)| asked.of(&tracer, set, which, seed))
            .collect();
        for q in 0..asked.points.len() {
            let sum: Vec3 = parts.iter().map(|p| p.mean(q)).sum();
            let squares: Vec3 = parts.iter().map(|p| p.standard_error(q).powf(2.0)).sum();
            let error = root(squares + together.standard_error(q).powf(2.0));
            let name = format!("{reflections:?}, query {q}");
            assert_z(&name, together.mean(q), error, sum, 0.0, 12);
        }
    }
}

/// A light that is dimmed to nothing is a light that is left out, and a lamp that is dimmed in
/// one colour sends as much less of it: by bits.
#[test]
fn dimmed_lights() {
    let scene = room(true);
    let tracer = Tracer::new(&scene).unwrap();
    let asked = Asked::new(&tracer, 3);
    let which = (Reflections::More, Estimator::Connected);
    let off = |k: usize| {
        let sources = sources().into_iter().enumerate();
        let dimmed = sources.map(|(i, s)| if i == k { s.dimmed(Vec3::ZERO) } else { s });
        tracer.light_set(None, dimmed).unwrap()
    };
    let without = |k: usize| {
        let sources = sources().into_iter().enumerate();
        let others = sources.filter(|&(i, _)| i != k).map(|(_, s)| s);
        tracer.light_set(None, others).unwrap()
    };
    for k in 0..sources().len() {
        let dimmed = asked.of(&tracer, &off(k), which, 3);
        assert_eq!(dimmed, asked.of(&tracer, &without(k), which, 3));
    }
    let lamp = |dim: Vec3| {
        let set = tracer.light_set(Some(&[dim]), []).unwrap();
        asked.of(&tracer, &set, which, 4)
    };
    assert!(lamp(Vec3::ZERO).values.iter().all(|v| *v == Vec3::ZERO));
    let (full, half) = (lamp(Vec3::ONE), lamp(Vec3::splat(0.5)));
    for (full, half) in full.values.iter().zip(&half.values) {
        assert_eq!(*full * 0.5, *half);
    }
}

/// A point of a set is the point of a query, by other numbers; a sun of a set is the sun of a
/// query, by the same.
#[test]
fn sets_agree_with_queries() {
    let scene = room(false);
    let tracer = Tracer::new(&scene).unwrap();
    let asked = Asked::new(&tracer, 6);
    let position = Vec3::new(0.4, 1.7, 0.1);
    let intensity = Vec3::new(2.0, 1.0, 0.5);
    let point = PointLight {
        position,
        intensity,
    };
    let stream = Stream::new(9, Stage::Test, 0);
    let ask = |light| Queries {
        points: &asked.points,
        viewers: &asked.viewers,
        lights: light,
    };
    let places = vec![position; asked.points.len()];
    for estimator in ESTIMATORS {
        let set = tracer.light_set(None, [point.into()]).unwrap();
        let own = asked.of(&tracer, &set, (Reflections::More, estimator), 8);
        let row = indirect_with(&tracer, ask(&places), SAMPLING, estimator, stream, 0).unwrap();
        for q in 0..asked.points.len() {
            let (e1, e2) = (own.standard_error(q), intensity * row.standard_error(q));
            let (name, error) = (format!("{estimator:?}, query {q}"), root(e1 * e1 + e2 * e2));
            assert_z(&name, own.mean(q), error, intensity * row.mean(q), 0.0, 18);
        }
    }
    let toward = Vec3::new(0.1, 0.4, 0.9).normalize();
    let sun = DistantLight::sun(toward, Vec3::ONE);
    let set = tracer.light_set(None, [sun.into()]).unwrap();
    let which = (Reflections::More, Estimator::Connected);
    let suns = vec![toward; asked.points.len()];
    let how = (Estimator::Connected, SAMPLING);
    let row = sun_light(&tracer, ask(&suns), how, stream, 0).unwrap();
    assert_eq!(asked.of(&tracer, &set, which, 9), row);
}

#[test]
fn threads_do_not_matter() {
    let scene = room(true);
    let tracer = Tracer::new(&scene).unwrap();
    let asked = Asked::new(&tracer, 8);
    let set = tracer.light_set(None, sources()).unwrap();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let which = (Reflections::More, Estimator::Connected);
        pool.unwrap().install(|| asked.of(&tracer, &set, which, 5))
    };
    assert_eq!(run(1), run(2));
}

/// A sky through a window of 1.3 % of a room's walls: who aims at it has the same means and a smaller
/// relative variance of direct light than the sky's own sampler; an F of 1.5 of five points' variances, of 127
/// degrees of freedom each, is beyond 1e-4.
#[test]
fn a_window_is_found() {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::splat(0.6)));
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    for (corner, a, b) in [
        (Vec3::ZERO, z, x),
        (y, x, z),
        (Vec3::ZERO, x, y),
        (Vec3::ZERO, y, z),
        (x, z, y),
        // about a hole of 0.4 x 0.8
        (z, y, x * 0.3),
        (z + x * 0.5, y, x * 0.5),
        (z + x * 0.3, y * 0.4, x * 0.2),
        (z + x * 0.3 + y * 0.8, y * 0.2, x * 0.2),
    ] {
        builder.quad(corner, a, b, white, INVALID);
    }
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let triangles = [0, 3, 5, 7, 9];
    let points = triangles.map(|triangle| tracer.point(triangle, [0.3, 0.4]));
    let middle = Vec3::ONE;
    let asked = Asked {
        points: points.to_vec(),
        viewers: points.map(|p| (middle - p.position).normalize()).to_vec(),
    };
    let sky = Environment::constant(Vec3::ONE);
    let mut set = tracer.light_set(None, [sky.into()]).unwrap();
    let by_map = [Reflections::One, Reflections::More]
        .map(|part| asked.of(&tracer, &set, (part, Estimator::Connected), 1));
    asked.find_openings(&tracer, &mut set);
    let aimed = [Reflections::One, Reflections::More]
        .map(|part| asked.of(&tracer, &set, (part, Estimator::Connected), 2));
    let mut squares = [0.0f32; 2];
    for q in 0..asked.points.len() {
        for (part, (a, b)) in by_map.iter().zip(&aimed).enumerate() {
            let (ea, eb) = (a.standard_error(q), b.standard_error(q));
            let name = format!("part {part}, query {q}");
            assert_z(
                &name,
                b.mean(q),
                root(ea * ea + eb * eb),
                a.mean(q),
                0.0,
                30,
            );
        }
        let [a, b] = [&by_map[0], &aimed[0]].map(|found| {
            let relative = found.standard_error(q) / found.mean(q);
            relative.x * relative.x
        });
        squares[0] += a;
        squares[1] += b;
    }
    assert!(squares[0] > 1.5 * squares[1], "{squares:?}");
}
