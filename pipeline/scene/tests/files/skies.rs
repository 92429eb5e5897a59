//! A sky for formats that have none, and lights by a lamp maker's profile.

use crate::glb::Glb;
use crate::support::{some_triangle, warns};
use glam::Vec3;
use rrf_lights::LightKind;
use rrf_scene::{LightSource, LoadOptions, Scene, SceneError, SkyOption, SkySource, load};
use serde_json::json;
use std::path::Path;

/// A lat-long PFM of 8 x 4 texels, every one another number.
fn numbered() -> Vec<u8> {
    let mut bytes = b"PF\n8 4\n-1\n".to_vec();
    for row in (0..4).rev() {
        for column in 0..8 {
            let texel = [(1 + column + 8 * row) as f32; 3];
            bytes.extend(texel.into_iter().flat_map(f32::to_le_bytes));
        }
    }
    bytes
}

/// Loads a triangle in a format under a sky; `sky` may name a file beside it.
fn under(file: &str, sky: SkySource, rotate: f32, picture: &[u8]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(file);
    let mut glb = Glb::new();
    some_triangle(&mut glb);
    let bytes = match Path::new(file).extension().unwrap().to_str().unwrap() {
        "glb" => glb.bytes(),
        "obj" => b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(),
        _ => b"WorldBegin LightSource \"infinite\" \"string filename\" \"gone.pfm\" \
               Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]"
            .to_vec(),
    };
    std::fs::write(&path, bytes).unwrap();
    std::fs::write(folder.path().join("sky.pfm"), picture).unwrap();
    let source = match sky {
        SkySource::Picture(name) => SkySource::Picture(folder.path().join(name)),
        constant => constant,
    };
    let options = LoadOptions {
        sky: Some(SkyOption { source, rotate }),
        ..LoadOptions::default()
    };
    load(&path, &options)
}

fn radiance(scene: &Scene, toward: Vec3) -> Vec3 {
    let [light] = scene.lights.as_slice() else {
        panic!("{:?}", scene.lights);
    };
    assert_eq!(light.name, "sky");
    light.source.radiance(toward)
}

/// Column 0 begins at -z, a quarter of the width is +x, row 0 is at the zenith; turned by an
/// angle, what stood at one azimuth stands that much further towards +x.
#[test]
fn a_picture_lies_about_y_and_is_turned() {
    for (file, rotate) in [("a.glb", 0.0), ("a.obj", 45.0), ("a.glb", -90.0)] {
        let scene = under(
            file,
            SkySource::Picture("sky.pfm".into()),
            rotate,
            &numbered(),
        )
        .unwrap();
        for (column, row) in (0..8).flat_map(|x| (0..4).map(move |y| (x, y))) {
            let azimuth = 45.0 * (f64::from(column) + 0.5) + f64::from(rotate);
            let elevation = 90.0 - 45.0 * (f64::from(row) + 0.5);
            let toward = rrf_lights::sky_direction(azimuth, elevation);
            let found = radiance(&scene, toward).x;
            let want = (1 + column + 8 * row) as f32;
            assert!((found / want - 1.0).abs() < 1e-4, "{column} {row}: {found}");
        }
    }
}

#[test]
fn a_constant_sky_changes_the_hash() {
    let hash = |blue: f32| {
        let scene = under("a.obj", SkySource::Constant([1.0, 2.0, blue]), 0.0, b"").unwrap();
        assert_eq!(radiance(&scene, Vec3::Z), Vec3::new(1.0, 2.0, blue));
        assert!(
            scene
                .warnings
                .iter()
                .all(|w| !w.message.contains("no lights"))
        );
        scene.hash()
    };
    assert_ne!(hash(3.0), hash(4.0));
}

/// A file whose own picture is missing takes the sky that is given in its place.
#[test]
fn a_sky_replaces_one_that_is_missing() {
    let scene = under("a.pbrt", SkySource::Constant([1.0, 2.0, 3.0]), 0.0, b"").unwrap();
    assert_eq!(radiance(&scene, Vec3::Y), Vec3::new(1.0, 2.0, 3.0));
    assert!(warns(&scene, "--sky takes its place"));
}

#[test]
fn skies_that_are_none() {
    let picture = || SkySource::Picture("sky.pfm".into());
    let mut bad = numbered();
    let last = bad.len() - 4;
    bad[last..].copy_from_slice(&(-1.0f32).to_le_bytes());
    for (sky, bytes, words) in [
        (picture(), bad.as_slice(), "texel in column 7, row 0"),
        (picture(), b"no picture", "cannot be decoded"),
        (
            SkySource::Picture("none.exr".into()),
            b"",
            "none.exr: cannot be read",
        ),
        (SkySource::Constant([-1.0, 0.0, 0.0]), b"", "none negative"),
    ] {
        let message = under("a.glb", sky, 0.0, bytes).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pbrt");
    let text = "WorldBegin LightSource \"infinite\" \
                Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    std::fs::write(&path, text).unwrap();
    let source = SkySource::Constant([1.0; 3]);
    let options = LoadOptions {
        sky: Some(SkyOption {
            source,
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    let message = load(&path, &options).unwrap_err().to_string();
    assert!(message.contains("environment of its own"), "{message}");
}

/// EXT_lights_ies: aimed along the node's -z, horizontal angles from its +x towards +y.
#[test]
fn a_lamp_makers_profile_follows_its_node() {
    let profile = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 4 1 2 0 0 0\n1 1 10\n0 45 90\n\
                   0 90 180 270\n683 80 1\n683 80 2\n683 80 3\n683 80 4\n";
    let mut glb = Glb::new();
    some_triangle(&mut glb);
    let view = glb.view(profile.as_bytes());
    let mime = "application/x-ies-lm-63";
    glb.json["extensions"] = json!({ "EXT_lights_ies": {
        "lights": [{ "bufferView": view, "mimeType": mime }],
    }});
    glb.json["extensionsRequired"] = json!(["EXT_lights_ies"]);
    let light = json!({ "light": 0, "multiplier": 2, "color": [1, 0.5, 0] });
    // Half a turn about x: the node's -z is the world's +z, its +y the world's -y.
    glb.root(json!({
        "name": "lamp", "rotation": [1, 0, 0, 0], "translation": [1, 2, 3], "scale": [2, 2, 2],
        "extensions": { "EXT_lights_ies": light },
    }));
    let scene = glb.load().unwrap();
    assert_eq!(scene.own_light_names(), ["lamp"]);
    let LightSource::Goniometric(light) = &scene.lights[0].source else {
        panic!("{:?}", scene.lights);
    };
    assert_eq!(light.position(), Some(Vec3::new(1.0, 2.0, 3.0)));
    let axis = light.intensity_in(Vec3::Z);
    assert!((axis - Vec3::new(2.0, 1.0, 0.0)).length() < 1e-5, "{axis}");
    let level = |x: f32, y: f32| {
        let direction = Vec3::new(x, y, 1e-3).normalize();
        light.intensity_in(direction).x * 683.0 / 2.0
    };
    for (want, found) in [
        (1.0, level(1.0, 0.0)),
        (2.0, level(0.0, -1.0)),
        (3.0, level(-1.0, 0.0)),
        (4.0, level(0.0, 1.0)),
    ] {
        assert!((found - want).abs() < 0.2, "{found} {want}");
    }
    let node = scene_node(&glb);
    for (light, words) in [
        (json!({ "light": 1 }), "no such profile"),
        (json!({}), "no index"),
        (json!({ "light": 0, "multiplier": -1 }), "none negative"),
    ] {
        glb.json["nodes"][node]["extensions"]["EXT_lights_ies"] = light;
        let message = glb.refused();
        assert!(message.contains(words), "{message}");
    }
}

/// The last node.
fn scene_node(glb: &Glb) -> usize {
    glb.json["nodes"].as_array().unwrap().len() - 1
}
