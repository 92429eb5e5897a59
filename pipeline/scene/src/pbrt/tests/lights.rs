//! Lights: units, versions, scale and power.

use super::{TRIANGLE, warnings, world_v3, world_v4};
use crate::Scene;
use glam::Vec3;
use std::f32::consts::PI;

/// Y of linear sRGB (IEC 61966-2-1).
fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126729, 0.7151522, 0.0721750))
}

fn point_v4(light: &str) -> Scene {
    world_v4(&format!("LightSource \"point\" {light}\n{TRIANGLE}")).unwrap()
}

#[test]
fn point_lights() {
    let scene = point_v4("\"rgb I\" [1 2 3] \"float scale\" 10 \"point3 from\" [0 1 0]");
    assert_eq!(
        scene.points().next().unwrap().intensity,
        Vec3::new(10.0, 20.0, 30.0)
    );
    assert_eq!(scene.points().next().unwrap().position, Vec3::Y);
    // 4 pi W over the sphere are 1 W/sr.
    let scene = point_v4(&format!("\"float power\" {}", 4.0 * PI));
    assert!((scene.points().next().unwrap().intensity - Vec3::ONE).length() < 1e-6);
    let scene = world_v4(&format!(
        "Translate 1 2 3 Scale 2 2 2 LightSource \"point\" \"point from\" [1 0 0] {TRIANGLE}"
    ));
    assert_eq!(
        scene.unwrap().points().next().unwrap().position,
        Vec3::new(3.0, 2.0, 3.0)
    );
    // Version 3: `scale` may be a colour.
    let scene = world_v3(&format!(
        "LightSource \"point\" \"color I\" [1 2 3] \"rgb scale\" [3 2 1] {TRIANGLE}"
    ));
    assert_eq!(
        scene.unwrap().points().next().unwrap().intensity,
        Vec3::new(3.0, 4.0, 3.0)
    );
}

/// Version 4: a spectrum has Y = 1 before `scale`; version 3: its own Y.
#[test]
fn spectra_by_version() {
    let pairs = "\"spectrum I\" [300 5 900 5]";
    let v4 = point_v4(&format!("{pairs} \"float scale\" 7"))
        .points()
        .next()
        .unwrap()
        .intensity;
    assert!((luminance(v4) - 7.0).abs() < 1e-4, "{v4}");
    let v3 = world_v3(&format!("LightSource \"point\" {pairs} {TRIANGLE}"))
        .unwrap()
        .points()
        .next()
        .unwrap()
        .intensity;
    assert!((luminance(v3) - 5.0).abs() < 1e-4, "{v3}");
    let black_body = point_v4("\"blackbody I\" 3000")
        .points()
        .next()
        .unwrap()
        .intensity;
    assert!((luminance(black_body) - 1.0).abs() < 1e-5 && black_body.x > black_body.z);
    let white = point_v4("\"spectrum I\" \"stdillum-D65\"")
        .points()
        .next()
        .unwrap()
        .intensity;
    assert_eq!(white, Vec3::ONE);
    // 1000 K lies outside sRGB.
    assert!(warnings(&point_v4("\"blackbody I\" 1000")).contains("outside sRGB"));
}

/// Version 3's two values: temperature and scale of the peak; near 5000 K the eye sees the
/// flat top of the curve, so that Y is near the scale.
#[test]
fn blackbody_of_version_3() {
    let world = format!("LightSource \"point\" \"blackbody I\" [5200 3] {TRIANGLE}");
    let y = luminance(world_v3(&world).unwrap().points().next().unwrap().intensity);
    assert!((y / 3.0 - 1.0).abs() < 0.03, "{y}");
}

#[test]
fn area_lights_are_shared_and_end_with_their_block() {
    let scene = world_v4(&format!(
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool twosided\" true \
         {TRIANGLE} {TRIANGLE} AttributeEnd {TRIANGLE}"
    ))
    .unwrap();
    assert_eq!(scene.area_lights.len(), 1);
    assert_eq!(scene.area_lights[0].radiance, Vec3::new(2.0, 4.0, 6.0));
    assert!(scene.area_lights[0].two_sided);
    assert_eq!(scene.triangle_light, [0, 0, crate::INVALID]);
}

/// Lights are counted in file order, all shapes under one emission as one light.
#[test]
fn names_of_lights() {
    let scene = world_v4(&format!(
        "AttributeBegin AreaLightSource \"diffuse\" {TRIANGLE} {TRIANGLE} AttributeEnd \
         LightSource \"point\" \
         AttributeBegin AreaLightSource \"diffuse\" \"float power\" 3 {TRIANGLE} {TRIANGLE} AttributeEnd"
    ))
    .unwrap();
    assert_eq!(scene.area_light_names, ["light0", "light2", "light2"]);
    assert_eq!(scene.own_light_names(), ["light1", "light0", "light2"]);
    assert!(scene.has_own_lights() && !scene.unlit().has_own_lights());
}

/// pbrt-v4 gives each of its shapes the power: each triangle, but a quadric as a whole.
/// The radiant power of a Lambertian emitter is pi * area * radiance a side.
#[test]
fn power_of_area_lights() {
    for (shape, lights) in [
        ("Shape \"disk\"", 1),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 3 0 0 0 1 0 3 1 1] \"integer indices\" [0 1 2 1 3 2]",
            2,
        ),
    ] {
        for (two_sided, sides) in [("false", 1), ("true", 2)] {
            let scene = world_v4(&format!(
                "AreaLightSource \"diffuse\" \"float power\" 100 \"bool twosided\" {two_sided} {shape}"
            ))
            .unwrap();
            let summary = scene.summary();
            assert_eq!(summary.area_lights.len(), lights);
            for light in summary.area_lights {
                assert_eq!(u32::from(light.two_sided) + 1, sides);
                assert!((light.power[1] / 100.0 - 1.0).abs() < 1e-6, "{light:?}");
            }
        }
    }
}

/// A picture lies on the shape; its power is that of its mean luminance.
#[test]
fn lamps_with_pictures() {
    let mut picture = b"PF\n2 1\n-1\n".to_vec();
    let texels = [0.0f32, 0.0, 0.0, 3.0, 1.0, 2.0];
    picture.extend(texels.into_iter().flat_map(f32::to_le_bytes));
    let files: [(&str, &[u8]); 1] = [("lamp.pfm", &picture)];
    let with = |light: &str| {
        let text = format!(
            "WorldBegin AreaLightSource \"diffuse\" \"string filename\" \"lamp.pfm\" {light} \
             Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0.5 1 0] \
             \"point2 uv\" [0 0 1 0 0.5 1]"
        );
        super::files::read(&text, &files).0.unwrap()
    };
    let scene = with("\"float scale\" 2");
    let emitted = |place| scene.area_lights[0].radiance * scene.emitted_share(0, place);
    // u = 0.75 is the middle of the bright texel, u = 0.25 that of the black one.
    assert!((emitted([0.75, 0.0]) - Vec3::new(6.0, 2.0, 4.0)).length() < 1e-5);
    assert_eq!(emitted([0.0, 0.5]), Vec3::ZERO);
    assert!(scene.textures[0].texels[1].max_element() <= 1.0);
    assert!(
        !warnings(&scene).contains("clamped"),
        "{}",
        warnings(&scene)
    );
    // Half of the triangle is dark, as of the picture: the symmetric mean is exact.
    let scene = with("\"float power\" 100");
    let power = scene.summary().area_lights[0].power.map(|w| w as f32);
    assert!(
        (luminance(Vec3::from(power)) / 100.0 - 1.0).abs() < 1e-2,
        "{power:?}"
    );
    assert!((power[0] / power[1] - 3.0).abs() < 1e-4, "{power:?}");
}

#[test]
fn lights_that_are_left_out() {
    let scene = world_v4(&format!(
        "LightSource \"projection\" \"float fov\" 30\n{TRIANGLE}"
    ))
    .unwrap();
    assert!(scene.lights.is_empty());
    let text = warnings(&scene);
    assert!(
        text.contains("scene.pbrt:3:13: LightSource \"projection\" is left out"),
        "{text}"
    );
    let scene = world_v4(&format!(
        "ObjectBegin \"o\" AreaLightSource \"diffuse\" {TRIANGLE} ObjectEnd ObjectInstance \"o\""
    ))
    .unwrap();
    assert!(scene.area_lights.is_empty());
    assert!(warnings(&scene).contains("does not shine"));
}

#[test]
fn media_and_motion_are_named() {
    let scene = world_v4(&format!(
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fog\" \"\" \
         ActiveTransform EndTime Translate 5 0 0 ActiveTransform All {TRIANGLE}"
    ))
    .unwrap();
    let text = warnings(&scene);
    assert!(
        text.contains("\"fog\" scatters light; it is left out")
            && text.contains("motion is left out"),
        "{text}"
    );
    assert_eq!(scene.positions[0], Vec3::ZERO);
}
