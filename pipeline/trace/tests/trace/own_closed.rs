//! Sky, sun, spots and profiles against closed forms.

use crate::scenes::{Builder, lambert};
use crate::statistics::assert_z;
use glam::{Mat3, Quat, Vec3};
use rrf_lights::{
    DistantLight, Environment, EnvironmentMap, Falloff, GoniometricLight, IesProfile, LightSource,
    Mapping, Photometry, Profile, SpotLight,
};
use rrf_materials::Material;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{
    Estimates, Estimator, Illumination, Reflections, Sampling, SurfacePoint, Tracer, own_light,
};
use std::f32::consts::PI;

const SAMPLING: Sampling = Sampling {
    paths: 16_384,
    replicates: 64,
};

/// Light of sources at points, by one reflection or by more.
fn light(
    tracer: &Tracer,
    sources: &[LightSource],
    (points, viewers): (&[SurfacePoint], &[Vec3]),
    reflections: Reflections,
) -> Estimates {
    let set = tracer.light_set(None, sources.iter().cloned()).unwrap();
    let illumination = Illumination {
        lights: &set,
        reflections,
        estimator: Estimator::Connected,
    };
    let stream = Stream::new(61, Stage::Test, 0);
    own_light(tracer, illumination, points, viewers, SAMPLING, stream, 0).unwrap()
}

/// A floor of albedo `a` that is turned about x, seen from where its normal points to.
fn plane(a: Vec3, tilt: f32) -> (Scene, Vec3) {
    let turn = Quat::from_rotation_x(tilt);
    let mut builder = Builder::default();
    let floor = builder.material(lambert(a));
    let [x, z] = [Vec3::X, Vec3::NEG_Z].map(|axis| turn * axis * 20.0);
    builder.quad(-0.5 * (x + z), x, z, floor, INVALID);
    (builder.scene, turn * Vec3::Y)
}

/// Direct light at points of a plane, each against its truth; no light is reflected twice.
fn assert_plane(
    name: &str,
    (scene, normal): &(Scene, Vec3),
    source: impl Into<LightSource>,
    places: &[Vec3],
    (truth, slack): (impl Fn(Vec3) -> Vec3, f32),
) {
    let tracer = Tracer::new(scene).unwrap();
    let located = places.iter().map(|&p| tracer.locate(p, *normal).unwrap());
    let points: Vec<SurfacePoint> = located.collect();
    let viewer = (*normal + 0.3 * Vec3::X).normalize();
    let viewers = vec![viewer; points.len()];
    let sources = [source.into()];
    let asked = (points.as_slice(), viewers.as_slice());
    let found = light(&tracer, &sources, asked, Reflections::One);
    for (q, &place) in places.iter().enumerate() {
        let (mean, error) = (found.mean(q), found.standard_error(q));
        let name = format!("{name} at {place}");
        assert_z(&name, mean, 1.25 * error, truth(place), slack, 20);
    }
    let more = light(&tracer, &sources, asked, Reflections::More);
    assert!(more.values.iter().all(|v| *v == Vec3::ZERO));
}

/// Half of a constant sky lies above a plane: a L.
#[test]
fn plane_under_a_constant_sky() {
    let (a, radiance) = (Vec3::new(0.8, 0.5, 0.1), Vec3::new(1.0, 3.0, 0.2));
    let sky = Environment::constant(radiance);
    assert_plane(
        "sky",
        &plane(a, 0.7),
        sky,
        &[Vec3::ZERO],
        (|_| a * radiance, 1e-5),
    );
}

/// A map's irradiance on a plane is its integral with the cosine, by texels of a picture that is
/// eight times as fine as the bilinear one: 1e-3.
#[test]
fn plane_under_a_map() {
    let a = Vec3::new(0.9, 0.6, 0.3);
    let (width, height) = (16, 8);
    let level = |k: u32| match (k % width, k / width) {
        (11, 2) => 90.0,
        (x, y) => ((x * 7 + y * 3) % 5) as f32,
    };
    let texels = (0..width * height).map(|k| Vec3::new(level(k), 1.0, 0.1 * level(k)));
    let map = EnvironmentMap::new(
        (width, height),
        texels.collect(),
        Mapping::LatLong,
        Mat3::IDENTITY,
    );
    let map = map.unwrap();
    let (scene, normal) = plane(a, 0.4);
    let mut irradiance = glam::DVec3::ZERO;
    let (columns, rows) = (2048, 1024);
    for y in 0..rows {
        let theta = std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(rows);
        for x in 0..columns {
            let phi = std::f64::consts::TAU * (f64::from(x) + 0.5) / f64::from(columns);
            let (s, c) = theta.sin_cos();
            let toward = glam::DVec3::new(s * phi.sin(), c, -s * phi.cos());
            let cosine = toward.dot(normal.as_dvec3()).max(0.0);
            irradiance += map.radiance(toward.as_vec3()).as_dvec3() * (s * cosine);
        }
    }
    let cell = 2.0 * std::f64::consts::PI.powi(2) / f64::from(columns * rows);
    let truth = a * (irradiance * cell).as_vec3() / PI;
    let (sky, place) = (Environment::of_map(map), [Vec3::ZERO]);
    let tracer = Tracer::new(&scene).unwrap();
    let point = tracer.locate(place[0], normal).unwrap();
    let found = light(
        &tracer,
        &[sky.into()],
        (&[point], &[normal]),
        Reflections::One,
    );
    let (mean, error) = (found.mean(0), found.standard_error(0));
    assert_z("map", mean, 1.25 * error, truth, 1e-4, 1);
}

/// A disk that a plane sees all of: a E cos θ / π, exactly, and by parallel light too.
#[test]
fn sun_on_a_tilted_plane() {
    let (a, irradiance) = (Vec3::new(0.8, 0.5, 0.1), Vec3::new(4.0, 3.7, 3.3));
    let toward = Vec3::new(0.3, 0.8, 0.4).normalize();
    for tilt in [0.0f32, 0.6, -0.8] {
        let plane = plane(a, tilt);
        let truth = a * irradiance * (plane.1.dot(toward) / PI);
        for diameter in [0.0, rrf_lights::SUN_DIAMETER, 20.0] {
            let sun = DistantLight {
                diameter,
                ..DistantLight::sun(toward, irradiance)
            };
            let name = format!("tilt {tilt}, diameter {diameter}");
            assert_plane(&name, &plane, sun, &[Vec3::ZERO], (|_| truth, 1e-5));
        }
    }
    let below = DistantLight::sun(-toward, irradiance);
    assert_plane(
        "below",
        &plane(a, 0.0),
        below,
        &[Vec3::ZERO],
        (|_| Vec3::ZERO, 0.0),
    );
}

/// Across the cone of a spot that hangs at height h: a I(angle) cos³ / (π h²).
#[test]
fn spot_across_its_cone() {
    let (a, intensity, h) = (Vec3::new(0.8, 0.5, 0.1), Vec3::new(3.0, 2.0, 1.0), 1.5f32);
    let (inner, outer) = (0.35f32, 0.7f32);
    for falloff in [Falloff::Smoothstep, Falloff::Quartic, Falloff::Squared] {
        let spot = SpotLight {
            position: Vec3::Y * h,
            axis: Vec3::NEG_Y,
            intensity,
            inner,
            outer,
            falloff,
        };
        let places: Vec<Vec3> = (0..8)
            .map(|k| Vec3::new(h * (0.1 * k as f32 + 0.05).tan(), 0.0, 0.0))
            .collect();
        // In f64: the cosines' difference loses two digits, at the last place before the rim a
        // third, and its fourth power errs by four times as much: 1e-4.
        let [inner, outer, h] = [inner, outer, h].map(f64::from);
        let truth = |place: Vec3| {
            let cosine = h / f64::from(place.x).hypot(h);
            let t = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
            let share = match falloff {
                Falloff::Smoothstep => t * t * (3.0 - 2.0 * t),
                Falloff::Quartic => t.powi(4),
                Falloff::Squared => t * t,
            };
            let factor = share * cosine.powi(3) / (std::f64::consts::PI * h * h);
            a * intensity * factor as f32
        };
        let name = format!("{falloff:?}");
        assert_plane(&name, &plane(a, 0.0), spot, &places, (truth, 1e-4));
    }
}

/// A lamp maker's table at its own angles: a I(angle) cos³ / (π h²).
#[test]
fn profile_at_its_own_angles() {
    let (a, h) = (Vec3::new(0.8, 0.5, 0.1), 2.0f32);
    let angles = vec![0.0, 15.0, 30.0, 50.0, 70.0, 90.0];
    let candela = vec![900.0, 1000.0, 700.0, 250.0, 40.0, 0.0];
    let table = IesProfile::new(Photometry::C, angles.clone(), vec![0.0], candela.clone());
    // the table's +z is aimed down
    let aim = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    let per_lumen = Vec3::splat(1.0 / 683.0);
    let lamp = GoniometricLight {
        position: Vec3::Y * h,
        intensity: per_lumen,
        profile: Profile::Ies(table.unwrap(), aim),
    };
    let at = |angle: f32| Vec3::new(h * angle.to_radians().tan(), 0.0, 0.0);
    let places: Vec<Vec3> = angles[..5].iter().map(|&angle| at(angle)).collect();
    let truth = |place: Vec3| {
        let k = places.iter().position(|&p| p == place).unwrap();
        let cosine = angles[k].to_radians().cos();
        a * per_lumen * (candela[k] * cosine.powi(3) / (PI * h * h))
    };
    assert_plane("profile", &plane(a, 0.0), lamp, &places, (truth, 1e-5));
}

/// Under a constant sky everything that takes nothing sends on what it gets: a box of albedo 1
/// that is open above, whatever its walls are, looks like the sky itself.
#[test]
fn white_furnace_under_a_constant_sky() {
    let radiance = Vec3::new(2.0, 1.0, 0.5);
    let mut builder = Builder::default();
    let white = builder.material(Material::lambert("white", Vec3::ONE));
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 1.5, Vec3::Z * 2.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    builder.quad(corner, z, x, white, INVALID);
    builder.quad(corner, x, y, white, INVALID);
    builder.quad(corner + z, y, x, white, INVALID);
    builder.quad(corner, y, z, white, INVALID);
    builder.quad(corner + x, z, y, white, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let stream = Stream::new(62, Stage::Test, 0);
    let (mut points, mut viewers) = (Vec::new(), Vec::new());
    for i in 0..24 {
        let u = stream.units(i, 0, 0);
        let point = tracer.sample_area([u[0], u[1], u[2]]);
        points.push(point);
        viewers.push(point.normal);
    }
    let sky = [Environment::constant(radiance).into()];
    let asked = (points.as_slice(), viewers.as_slice());
    let one = light(&tracer, &sky, asked, Reflections::One);
    let more = light(&tracer, &sky, asked, Reflections::More);
    for q in 0..points.len() {
        let (e1, e2) = (one.standard_error(q), more.standard_error(q));
        let error = Vec3::from((e1 * e1 + e2 * e2).to_array().map(f32::sqrt));
        let name = format!("query {q}");
        let mean = one.mean(q) + more.mean(q);
        assert_z(&name, mean, 1.25 * error, radiance, 1e-5, points.len());
    }
}
