//! Lights of every kind in an exported scene.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use glam::{Mat3, Vec2, Vec3};
use rrf_lights::{
    DistantLight, Environment, EnvironmentMap, Falloff, GoniometricLight, Mapping, OwnLight,
    PointLight, Profile, SpotLight,
};
use rrf_scene::{INVALID, LightSource, Material, Scene};

fn scene() -> Scene {
    let texels = vec![Vec3::ONE, 2.0 * Vec3::ONE];
    let map = EnvironmentMap::new((2, 1), texels, Mapping::LatLong, Mat3::IDENTITY).unwrap();
    let point = PointLight {
        position: Vec3::Y,
        intensity: Vec3::new(1.0, 2.0, 3.0),
    };
    let sources: [LightSource; 5] = [
        point.into(),
        DistantLight::sun(Vec3::Y, Vec3::ONE).into(),
        SpotLight {
            position: Vec3::Y,
            axis: Vec3::NEG_Y,
            intensity: Vec3::ONE,
            inner: 0.25,
            outer: 0.5,
            falloff: Falloff::Squared,
        }
        .into(),
        GoniometricLight {
            position: Vec3::Y,
            intensity: Vec3::ONE,
            profile: Profile::Picture(map.clone()),
        }
        .into(),
        Environment {
            radiance: Vec3::new(1.0, 0.5, 0.25),
            ..Environment::of_map(map)
        }
        .into(),
    ];
    let named = |(k, source): (usize, LightSource)| OwnLight {
        name: format!("light{k}"),
        source,
    };
    Scene {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        normals: vec![Vec3::ZERO; 3],
        uvs: vec![Vec2::ZERO; 3],
        triangles: vec![[0, 1, 2]],
        triangle_material: vec![0],
        triangle_light: vec![INVALID],
        triangle_object: vec![0],
        objects: vec!["floor".into()],
        materials: vec![Material::lambert("grey", Vec3::splat(0.5))],
        lights: sources.into_iter().enumerate().map(named).collect(),
        ..Scene::default()
    }
}

#[test]
fn every_kind_is_written_and_the_sky_as_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let more = PointLight {
        position: Vec3::X,
        intensity: Vec3::splat(7.0),
    };
    let scene = scene();
    let notes = rrf_export::mitsuba::write_mitsuba(folder.path(), &scene, None, &[more]).unwrap();
    let xml = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    for (kind, count) in [("point", 3), ("directional", 1), ("spot", 1), ("envmap", 1)] {
        let emitter = format!("<emitter type=\"{kind}\">");
        assert_eq!(xml.matches(&emitter).count(), count, "{kind}: {xml}");
    }
    assert!(xml.contains("textures/light4.exr"), "{xml}");
    for name in ["light1", "light2", "light3"] {
        let said = notes.iter().any(|note| note.contains(name));
        assert!(said, "{name}: {notes:?}");
    }
    let sky = exr::prelude::read_first_rgba_layer_from_file(
        folder.path().join("textures/light4.exr"),
        |size, _| vec![Vec3::ZERO; size.area()],
        |texels: &mut Vec<Vec3>, at, (r, g, b, _): (f32, f32, f32, f32)| {
            texels[at.x()] = Vec3::new(r, g, b);
        },
    );
    let sky = sky.unwrap().layer_data.channel_data.pixels;
    assert_eq!(sky, [Vec3::new(1.0, 0.5, 0.25), Vec3::new(2.0, 1.0, 0.5)]);
}
