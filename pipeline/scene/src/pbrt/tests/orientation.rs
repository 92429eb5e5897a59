//! Which side of a triangle is its front: pbrt's surface normal.

use super::{normal, read_bytes, warnings, world_v3, world_v4};
use crate::Scene;
use glam::Vec3;

/// A tetrahedron, outward in a right-handed reading; its signed volume is 1/6.
const TETRAHEDRON: &str = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \
     \"integer indices\" [0 2 1  0 1 3  0 3 2  1 2 3]";

fn volume(scene: &Scene) -> f64 {
    (0..scene.triangles.len())
        .map(|i| {
            let [a, b, c] = scene.corners(i).unwrap().map(|p| p.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// Without normals: a mirror keeps the outside outside (pbrt turns the normal twice), and
/// `ReverseOrientation` turns it, twice not at all.
#[test]
fn meshes_without_normals() {
    for (before, sign) in [
        ("", 1.0),
        ("Scale -1 1 1", 1.0),
        ("Scale -1 -1 1", 1.0),
        ("Rotate 77 1 2 3 Scale 1 1 -1", 1.0),
        ("ReverseOrientation", -1.0),
        ("ReverseOrientation ReverseOrientation", 1.0),
        ("Scale 1 -1 1 ReverseOrientation", -1.0),
        ("Transform [0 1 0 0 1 0 0 0 0 0 1 0 5 6 7 1]", 1.0),
    ] {
        let text = format!("{before} {TETRAHEDRON}");
        for scene in [world_v3(&text).unwrap(), world_v4(&text).unwrap()] {
            let found = volume(&scene);
            assert!((found - sign / 6.0).abs() < 1e-6, "{before}: {found}");
        }
    }
}

/// With normals: the triangle turns to their side whatever its winding and transform;
/// `ReverseOrientation` turns the normals in version 4 and has no effect in version 3.
#[test]
fn meshes_with_normals() {
    for indices in ["0 1 2", "0 2 1"] {
        for nz in [1.0, -1.0] {
            let shape = format!(
                "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \
                 \"integer indices\" [{indices}] \"normal N\" [0 0 {nz} 0 .1 {nz} .1 0 {nz}]"
            );
            for (before, v3, v4) in [
                ("", 1.0, 1.0),
                ("Scale -1 1 1", 1.0, 1.0),
                ("Scale 1 1 -1", -1.0, -1.0),
                ("ReverseOrientation", 1.0, -1.0),
                ("Scale 1 1 -1 ReverseOrientation", -1.0, 1.0),
            ] {
                let text = format!("{before} {shape}");
                for (scene, side) in [(world_v3(&text), v3), (world_v4(&text), v4)] {
                    let scene = scene.unwrap();
                    let wanted = Vec3::Z * (nz * side) as f32;
                    assert!((normal(&scene, 0) - wanted).length() < 1e-6, "{text}");
                    assert!(scene.normals[0].dot(wanted) > 0.99, "{text}");
                    assert!((scene.normals[1].length() - 1.0).abs() < 1e-6);
                }
            }
        }
    }
}

/// Normals follow the inverse transpose: on a plane stretched along x they stay normal to it.
#[test]
fn normals_of_a_stretched_plane() {
    let scene = world_v4(
        "Scale 3 1 1 Shape \"trianglemesh\" \"point3 P\" [1 0 0 0 1 0 0 0 1] \
         \"normal N\" [1 1 1 1 1 1 1 1 1]",
    )
    .unwrap();
    for vertex in &scene.normals {
        assert!((*vertex - normal(&scene, 0)).length() < 1e-6);
    }
}

/// A sphere is wound outwards, also mirrored, and inwards by `ReverseOrientation`.
#[test]
fn spheres() {
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    for (before, sign) in [
        ("", 1.0),
        ("Scale 1 1 -1", 1.0),
        ("ReverseOrientation", -1.0),
        ("Scale -1 1 1 ReverseOrientation", -1.0),
    ] {
        for scene in [
            world_v3(&format!("{before} Shape \"sphere\"")),
            world_v4(&format!("{before} Shape \"sphere\"")),
        ] {
            let scene = scene.unwrap();
            let found = volume(&scene) * sign;
            assert!(found > 0.99 * exact && found < exact, "{before}: {found}");
            let outward =
                |i: usize| scene.normals[i].dot(scene.positions[i].normalize()) * sign as f32;
            assert!(
                (0..scene.positions.len()).all(|i| outward(i) > 0.999),
                "{before}"
            );
        }
    }
}

/// An instance's transform keeps the outside that the object had.
#[test]
fn instances() {
    let text = format!(
        "ObjectBegin \"t\" Scale 2 1 1 {TETRAHEDRON} ObjectEnd \
         ObjectInstance \"t\" \
         AttributeBegin Translate 10 0 0 Scale 1 -3 1 ObjectInstance \"t\" AttributeEnd"
    );
    let scene = world_v4(&text).unwrap();
    assert_eq!((scene.triangles.len(), scene.objects.len()), (8, 2));
    assert!(
        (volume(&scene) - (2.0 + 6.0) / 6.0).abs() < 1e-5,
        "{}",
        volume(&scene)
    );
    let bounds = scene.bounds().unwrap();
    assert_eq!(
        (bounds.min, bounds.max),
        ([0.0, -3.0, 0.0], [12.0, 1.0, 1.0])
    );
}

#[test]
fn flattening_transforms_are_refused() {
    let (line, column, message) = super::syntax(world_v4(&format!("Scale 1 0 1\n{TETRAHEDRON}")));
    assert_eq!((line, column), (4, 1));
    assert!(message.contains("determinant is 0"));
}

/// Cameras: `LookAt` by hand, a mirror, and named systems.
#[test]
fn cameras() {
    let camera = |options: &str| {
        let text = format!("{options} WorldBegin {}", super::TRIANGLE);
        let scene = read_bytes(text.as_bytes()).unwrap();
        (scene.cameras[0].clone(), warnings(&scene))
    };
    let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-6, "{a} {b}");
    let (seen, _) = camera("LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\"");
    near(seen.eye, Vec3::new(0.0, 0.0, 5.0));
    near(seen.forward, Vec3::NEG_Z);
    near(seen.right, Vec3::NEG_X);
    assert_eq!((seen.fov, seen.width, seen.height), (90.0, 1280, 720));
    let (seen, _) =
        camera("Scale -1 1 1 LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 30");
    near(seen.right, Vec3::X);
    let (seen, text) = camera(
        "Scale 2 2 2 Translate 1 2 3 Camera \"perspective\" \"float screenwindow\" [-1 1 -1 1]",
    );
    near(seen.eye, Vec3::new(-1.0, -2.0, -3.0));
    near(seen.forward, Vec3::Z);
    assert!(text.contains("screenwindow"));
    let (_, text) = camera("Transform [1 0 0 0 .5 1 0 0 0 0 1 0 0 0 0 1] Camera \"perspective\"");
    assert!(text.contains("made square"), "{text}");
    // The camera's own system puts a triangle in front of it.
    let text = format!(
        "Translate 0 0 7 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" Translate 0 0 2 {}",
        super::TRIANGLE
    );
    let scene = read_bytes(text.as_bytes()).unwrap();
    near(scene.positions[0], Vec3::new(0.0, 0.0, -5.0));
}
