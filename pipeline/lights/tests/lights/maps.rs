//! Environment maps: where directions land, what is looked up, what is refused.

use crate::samplers::picture;
use crate::statistics::Random;
use glam::{Mat3, Vec3};
use rrf_lights::{Environment, EnvironmentMap, LightError, LightKind, Mapping, uniform_sphere};

fn map(size: (u32, u32), mapping: Mapping) -> EnvironmentMap {
    EnvironmentMap::new(size, picture(size.0, size.1), mapping, Mat3::IDENTITY).unwrap()
}

/// Place and direction are each other's inverse.
#[test]
fn mappings_go_there_and_back() {
    let mut random = Random(3);
    for mapping in [Mapping::LatLong, Mapping::Octahedral] {
        for _ in 0..20_000 {
            let d = uniform_sphere(random.pair());
            let back = mapping.direction(mapping.place(d));
            assert!((d - back).length() < 1e-6, "{mapping:?}: {d} {back}");
        }
    }
}

/// The stated formulas: column 0 at -z, a quarter at +x, row 0 at the zenith; the
/// octahedron's middle is +z, its corners -z, its sides' middles the axes.
#[test]
fn axes_lie_where_the_formats_say() {
    let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() + (b - d).abs() < 1e-7;
    for (d, place) in [
        (Vec3::NEG_Z, [0.0, 0.5]),
        (Vec3::X, [0.25, 0.5]),
        (Vec3::Z, [0.5, 0.5]),
        (Vec3::NEG_X, [0.75, 0.5]),
    ] {
        assert!(near(Mapping::LatLong.place(d), place), "{d}");
    }
    assert_eq!(Mapping::LatLong.place(Vec3::Y)[1], 0.0);
    assert_eq!(Mapping::LatLong.place(Vec3::NEG_Y)[1], 1.0);
    for (d, place) in [
        (Vec3::Z, [0.5, 0.5]),
        (Vec3::X, [1.0, 0.5]),
        (Vec3::Y, [0.5, 1.0]),
        (Vec3::NEG_X, [0.0, 0.5]),
        (Vec3::NEG_Y, [0.5, 0.0]),
        (Vec3::NEG_Z, [1.0, 1.0]),
    ] {
        assert!(near(Mapping::Octahedral.place(d), place), "{d}");
    }
}

/// Cells of equal area in the octahedron's square are equal on the sphere: directions uniform
/// over the sphere fall into them alike (16 x 16 cells, 5 standard deviations).
#[test]
fn the_octahedron_keeps_areas() {
    let mut counts = [0u32; 256];
    let mut random = Random(4);
    const DRAWS: u32 = 256_000;
    for _ in 0..DRAWS {
        let [s, t] = Mapping::Octahedral.place(uniform_sphere(random.pair()));
        let [x, y] = [s, t].map(|x| ((x * 16.0) as usize).min(15));
        counts[y * 16 + x] += 1;
    }
    for count in counts {
        assert!(
            (f64::from(count) - 1000.0).abs() < 5.0 * 1000f64.sqrt(),
            "{count}"
        );
    }
}

/// Texels' own directions give the texels back, and half-way there is their mean.
#[test]
fn lookups_hit_texels() {
    let size = (16u32, 8u32);
    let sky = map(size, Mapping::LatLong);
    let texels = picture(size.0, size.1);
    let direction = |x: f64, y: f64| Mapping::LatLong.direction([x / 16.0, y / 8.0]);
    for y in 0..8u32 {
        for x in 0..16u32 {
            let texel = |x: u32| texels[(y * 16 + x % 16) as usize];
            let (fx, fy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let found = sky.radiance(direction(fx, fy));
            assert!((found - texel(x)).length() < 1e-3, "{x} {y}: {found}");
            let between = sky.radiance(direction(fx + 0.5, fy));
            let mean = 0.5 * (texel(x) + texel(x + 1));
            assert!((between - mean).length() < 1e-3, "{x} {y}: {between}");
        }
    }
}

/// Wherever the map has light the sampler goes.
#[test]
fn no_light_is_missed() {
    let mut random = Random(8);
    for sky in [
        map((16, 8), Mapping::LatLong),
        map((16, 16), Mapping::Octahedral),
    ] {
        for _ in 0..50_000 {
            let d = uniform_sphere(random.pair());
            assert!(sky.radiance(d) == Vec3::ZERO || sky.density(d) > 0.0, "{d}");
        }
    }
}

/// Turning the map turns what is seen; the panorama shows the same sky.
#[test]
fn maps_turn_with_their_frame() {
    let to_map = Mat3::from_rotation_y(0.7);
    let size = (64, 32);
    let texels = picture(64, 32);
    let straight = map(size, Mapping::LatLong);
    let turned = EnvironmentMap::new(size, texels, Mapping::LatLong, to_map).unwrap();
    let mut random = Random(9);
    for _ in 0..1_000 {
        let d = uniform_sphere(random.pair());
        let (a, b) = (turned.radiance(d), straight.radiance(to_map * d));
        assert!((a - b).length() < 1e-6);
    }
    let panorama = straight.panorama(Vec3::splat(2.0));
    let doubled: Vec<Vec3> = picture(64, 32).iter().map(|t| *t * 2.0).collect();
    assert_eq!(panorama.texels, doubled);
    let octahedral = map((16, 16), Mapping::Octahedral).panorama(Vec3::ONE);
    assert_eq!((octahedral.width, octahedral.height), (32, 16));
}

#[test]
fn texels_that_are_no_light_are_named() {
    for bad in [f32::NAN, f32::INFINITY, -0.1] {
        let mut texels = picture(16, 8);
        texels[3 * 16 + 5].y = bad;
        let error = EnvironmentMap::new((16, 8), texels, Mapping::LatLong, Mat3::IDENTITY);
        let Err(LightError::Texel { column, row, .. }) = error else {
            panic!("{error:?}");
        };
        assert_eq!((column, row), (5, 3));
    }
    let refused = |size: (u32, u32), count, mapping| {
        EnvironmentMap::new(size, vec![Vec3::ONE; count], mapping, Mat3::IDENTITY).is_err()
    };
    assert!(refused((0, 0), 0, Mapping::LatLong));
    assert!(refused((2, 2), 3, Mapping::LatLong));
    assert!(refused((4, 2), 8, Mapping::Octahedral));
}

#[test]
fn a_black_map_gives_nothing() {
    let texels = vec![Vec3::ZERO; 8];
    let map = EnvironmentMap::new((4, 2), texels, Mapping::LatLong, Mat3::IDENTITY).unwrap();
    let sky = Environment::of_map(map);
    assert!(sky.sample(Vec3::ZERO, [0.5; 2]).is_none());
    assert_eq!(sky.density(Vec3::ZERO, Vec3::Y), 0.0);
    assert_eq!(sky.power(1.0), Vec3::ZERO);
}
