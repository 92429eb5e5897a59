//! Every sampler against its density: chi-square, and an integral of 1.

use crate::statistics::{Patch, chi_square};
use glam::{Mat3, Quat, Vec3};
use rrf_lights::{
    DistantLight, Environment, EnvironmentMap, Falloff, GoniometricLight, IesProfile, LightKind,
    Mapping, Photometry, PointLight, Portal, Profile, SpotLight, sky_direction, spread_of,
};

/// A picture with a bright spot, black parts and no symmetry.
pub fn picture(width: u32, height: u32) -> Vec<Vec3> {
    let texel = |k: u32| {
        let (x, y) = (k % width, k / width);
        let level = match (x * 8 / width, y * 8 / height) {
            (5, 2) => 40.0,
            (a, b) if a + b < 5 => 0.0,
            (a, b) => 0.2 + (a * b) as f32 * 0.1,
        };
        Vec3::new(level, 0.5 * level, 0.1 * level)
    };
    (0..width * height).map(texel).collect()
}

/// Chi-square of a light's sampler at a point, and its density's integral.
fn sampled(name: &str, light: &impl LightKind, at: Vec3, patch: Patch, fine: usize) -> f64 {
    let density = |w: Vec3| f64::from(light.density(at, w));
    let mut at_rims = 0;
    let integral = chi_square(name, patch, fine, density, |u| {
        let arrival = light.sample(at, u)?;
        let found = light.radiance(arrival.toward) / arrival.density?;
        let error = (found - arrival.irradiance).abs().max_element();
        at_rims += u32::from(error > 1e-3 * arrival.irradiance.max_element());
        Some(arrival.toward)
    });
    // Rounding takes a sample in thousands over the rim of a narrow disk or of a texel.
    assert!(
        at_rims < 200,
        "{name}: {at_rims} samples whose radiance is another"
    );
    integral
}

fn is_one(name: &str, integral: f64, error: f64) {
    assert!((integral - 1.0).abs() < error, "{name}: {integral}");
}

#[test]
fn suns_of_any_width() {
    let axis = sky_direction(227.0, 28.0);
    for diameter in [0.53f32, 10.0, 120.0] {
        let sun = DistantLight {
            diameter,
            ..DistantLight::sun(axis, Vec3::ONE)
        };
        let spread = f64::from(spread_of(0.5 * f64::from(diameter).to_radians()));
        let name = format!("sun of {diameter} degrees");
        // Up to f32's place of a direction at the rim: a cell or two of the ring.
        let patch = Patch {
            axis,
            spread: spread * 1.25,
        };
        is_one(&name, sampled(&name, &sun, Vec3::ZERO, patch, 5), 0.01);
    }
}

#[test]
fn maps_in_both_mappings() {
    let turn = Mat3::from_quat(Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1));
    let mirror = Mat3::from_cols(Vec3::Y, Vec3::Z, -Vec3::X);
    for (width, height, mapping, to_map) in [
        (32, 16, Mapping::LatLong, Mat3::IDENTITY),
        (16, 8, Mapping::LatLong, turn),
        (9, 7, Mapping::LatLong, mirror),
        (1, 1, Mapping::LatLong, Mat3::IDENTITY),
        (16, 16, Mapping::Octahedral, Mat3::IDENTITY),
        (8, 8, Mapping::Octahedral, turn),
    ] {
        let texels = match width {
            1 => vec![Vec3::ONE],
            _ => picture(width, height),
        };
        let map = EnvironmentMap::new((width, height), texels, mapping, to_map).unwrap();
        let name = format!("{mapping:?} {width} x {height}");
        let sky = Environment::of_map(map);
        // Texels' borders cross the midpoints' cells: an error of a few per mille.
        is_one(
            &name,
            sampled(&name, &sky, Vec3::ZERO, Patch::SPHERE, 12),
            2e-3,
        );
    }
}

#[test]
fn skies_with_portals() {
    let window = |z: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x, y, z);
        Portal::new([
            corner(-1.0, 0.5),
            corner(1.0, 0.5),
            corner(1.0, 2.0),
            corner(-1.0, 2.0),
        ])
    };
    let map =
        EnvironmentMap::new((16, 8), picture(16, 8), Mapping::LatLong, Mat3::IDENTITY).unwrap();
    for (name, sky) in [
        ("constant", Environment::constant(Vec3::ONE)),
        ("map", Environment::of_map(map)),
    ] {
        let sky = Environment {
            portals: vec![window(-2.0).unwrap(), window(3.0).unwrap()],
            ..sky
        };
        let at = Vec3::new(0.3, 0.7, 0.2);
        is_one(name, sampled(name, &sky, at, Patch::SPHERE, 12), 3e-3);
        // In a portal's plane only the other guides.
        let at = Vec3::new(0.0, 1.0, 3.0);
        is_one(name, sampled(name, &sky, at, Patch::SPHERE, 12), 3e-3);
    }
}

/// A rectangle's solid angle against the closed form for one seen along its axis:
/// 4 asin(sin α sin β), tan α = a / d, tan β = b / d; and directions meet it.
#[test]
fn portals_cover_their_solid_angle() {
    for (a, b, d) in [(1.0, 0.5, 2.0), (3.0, 3.0, 0.01), (0.1, 0.2, 50.0)] {
        let corner = |x: f32, y: f32| Vec3::new(x * a, d, y * b);
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let portal = Portal::new(corners).unwrap();
        let [a, b, d] = [a, b, d].map(f64::from);
        let sine = |x: f64| x / x.hypot(d);
        let want = 4.0 * (sine(a) * sine(b)).asin();
        let found = portal.solid_angle(Vec3::ZERO);
        assert!((found / want - 1.0).abs() < 1e-5, "{found} {want}");
        for k in 0..100u32 {
            let u = [(k % 10) as f32 / 9.0, (k / 10) as f32 / 9.0].map(|u| u.min(0.999_999));
            let (toward, distance) = portal.sample(Vec3::ZERO, u).unwrap();
            let (y, place) = (toward.y * distance, toward * distance);
            assert!((f64::from(y) / d - 1.0).abs() < 1e-4);
            assert!(f64::from(place.x.abs()) <= a * 1.0001);
            assert!(f64::from(place.z.abs()) <= b * 1.0001);
        }
    }
    let flat = [Vec3::ZERO, Vec3::X, Vec3::X, Vec3::ZERO];
    assert!(Portal::new(flat).is_err());
    let bent = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    assert!(Portal::new(bent).is_err());
}

/// Directions that leave points of light.
#[test]
fn light_that_leaves_points() {
    let spot = SpotLight {
        position: Vec3::ONE,
        axis: Vec3::new(0.6, -0.8, 0.0),
        intensity: Vec3::ONE,
        inner: 0.3,
        outer: 0.7,
        falloff: Falloff::Squared,
    };
    let picture = EnvironmentMap::new(
        (16, 16),
        picture(16, 16),
        Mapping::Octahedral,
        Mat3::IDENTITY,
    );
    let gonio = |profile| GoniometricLight {
        position: Vec3::ZERO,
        intensity: Vec3::ONE,
        profile,
    };
    let table = IesProfile::new(Photometry::C, vec![0.0, 90.0], vec![0.0], vec![3.0, 1.0]);
    let point = PointLight {
        position: Vec3::ZERO,
        intensity: Vec3::ONE,
    };
    leaves("point", &point);
    leaves("spot", &spot);
    leaves("picture", &gonio(Profile::Picture(picture.unwrap())));
    leaves("IES", &gonio(Profile::Ies(table.unwrap(), Mat3::IDENTITY)));
}

/// Intensity over density has the power as its mean, and a density that integrates to 1 over
/// where the sampler goes has that solid angle as the mean of its inverse.
fn leaves(name: &str, light: &impl LightKind) {
    use crate::statistics::{Random, mean_se};
    let mut random = Random(7);
    let samples: Vec<_> = (0..200_000)
        .filter_map(|_| light.leave(random.pair()))
        .collect();
    let power = f64::from(light.power(1.0).x);
    let values = samples.iter().map(|s| f64::from(s.intensity.x / s.density));
    let (mean, se) = mean_se(values);
    // Five standard errors: p 6e-7. The tables' own integral is by midpoints, 1e-4.
    assert!(
        (mean - power).abs() < 5.0 * se + 2e-4 * power,
        "{name}: {mean} {power} {se}"
    );
    let mut at_rims = 0;
    for sample in samples {
        let direction = sample.direction;
        assert!((direction.length() - 1.0).abs() < 1e-5);
        assert_eq!(light.intensity_toward(direction), sample.intensity);
        let told = light.leave_density(direction);
        at_rims += u32::from((told - sample.density).abs() > 1e-3 * sample.density);
    }
    // Rounding takes a sample in thousands over the rim of a cone or of a texel.
    assert!(at_rims < 200, "{name}: {at_rims} other densities");
}
