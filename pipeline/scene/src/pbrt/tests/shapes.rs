//! What shapes become.

use super::super::reader::Reader;
use super::{TRIANGLE, warnings, world_v3, world_v4};
use crate::Scene;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;

fn area(scene: &Scene) -> f64 {
    (0..scene.triangles.len())
        .map(|i| scene.triangle_area(i))
        .sum()
}

#[test]
fn quadrics_by_area() {
    // 64 steps around leave a polygon of area cos and sin (pi/64)-ish below the circle's.
    for (shape, exact) in [
        ("\"sphere\" \"float radius\" 2", 16.0 * PI),
        (
            "\"sphere\" \"float zmin\" -0.5 \"float zmax\" 0.25",
            2.0 * PI * 0.75,
        ),
        (
            "\"disk\" \"float radius\" 2 \"float innerradius\" 1",
            3.0 * PI,
        ),
        ("\"disk\" \"float phimax\" 90", PI / 4.0),
        (
            "\"cylinder\" \"float radius\" 0.5 \"float zmin\" 0 \"float zmax\" 3",
            3.0 * PI,
        ),
        ("\"cone\" \"float height\" 2", 5f64.sqrt() * PI),
        ("\"paraboloid\"", PI / 6.0 * (5f64.powf(1.5) - 1.0)),
    ] {
        let scene = world_v4(&format!("Shape {shape}")).unwrap();
        let short = 1.0 - area(&scene) / exact;
        assert!(short > 0.0 && short < 0.01, "{shape} {short}");
        assert!(warnings(&scene).contains("becomes triangles"));
    }
}

/// "uv" and "st", as pairs or plain numbers; default coordinates only where a texture is.
#[test]
fn texture_coordinates() {
    for uv in [
        "\"point2 uv\"",
        "\"float uv\"",
        "\"float st\"",
        "\"point2 st\"",
    ] {
        let scene = world_v3(&format!("{TRIANGLE} {uv} [0 0 .5 0 1 1]")).unwrap();
        assert_eq!(scene.uvs, [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::ONE]);
    }
    let scene = world_v3(TRIANGLE).unwrap();
    assert_eq!(scene.uvs, [Vec2::ZERO; 3]);
    assert_eq!(scene.normals, [Vec3::ZERO; 3]);
}

#[test]
fn bilinear_patches_and_subdivision_cages() {
    let square = "[0 0 0 1 0 0 0 1 0 1 1 0]";
    let scene = world_v4(&format!("Shape \"bilinearmesh\" \"point3 P\" {square}")).unwrap();
    assert_eq!(scene.triangles.len(), 2);
    assert!((area(&scene) - 1.0).abs() < 1e-12);
    assert!((0..2).all(|i| super::normal(&scene, i) == Vec3::Z));
    assert!(warnings(&scene).contains("two triangles each"));
    let scene = world_v4(
        "Shape \"loopsubdiv\" \"integer levels\" 3 \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
    )
    .unwrap();
    assert_eq!(scene.triangles.len(), 1);
    assert!(warnings(&scene).contains("control mesh"));
}

#[test]
fn shapes_that_are_not_there() {
    let text = format!(
        "{TRIANGLE} \"float alpha\" 0 \n{TRIANGLE} \"float alpha\" 1\nMaterial \"interface\"\n{TRIANGLE}"
    );
    let scene = world_v4(&text).unwrap();
    assert_eq!(scene.triangles.len(), 1);
    let text = warnings(&scene);
    assert!(
        text.contains("alpha") && text.contains("interface of media"),
        "{text}"
    );
    let scene = world_v4(&format!("{TRIANGLE} \"float alpha\" .5")).unwrap();
    assert!(warnings(&scene).contains("the shape is opaque"));
}

/// The same warning at several places is listed once, with their number.
#[test]
fn warnings_are_gathered() {
    let scene = world_v4(&"Shape \"sphere\"\n".repeat(3)).unwrap();
    let text = warnings(&scene);
    assert!(
        text.contains("scene.pbrt:3:1") && text.contains("at 2 more places"),
        "{text}"
    );
    assert_eq!(scene.warnings.len(), 2, "{text}");
}

/// `Attribute` gives defaults to the shapes of its block; a shape's own come first.
#[test]
fn attribute_defaults() {
    let scene = world_v4(
        "AttributeBegin Attribute \"shape\" \"float radius\" 2 Shape \"disk\" \
         Shape \"disk\" \"float radius\" 3 AttributeEnd Shape \"disk\"",
    )
    .unwrap();
    let summary = scene.summary();
    let near: Vec<bool> = summary
        .objects
        .iter()
        .zip([4.0, 9.0, 1.0])
        .map(|(object, r2)| (object.area / (PI * r2) - 1.0).abs() < 0.01)
        .collect();
    assert_eq!(near, [true; 3]);
}

/// A hostile number of instances is refused where it passes the limit.
#[test]
fn too_many_triangles() {
    let text = format!(
        "WorldBegin ObjectBegin \"o\" {} ObjectEnd\n{}",
        TRIANGLE.repeat(10),
        "ObjectInstance \"o\"\n".repeat(10)
    );
    let read = |limit: usize| {
        let path = std::path::Path::new("scene.pbrt");
        let mut reader = Reader::new(path);
        reader.max_triangles = limit;
        let result = reader.main_text(path, text.as_bytes());
        result.map_err(|fault| reader.files.error(fault).to_string())
    };
    assert_eq!(read(110), Ok(()));
    // The object's own 10, then instances: the tenth passes 109 on line 11.
    let message = read(109).unwrap_err();
    assert!(
        message.contains("scene.pbrt:11:") && message.contains("simplify the scene"),
        "{message}"
    );
}

/// Deep nesting is refused, not followed into a stack overflow.
#[test]
fn deep_blocks() {
    let (.., message) = super::syntax(world_v4(&"AttributeBegin ".repeat(20_000)));
    assert!(message.contains("nested more than"), "{message}");
}
