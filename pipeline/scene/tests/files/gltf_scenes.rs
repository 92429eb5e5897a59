//! The repository's glTF scenes, and files of Blender's exporter.

use crate::support::{edge_cross, notes, repository};
use glam::Vec3;
use rrf_materials::{LAMBERT, PRINCIPLED};
use rrf_scene::{INVALID, LightUnits, LoadOptions, Scene, load};
use std::f64::consts::PI;

fn total_area(scene: &Scene, material: &str) -> f64 {
    (0..scene.triangles.len())
        .filter(|&t| scene.materials[scene.triangle_material[t] as usize].name == material)
        .map(|t| f64::from(edge_cross(scene, t).length()) / 2.0)
        .sum()
}

#[test]
fn glossy_cornell_box_has_its_materials() {
    let path = repository("scenes/cornell-glossy/cornell-glossy.glb");
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(scene.triangles.len(), 34);
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);
    assert!(scene.lights.is_empty() && scene.area_lights.is_empty());
    assert!(scene.triangle_light.iter().all(|&light| light == INVALID));
    let grey = Vec3::new(0.725, 0.71, 0.68);
    for (name, colour, roughness, metallic) in [
        ("Floor", grey, 0.25, 0.0),
        ("Ceiling", grey, 0.9, 0.0),
        ("BackWall", grey, 0.4, 1.0),
        ("RightWall", Vec3::new(0.14, 0.45, 0.091), 0.9, 0.0),
        ("LeftWall", Vec3::new(0.63, 0.065, 0.05), 0.9, 0.0),
        ("ShortBox", grey, 0.35, 0.0),
        ("TallBox", grey, 0.2, 1.0),
    ] {
        let material = scene.materials.iter().find(|m| m.name == name).unwrap();
        assert_eq!(material.kind, &PRINCIPLED);
        assert_eq!(material.base_color, colour, "{name}");
        assert_eq!(
            (material.roughness, material.metallic),
            (roughness, metallic),
            "{name}"
        );
        assert_eq!(material.specular, 0.5);
    }
}

/// The corners of every triangle, each triangle and the list in a fixed order.
fn sorted_triangles(scene: &Scene, keep: impl Fn(usize) -> bool) -> Vec<[[f32; 3]; 3]> {
    let order = |a: &[f32; 3], b: &[f32; 3]| {
        // To the centimetre: the files round differently.
        let key = |p: &[f32; 3]| p.map(|x| (x * 100.0).round() as i32);
        key(a).cmp(&key(b))
    };
    let mut all: Vec<[[f32; 3]; 3]> = (0..scene.triangles.len())
        .filter(|&t| keep(t))
        .map(|t| {
            let mut corners = scene.triangles[t].map(|v| scene.positions[v as usize].to_array());
            corners.sort_by(order);
            corners
        })
        .collect();
    all.sort_by(|a, b| {
        let pairs = a.iter().zip(b).map(|(a, b)| order(a, b));
        pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    all
}

#[test]
fn glossy_cornell_box_is_the_pbrt_one_without_its_light() {
    let read = |path: &str| load(&repository(path), &LoadOptions::default()).unwrap();
    let glossy = read("scenes/cornell-glossy/cornell-glossy.glb");
    let pbrt = read("scenes/cornell-box/scene.pbrt");
    assert_eq!(pbrt.triangles.len(), 36);
    let is_dark = |t: usize| pbrt.triangle_light[t] == INVALID;
    let (got, want) = (
        sorted_triangles(&glossy, |_| true),
        sorted_triangles(&pbrt, is_dark),
    );
    assert_eq!((got.len(), want.len()), (34, 34));
    for (got, want) in got.iter().flatten().zip(want.iter().flatten()) {
        let error = (Vec3::from_array(*got) - Vec3::from_array(*want)).abs();
        // Six digits in the pbrt file, of numbers up to 2.
        assert!(error.max_element() < 1e-6, "{got:?}, not {want:?}");
    }
    for name in [
        "Floor",
        "Ceiling",
        "BackWall",
        "RightWall",
        "LeftWall",
        "ShortBox",
        "TallBox",
    ] {
        let (got, want) = (total_area(&glossy, name), total_area(&pbrt, name));
        assert!(
            got > 0.9 && (got / want - 1.0).abs() < 1e-6,
            "{name}: {got}, not {want}"
        );
    }
}

#[test]
fn zdm2_is_read_with_a_default_material() {
    let path = repository("scenes/zdm2/zdm2.glb");
    let options = LoadOptions {
        default_albedo: 0.5,
        ..LoadOptions::default()
    };
    let scene = load(&path, &options).unwrap();
    // 1,134 of the file's 58,772 triangles have their corners on a line.
    assert_eq!(scene.triangles.len(), 58_772 - 1_134);
    assert_eq!(scene.normals.len(), scene.positions.len());
    assert_eq!(scene.uvs.len(), scene.positions.len());
    let notes = notes(&scene);
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert_eq!(notes[0].place, "1 primitives");
    assert!(notes[0].message.contains("0.5"));
    assert!(notes[1].message.starts_with("1134 triangles without area"));
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].kind, &LAMBERT);
    assert_eq!(scene.materials[0].base_color, Vec3::splat(0.5));
    // The node turns the level's z (bounds stated in the file) up into -y ... y into z.
    let lowest = scene.positions.iter().copied().reduce(Vec3::min).unwrap();
    let highest = scene.positions.iter().copied().reduce(Vec3::max).unwrap();
    let want = (
        Vec3::new(-33.879_49, -11.968_341, -29.290_272),
        Vec3::new(43.320_522, 23.983_78, 30.309_72),
    );
    assert!((lowest - want.0).abs().max_element() < 1e-4, "{lowest}");
    assert!((highest - want.1).abs().max_element() < 1e-4, "{highest}");
}

#[test]
fn a_blender_light_is_the_same_in_all_modes_of_the_exporter() {
    let read = |name: &str, light_units| {
        let path = repository("pipeline/scene/tests/data/blender-light").join(name);
        let options = LoadOptions {
            light_units,
            ..LoadOptions::default()
        };
        load(&path, &options).unwrap()
    };
    // 100 W over the sphere, colour (1, 0.8, 0.6).
    let want = Vec3::new(1.0, 0.8, 0.6) * (100.0 / (4.0 * PI)) as f32;
    for (name, units) in [
        ("blend_SPEC.glb", LightUnits::Spec),
        ("blend_COMPAT.glb", LightUnits::Compat),
        ("blend_RAW.glb", LightUnits::Raw),
    ] {
        let scene = read(name, units);
        assert_eq!(scene.lights.len(), 1);
        let light = scene.points().next().unwrap();
        assert_eq!(light.position, Vec3::new(0.0, 2.0, 0.0));
        // Two roundings to f32 in the file, one here.
        let error = (light.intensity / want - 1.0).abs().max_element();
        assert!(error <= 3.0 * f32::EPSILON, "{name}: {}", light.intensity);
    }
    // The wrong mode is off by its factor: nothing is guessed.
    let wrong = read("blend_RAW.glb", LightUnits::Spec)
        .points()
        .next()
        .unwrap();
    assert!((wrong.intensity.x - 100.0 / 683.0).abs() < 1e-6);
}

#[test]
fn a_blender_camera_and_its_cubes_are_placed() {
    let path = repository("pipeline/scene/tests/data/blender-light/blend_SPEC.glb");
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(scene.objects, ["floor", "blk"]);
    let camera = &scene.cameras[0];
    assert_eq!(camera.eye, Vec3::new(0.0, 2.0, 6.0));
    // Turned down by 15 degrees about x.
    let (sin, cos) = 15_f32.to_radians().sin_cos();
    assert!((camera.forward - Vec3::new(0.0, -sin, -cos)).length() < 1e-6);
    assert!((camera.right - Vec3::X).length() < 1e-6);
    assert_eq!((camera.width, camera.height), (1024, 576));
    assert!((camera.fov - 0.399_596_5_f32.to_degrees()).abs() < 1e-4);
    // The floor is a unit cube scaled by (4, 0.1, 4) at y = -1.
    let floor = scene.triangles.iter().zip(&scene.triangle_object);
    let floor = floor.filter(|(_, object)| **object == 0);
    for position in floor.flat_map(|(t, _)| t.map(|v| scene.positions[v as usize])) {
        let unit = (position - Vec3::new(0.0, -1.0, 0.0)) / Vec3::new(4.0, 0.1, 4.0);
        assert!((unit.abs() - 0.5).abs().max_element() < 1e-5, "{position}");
    }
}
