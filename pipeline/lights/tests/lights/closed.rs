//! Closed forms: what planes and spheres get from each kind of light.

use crate::statistics::{Random, mean_se};
use glam::{Mat3, Vec3};
use rrf_lights::{
    DistantLight, Environment, EnvironmentMap, Falloff, LightKind, LightSource, Mapping,
    PointLight, SpotLight, azimuth_elevation, sky_direction,
};
use std::f64::consts::PI;

/// Irradiance (red) on a plane at the origin, and its standard error.
fn irradiance(light: &impl LightKind, normal: Vec3) -> (f64, f64) {
    let mut random = Random(5);
    mean_se((0..200_000).map(|_| {
        let arrival = light.sample(Vec3::ZERO, random.pair());
        arrival.map_or(0.0, |a| {
            f64::from(a.irradiance.x * a.toward.dot(normal).max(0.0))
        })
    }))
}

/// Five standard errors and rounding: p 6e-7 a test.
fn agrees(name: &str, (mean, se): (f64, f64), want: f64) {
    assert!(
        (mean - want).abs() <= 5.0 * se + 1e-5 * want,
        "{name}: {mean} ± {se}, not {want}"
    );
}

/// ∫ L cos dω over a hemisphere is π L; a Lambert plane of albedo a sends back a L, which is
/// the white furnace for a = 1.
#[test]
fn a_plane_under_a_constant_sky() {
    let sky = Environment::constant(Vec3::splat(0.7));
    for normal in [Vec3::Y, Vec3::new(0.6, 0.0, -0.8)] {
        agrees("constant", irradiance(&sky, normal), PI * f64::from(0.7f32));
    }
    for (size, mapping) in [((8, 4), Mapping::LatLong), ((8, 8), Mapping::Octahedral)] {
        let texels = vec![Vec3::splat(0.7); size.0 as usize * size.1 as usize];
        let map = EnvironmentMap::new(size, texels, mapping, Mat3::IDENTITY).unwrap();
        let all = f64::from(map.integral(|_| 1.0).x);
        assert!((all / (4.0 * PI * f64::from(0.7f32)) - 1.0).abs() < 1e-6);
        let name = format!("constant map, {mapping:?}");
        agrees(
            &name,
            irradiance(&Environment::of_map(map), Vec3::Y),
            PI * f64::from(0.7f32),
        );
    }
}

/// L = 1 + dy has E(n) = ∫ (1 + w·y) max(0, w·n) dω = π + (2π/3) n·y. The map is bilinear in
/// the angle, so that it misses L by up to (π/128)²/8 and E by less than 1e-4.
#[test]
fn a_plane_under_a_gradient() {
    let size = (256, 128);
    let texel = |k: u32| {
        let theta = PI * (f64::from(k / size.0) + 0.5) / f64::from(size.1);
        Vec3::splat((1.0 + theta.cos()) as f32)
    };
    let texels = (0..size.0 * size.1).map(texel).collect();
    let map = EnvironmentMap::new(size, texels, Mapping::LatLong, Mat3::IDENTITY).unwrap();
    let sky = Environment::of_map(map);
    for normal in [Vec3::Y, Vec3::X, Vec3::new(0.0, 0.6, 0.8)] {
        let (mean, se) = irradiance(&sky, normal);
        let want = PI + 2.0 * PI / 3.0 * f64::from(normal.y);
        agrees("gradient", (mean, se + 1e-4), want);
    }
}

/// A plane tilted by θ gets E cos θ of a disk that it sees whole: the disk is symmetric.
#[test]
fn the_sun_on_a_tilted_plane() {
    let toward = sky_direction(40.0, 50.0);
    let across = toward.any_orthonormal_vector();
    for diameter in [0.0, 0.53, 20.0] {
        let sun = DistantLight {
            diameter,
            ..DistantLight::sun(toward, Vec3::splat(4.0))
        };
        for tilt in [0.0f32, 0.5, 1.2] {
            let normal = toward * tilt.cos() + across * tilt.sin();
            let want = 4.0 * f64::from(tilt.cos());
            agrees("sun", irradiance(&sun, normal), want);
        }
    }
}

/// Azimuth from -z towards +x, elevation from the horizon.
#[test]
fn directions_of_the_sky() {
    for (azimuth, elevation, want) in [
        (0.0, 0.0, Vec3::NEG_Z),
        (90.0, 0.0, Vec3::X),
        (180.0, 0.0, Vec3::Z),
        (0.0, 90.0, Vec3::Y),
    ] {
        assert!((sky_direction(azimuth, elevation) - want).length() < 1e-6);
    }
    let [azimuth, elevation] = azimuth_elevation(sky_direction(227.0, 28.0));
    assert!((azimuth - 227.0).abs() < 1e-4 && (elevation - 28.0).abs() < 1e-4);
}

fn spot(inner: f32, outer: f32, falloff: Falloff) -> SpotLight {
    SpotLight {
        position: Vec3::new(0.0, 2.0, 0.0),
        axis: Vec3::NEG_Y,
        intensity: Vec3::splat(3.0),
        inner,
        outer,
        falloff,
    }
}

/// A plane square to the axis gets I f(a) cos³ a / h² at the angle a from it.
#[test]
fn a_spots_irradiance_across_its_cone() {
    let (inner, outer) = (0.4f32, 0.9f32);
    let t = |a: f32| ((a.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
    type Course = fn(f32) -> f32;
    let courses: [(Falloff, Course); 3] = [
        (Falloff::Smoothstep, |t| 3.0 * t * t - 2.0 * t * t * t),
        (Falloff::Quartic, |t| t.powi(4)),
        (Falloff::Squared, |t| t.powi(2)),
    ];
    for (falloff, course) in courses {
        let light = spot(inner, outer, falloff);
        for step in 0..100 {
            let angle = step as f32 * 0.012;
            let at = Vec3::new(2.0 * angle.tan(), 0.0, 0.0);
            let found = light
                .sample(at, [0.0; 2])
                .map_or(0.0, |a| a.irradiance.x * a.toward.y);
            let want = 3.0 * course(t(angle)) * angle.cos().powi(3) / 4.0;
            assert!(
                (found - want).abs() < 1e-5,
                "{falloff:?} at {angle}: {found} {want}"
            );
        }
    }
}

/// Power against 2π ∫ I f(a) sin a da by midpoints.
#[test]
fn a_spots_power_is_its_integral() {
    for falloff in [Falloff::Smoothstep, Falloff::Quartic, Falloff::Squared] {
        for (inner, outer) in [(0.0, 0.5), (0.4, 0.9), (0.6, 0.61), (1.0, 3.1)] {
            let light = spot(inner, outer, falloff);
            let step = f64::from(outer) / 20_000.0;
            let sum: f64 = (0..20_000)
                .map(|k| {
                    let (sine, cosine) = ((f64::from(k) + 0.5) * step).sin_cos();
                    let direction = Vec3::new(sine as f32, -cosine as f32, 0.0);
                    2.0 * PI * f64::from(3.0 * light.share(direction)) * sine * step
                })
                .sum();
            let power = f64::from(light.power(1.0).x);
            assert!(
                (power / sum - 1.0).abs() < 2e-3,
                "{falloff:?} {inner}: {power} {sum}"
            );
        }
    }
}

#[test]
fn points_fall_off_with_the_squared_distance() {
    let light = PointLight {
        position: Vec3::X * 2.0,
        intensity: Vec3::splat(6.0),
    };
    let arrival = light.sample(Vec3::NEG_X, [0.0; 2]).unwrap();
    assert_eq!((arrival.toward, arrival.distance), (Vec3::X, 3.0));
    assert!((arrival.irradiance.x - 6.0 / 9.0).abs() < 1e-6);
    assert!(light.sample(light.position, [0.0; 2]).is_none());
}

/// Dimmed to 0, a light gives nothing; a colour's factor acts on every part alike.
#[test]
fn dimming_is_a_factor() {
    let map = EnvironmentMap::new(
        (2, 1),
        vec![Vec3::ONE, Vec3::X],
        Mapping::LatLong,
        Mat3::IDENTITY,
    );
    let lights: [LightSource; 4] = [
        spot(0.2, 0.6, Falloff::Squared).into(),
        PointLight {
            position: Vec3::ONE,
            intensity: Vec3::ONE,
        }
        .into(),
        DistantLight::sun(Vec3::Y, Vec3::ONE).into(),
        Environment::of_map(map.unwrap()).into(),
    ];
    let factor = Vec3::new(0.5, 2.0, 0.0);
    for light in lights {
        let dimmed = light.dimmed(factor);
        assert!(dimmed.check().is_ok());
        let (a, b) = (
            light.sample(Vec3::ZERO, [0.3, 0.4]),
            dimmed.sample(Vec3::ZERO, [0.3, 0.4]),
        );
        let (a, b) = (a.unwrap(), b.unwrap());
        assert_eq!((a.toward, a.density), (b.toward, b.density));
        let error = (a.irradiance * factor - b.irradiance).abs().max_element();
        assert!(error <= 1e-6 * a.irradiance.max_element());
        assert_eq!(light.power(2.0) * factor, dimmed.power(2.0));
        let (mut words, mut others) = (Vec::new(), Vec::new());
        light.words(&mut |word| words.push(word));
        dimmed.words(&mut |word| others.push(word));
        assert_ne!(words, others, "the hash sees {}", light.summary());
    }
}

#[test]
fn parameters_that_are_no_light_are_refused() {
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let good = PointLight {
        position: Vec3::ZERO,
        intensity: Vec3::ONE,
    };
    assert!(
        PointLight {
            position: nan,
            ..good
        }
        .check()
        .is_err()
    );
    assert!(
        PointLight {
            intensity: -Vec3::X,
            ..good
        }
        .check()
        .is_err()
    );
    assert!(spot(0.6, 0.5, Falloff::Squared).check().is_err());
    assert!(spot(0.0, 4.0, Falloff::Squared).check().is_err());
    assert!(spot(0.3, 0.5, Falloff::Squared).check().is_ok());
    let sun = DistantLight::sun(Vec3::Y, Vec3::ONE);
    assert!(
        DistantLight {
            diameter: -1.0,
            ..sun
        }
        .check()
        .is_err()
    );
    assert!(
        DistantLight {
            diameter: f32::NAN,
            ..sun
        }
        .check()
        .is_err()
    );
    assert!(Environment::constant(Vec3::INFINITY).check().is_err());
}
