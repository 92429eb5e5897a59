//! Bitterli's Cornell box: what stands in the file, read by eye from its text.

use super::read_bytes;
use crate::{LoadOptions, Scene, SceneError, load};
use glam::{DVec2, DVec3, Vec3};
use rrf_materials::LAMBERT;
use std::path::{Path, PathBuf};

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt")
}

fn cornell() -> Scene {
    load(&path(), &LoadOptions::default()).unwrap()
}

/// Triangles of the material with this name.
fn triangles_of(scene: &Scene, name: &str) -> Vec<usize> {
    let material = scene.materials.iter().position(|m| m.name == name).unwrap() as u32;
    (0..scene.triangles.len())
        .filter(|&i| scene.triangle_material[i] == material)
        .collect()
}

#[test]
fn counts_and_materials() {
    let scene = cornell();
    assert_eq!(scene.triangles.len(), 36);
    assert_eq!(scene.objects.len(), 8);
    let grey = [0.725, 0.71, 0.68];
    for (name, count, color) in [
        ("LeftWall", 2, [0.63, 0.065, 0.05]),
        ("RightWall", 2, [0.14, 0.45, 0.091]),
        ("Floor", 2, grey),
        ("Ceiling", 2, grey),
        ("BackWall", 2, grey),
        ("ShortBox", 12, grey),
        ("TallBox", 12, grey),
        ("Light", 2, [0.0; 3]),
    ] {
        let triangles = triangles_of(&scene, name);
        assert_eq!(triangles.len(), count, "{name}");
        let material = &scene.materials[scene.triangle_material[triangles[0]] as usize];
        assert_eq!(material.kind, &LAMBERT);
        assert_eq!(material.base_color, Vec3::from_array(color), "{name}");
    }
    // One thing is not as in pbrt: the file bounds its paths.
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].message.contains("maxdepth 5"));
    assert!(scene.warnings[0].place.ends_with("scene.pbrt:1:1"));
}

#[test]
fn camera_looks_into_the_room_from_its_open_side() {
    let scene = cornell();
    let [camera] = scene.cameras.as_slice() else {
        panic!()
    };
    assert_eq!(camera.eye, Vec3::new(0.0, 1.0, 6.8));
    assert_eq!(camera.forward, Vec3::NEG_Z);
    assert_eq!(camera.up, Vec3::Y);
    assert_eq!(camera.right, Vec3::X);
    assert_eq!(
        (camera.fov, camera.width, camera.height),
        (19.5, 1024, 1024)
    );
}

#[test]
fn light_shines_down() {
    let scene = cornell();
    assert_eq!(scene.area_lights.len(), 1);
    assert_eq!(scene.area_lights[0].radiance, Vec3::new(17.0, 12.0, 4.0));
    assert!(!scene.area_lights[0].two_sided);
    let lit: Vec<usize> = (0..36).filter(|&i| scene.triangle_light[i] == 0).collect();
    assert_eq!(lit, triangles_of(&scene, "Light"));
    for &i in &lit {
        assert!((super::normal(&scene, i) - Vec3::NEG_Y).length() < 1e-6);
    }
    let area: f64 = lit.iter().map(|&i| scene.triangle_area(i)).sum();
    assert!((area - 0.47 * 0.38).abs() < 1e-7, "{area}");
}

/// The boxes are closed: their volume by the divergence theorem is their base (shoelace
/// formula over the corners in the file) times their height, with normals outwards.
#[test]
fn boxes_are_wound_outwards() {
    let scene = cornell();
    let short = [
        [-0.0460751, 0.573007],
        [0.124253, 0.00310463],
        [0.703337, 0.176177],
        [0.533009, 0.746079],
    ];
    let tall = [
        [-0.720444, -0.473882],
        [-0.146892, -0.673479],
        [0.0495656, -0.108948],
        [-0.523986, 0.0906493],
    ];
    for (name, base, height) in [("ShortBox", short, 0.6), ("TallBox", tall, 1.2)] {
        let base = base.map(DVec2::from_array);
        let shoelace: f64 = (0..4)
            .map(|i| base[i].perp_dot(base[(i + 1) % 4]))
            .sum::<f64>()
            / 2.0;
        let volume: f64 = triangles_of(&scene, name)
            .iter()
            .map(|&i| {
                let [a, b, c] = scene.corners(i).unwrap().map(|p| p.as_dvec3());
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!(
            (volume / (shoelace.abs() * height) - 1.0).abs() < 1e-5,
            "{name} {volume}"
        );
    }
}

/// Each triangle's normal is on its vertices' normals' side, as in pbrt.
#[test]
fn winding_follows_the_normals_of_the_file() {
    let scene = cornell();
    for (i, triangle) in scene.triangles.iter().enumerate() {
        let shading: DVec3 = triangle
            .iter()
            .map(|&v| scene.normals[v as usize].as_dvec3())
            .sum();
        assert!(
            super::normal(&scene, i).as_dvec3().dot(shading / 3.0) > 0.999,
            "triangle {i}"
        );
    }
    let bounds = scene.bounds().unwrap();
    let near =
        |a: [f32; 3], b: [f32; 3]| (Vec3::from_array(a) - Vec3::from_array(b)).length() < 1e-6;
    assert!(near(bounds.min, [-1.0, 0.0, -1.0]) && near(bounds.max, [1.0, 2.0, 1.0]));
}

/// Cut anywhere before the end of `WorldEnd`, the file is refused with a place inside it.
#[test]
fn truncated_at_every_byte() {
    let bytes = std::fs::read(path()).unwrap();
    let whole = String::from_utf8(bytes.clone()).unwrap().trim_end().len();
    let lines = bytes.iter().filter(|&&byte| byte == b'\n').count() as u32 + 1;
    for end in 0..whole {
        match read_bytes(&bytes[..end]) {
            Err(SceneError::Syntax {
                line,
                column,
                message,
                ..
            }) => {
                assert!((1..=lines).contains(&line) && column >= 1 && !message.is_empty());
            }
            other => panic!("cut at {end}: {other:?}"),
        }
    }
    assert!(read_bytes(&bytes[..whole]).is_ok());
}
