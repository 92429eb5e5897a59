//! Lights by direction: sky, sun, spot, goniometric; their frames by each version's formulas.

use super::files::{error, read};
use super::{TRIANGLE, warnings, world_v3, world_v4};
use crate::{LightSource, Scene};
use glam::Vec3;
use rrf_lights::{DistantLight, Environment, Falloff, LightKind, SpotLight};
use std::f32::consts::PI;

/// A PFM of texels in the order that pictures are written in, from the top.
fn pfm(width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for row in (0..height).rev() {
        for column in 0..width {
            bytes.extend(texel(column, row).into_iter().flat_map(f32::to_le_bytes));
        }
    }
    bytes
}

/// Every texel is another number.
fn numbered(width: usize, height: usize) -> Vec<u8> {
    pfm(width, height, |x, y| [(1 + x + width * y) as f32; 3])
}

fn only(scene: &Scene) -> &LightSource {
    let [light] = scene.lights.as_slice() else {
        panic!("{:?}", scene.lights);
    };
    &light.source
}

fn sky(scene: &Scene) -> &Environment {
    match only(scene) {
        LightSource::Environment(sky) => sky,
        other => panic!("{other:?}"),
    }
}

fn sun(world: &str) -> DistantLight {
    let scene = world_v4(&format!("{world} {TRIANGLE}")).unwrap();
    match only(&scene) {
        LightSource::Distant(sun) => *sun,
        other => panic!("{other:?}"),
    }
}

fn spot(scene: Scene) -> SpotLight {
    match only(&scene) {
        LightSource::Spot(spot) => *spot,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sun_shines_from_from_to_to() {
    let high = "\"point3 from\" [0 5 0] \"point3 to\" [0 0 0]";
    let found = sun(&format!(
        "LightSource \"distant\" \"rgb L\" [1 2 3] \"float scale\" 2 {high}"
    ));
    assert_eq!(found.toward, Vec3::Y);
    assert_eq!(found.irradiance, Vec3::new(2.0, 4.0, 6.0));
    // A quarter turn about x takes y to z; a scale changes no direction.
    let found = sun(&format!(
        "Rotate 90 1 0 0 Scale 3 3 3 LightSource \"distant\" {high}"
    ));
    assert!((found.toward - Vec3::Z).length() < 1e-6, "{}", found.toward);
    // By default along +z, from -z.
    assert_eq!(sun("LightSource \"distant\"").toward, Vec3::NEG_Z);
    let found = sun("LightSource \"distant\" \"spectrum L\" [300 5 900 5] \"float illuminance\" 7");
    let y = found
        .irradiance
        .dot(Vec3::new(0.2126729, 0.7151522, 0.0721750));
    assert!((y - 7.0).abs() < 1e-4, "{}", found.irradiance);
}

#[test]
fn a_spot_has_its_versions_falloff_and_its_power() {
    let light = "LightSource \"spot\" \"float coneangle\" 40 \"float conedeltaangle\" 15 \
                 \"point from\" [1 0 0] \"point to\" [1 0 5]";
    let v4 = |more: &str| spot(world_v4(&format!("{light} {more} {TRIANGLE}")).unwrap());
    let found = v4("\"rgb I\" [1 2 3]");
    assert_eq!((found.position, found.axis), (Vec3::X, Vec3::Z));
    assert_eq!(found.intensity, Vec3::new(1.0, 2.0, 3.0));
    assert!((found.outer.to_degrees() - 40.0).abs() < 1e-4);
    assert!((found.inner.to_degrees() - 25.0).abs() < 1e-4);
    assert_eq!(found.falloff, Falloff::Smoothstep);
    let v3 = spot(world_v3(&format!("{light} \"color I\" [1 2 3] {TRIANGLE}")).unwrap());
    assert_eq!(v3.falloff, Falloff::Quartic);
    // pbrt's power: 2 pi ((1 - cos inner) + (cos inner - cos outer) / 2) times the intensity.
    let found = v4("\"float power\" 10");
    let (start, end) = (25f32.to_radians().cos(), 40f32.to_radians().cos());
    let angle = 2.0 * PI * ((1.0 - start) + (start - end) / 2.0);
    assert!((found.intensity.x * angle - 10.0).abs() < 1e-4);
    for (angles, words) in [
        ("10 \"float conedeltaangle\" -5", "15 degrees"),
        ("181", "181 degrees"),
    ] {
        let world = format!("LightSource \"spot\" \"float coneangle\" {angles} {TRIANGLE}");
        let message = world_v4(&world).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let text = format!("Scale 1 2 1 LightSource \"spot\" {TRIANGLE}");
    assert!(warnings(&world_v4(&text).unwrap()).contains("its cone stays round"));
}

#[test]
fn a_constant_sky() {
    let world = |light: &str| world_v4(&format!("LightSource \"infinite\" {light} {TRIANGLE}"));
    let scene = world("\"rgb L\" [1 2 3] \"float scale\" 2").unwrap();
    assert_eq!(
        sky(&scene),
        &Environment::constant(Vec3::new(2.0, 4.0, 6.0))
    );
    assert_eq!(scene.own_light_names(), ["sky"]);
    // A plane under it gets pi times its radiance.
    let scene = world("\"float illuminance\" 5").unwrap();
    assert!((sky(&scene).radiance * PI - 5.0).abs().max_element() < 1e-5);
    let portal = "\"point3 portal\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    let scene = world(portal).unwrap();
    assert_eq!(
        sky(&scene).portals[0].corners()[2],
        Vec3::new(1.0, 1.0, 0.0)
    );
    assert!(warnings(&scene).contains("hides nothing"));
    for (portal, words) in [
        ("\"point3 portal\" [0 0 0 1 0 0 1 1 0]", "3 corners"),
        ("\"point3 portal\" [0 0 0 1 0 0 1 1 0 0 0 0]", "rectangle"),
    ] {
        let message = world(portal).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// pbrt-v3, `InfiniteAreaLight::Le`: s = phi / 2 pi, t = theta / pi about the light's z.
#[test]
fn version_3_maps_are_lat_long_about_z() {
    let (scene, _folder) = read(
        &format!(
            "WorldBegin Rotate 90 1 0 0 LightSource \"infinite\" \"string mapname\" \"sky.pfm\" \
             \"rgb L\" [2 2 2] \"rgb scale\" [1 2 3] {TRIANGLE} WorldEnd"
        ),
        &[("sky.pfm", &numbered(8, 4))],
    );
    let scene = scene.unwrap();
    for (x, y) in (0..8).flat_map(|x| (0..4).map(move |y| (x, y))) {
        let (phi, theta) = (
            2.0 * PI * (x as f32 + 0.5) / 8.0,
            PI * (y as f32 + 0.5) / 4.0,
        );
        let (sine, cosine) = theta.sin_cos();
        let local = Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
        // The quarter turn about x: (x, y, z) to (x, -z, y).
        let world = Vec3::new(local.x, -local.z, local.y);
        let want = (1 + x + 8 * y) as f32 * Vec3::new(2.0, 4.0, 6.0);
        let found = LightKind::radiance(sky(&scene), world);
        assert!(
            (found / want - 1.0).abs().max_element() < 1e-4,
            "{x} {y}: {found} {want}"
        );
    }
}

/// The octahedron's square: +z in its middle, x to the right, y down, -z in the corners.
#[test]
fn version_4_maps_are_equal_area() {
    let text =
        |light: &str| format!("WorldBegin {light} \"string filename\" \"sky.pfm\" {TRIANGLE}");
    let files: [(&str, &[u8]); 1] = [("sky.pfm", &numbered(4, 4))];
    let (scene, _folder) = read(&text("LightSource \"infinite\""), &files);
    let scene = scene.unwrap();
    for (direction, column, row) in [
        (Vec3::new(0.1, 0.2, 1.0), 2, 2),
        (Vec3::new(-0.1, 0.2, 1.0), 1, 2),
        (Vec3::new(0.1, -0.2, 1.0), 2, 1),
        (Vec3::new(0.1, 0.2, -1.0), 3, 3),
        (Vec3::new(-0.1, -0.2, -1.0), 0, 0),
        (Vec3::new(0.1, -0.2, -1.0), 3, 0),
    ] {
        let found = LightKind::radiance(sky(&scene), direction.normalize()).x;
        assert_eq!(found, (1 + column + 4 * row) as f32, "{direction}");
    }
    // A map of ones as bright as a constant sky: pi on a plane facing its z, by midpoints of texels.
    let ones: [(&str, &[u8]); 1] = [("sky.pfm", &pfm(256, 256, |_, _| [1.0; 3]))];
    let light = "Rotate 30 1 2 3 LightSource \"infinite\" \"float illuminance\" 5";
    let (scene, _folder) = read(&text(light), &ones);
    let radiance = sky(&scene.unwrap()).radiance;
    assert!(
        (radiance * PI / 5.0 - 1.0).abs().max_element() < 2e-3,
        "{radiance}"
    );
    let both = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    assert!(error(&text(both), &files).contains("not both"));
}

#[test]
fn skies_that_are_none() {
    let text =
        format!("WorldBegin\nLightSource \"infinite\" \"string filename\" \"sky.pfm\" {TRIANGLE}");
    let bad = |value: f32| {
        pfm(2, 2, move |x, y| {
            [if (x, y) == (1, 0) { value } else { 1.0 }; 3]
        })
    };
    for (file, words) in [
        (bad(f32::NAN), "texel in column 1, row 0"),
        (bad(-1.0), "texel in column 1, row 0"),
        (bad(f32::INFINITY), "texel in column 1, row 0"),
        (numbered(4, 2), "square"),
        (b"no picture".to_vec(), "cannot be decoded"),
        (b"PF\n2 2\n-1\n1234".to_vec(), "truncated"),
    ] {
        let message = error(&text, &[("sky.pfm", &file)]);
        assert!(
            message.contains(words) && message.contains("sky.pfm"),
            "{message}"
        );
        assert!(message.contains("scene.pbrt:2:24"), "{message}");
    }
    let (scene, _folder) = read(&text, &[]);
    let scene = scene.unwrap();
    assert_eq!(sky(&scene), &Environment::constant(Vec3::ONE));
    assert!(warnings(&scene).contains("sky.pfm is not there"));
}

/// A goniometric picture's pole is the light's +y: version 3's row 0, version 4's middle.
#[test]
fn goniometric_pictures_point_up() {
    let bright_top = pfm(4, 4, |x, y| {
        [if (1..3).contains(&x) && y < 3 && y > 0 {
            8.0
        } else {
            0.0
        }; 3]
    });
    let files: [(&str, &[u8]); 2] = [("v4.pfm", &bright_top), ("v3.pfm", &numbered(8, 4))];
    let (scene, _folder) = read(
        &format!(
            "WorldBegin Translate 1 2 3 LightSource \"goniometric\" \"rgb I\" [1 2 3] \
             \"string filename\" \"v4.pfm\" {TRIANGLE}"
        ),
        &files,
    );
    let scene = scene.unwrap();
    let LightSource::Goniometric(light) = only(&scene) else {
        panic!("{:?}", scene.lights);
    };
    assert_eq!(light.position, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(light.intensity_in(Vec3::Y), Vec3::new(8.0, 16.0, 24.0));
    assert_eq!(light.intensity_in(Vec3::NEG_Y), Vec3::ZERO);
    let (scene, _folder) = read(
        &format!(
            "WorldBegin LightSource \"goniometric\" \"string mapname\" \"v3.pfm\" {TRIANGLE} WorldEnd"
        ),
        &files,
    );
    let scene = scene.unwrap();
    let LightSource::Goniometric(light) = only(&scene) else {
        panic!("{:?}", scene.lights);
    };
    // pbrt-v3, `GonioPhotometricLight::Scale`: phi from x towards z, theta from y.
    for (x, y) in [(0, 0), (3, 1), (6, 2), (7, 3)] {
        let (phi, theta) = (
            2.0 * PI * (x as f32 + 0.5) / 8.0,
            PI * (y as f32 + 0.5) / 4.0,
        );
        let (sine, cosine) = theta.sin_cos();
        let direction = Vec3::new(sine * phi.cos(), cosine, sine * phi.sin());
        let found = light.intensity_in(direction).x;
        assert!(
            (found - (1 + x + 8 * y) as f32).abs() < 1e-3,
            "{x} {y}: {found}"
        );
    }
}

/// An IES profile shines down along -y; its horizontal angles go from x towards -z.
#[test]
fn goniometric_profiles_point_down() {
    let profile = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 4 1 2 0 0 0\n1 1 10\n0 45 90\n\
                   0 90 180 270\n100 80 1\n100 80 2\n100 80 3\n100 80 4\n";
    let (scene, _folder) = read(
        &format!(
            "WorldBegin LightSource \"goniometric\" \"string filename\" \"lamp.ies\" {TRIANGLE}"
        ),
        &[("lamp.ies", profile.as_bytes())],
    );
    let scene = scene.unwrap();
    let LightSource::Goniometric(light) = only(&scene) else {
        panic!("{:?}", scene.lights);
    };
    let at = |direction: Vec3| light.intensity_in(direction).x;
    assert_eq!((at(Vec3::NEG_Y), at(Vec3::Y)), (100.0, 0.0));
    let level = |x: f32, z: f32| at(Vec3::new(x, -1e-3, z).normalize());
    for (want, found) in [
        (1.0, level(1.0, 0.0)),
        (2.0, level(0.0, -1.0)),
        (3.0, level(-1.0, 0.0)),
        (4.0, level(0.0, 1.0)),
    ] {
        assert!((found - want).abs() < 0.2, "{found} {want}");
    }
    let broken = "WorldBegin LightSource \"goniometric\" \"string filename\" \"lamp.ies\"";
    let message = error(broken, &[("lamp.ies", b"IESNA\nTILT=NONE\n1")]);
    assert!(
        message.contains("lamp.ies") && message.contains("line 3"),
        "{message}"
    );
}
