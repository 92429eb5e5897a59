//! The summary, for programs and for people.

use super::{material, square};
use crate::Warning;
use glam::Vec3;
use rrf_materials::LAMBERT;

#[test]
fn summary_for_programs() {
    let mut scene = square();
    scene.warnings.push(Warning {
        place: "a:1:2".into(),
        message: "b".into(),
    });
    let json = serde_json::to_value(scene.summary()).unwrap();
    for (pointer, value) in [
        ("/triangles", serde_json::json!(2)),
        ("/area", serde_json::json!(1.0)),
        ("/bounds/max", serde_json::json!([1.0, 1.0, 0.0])),
        ("/materials/0/kind", serde_json::json!("lambert")),
        ("/materials/0/roughness", serde_json::json!(null)),
        ("/materials/1/roughness", serde_json::json!(0.5)),
        ("/materials/1/textures", serde_json::json!([0, null, null])),
        ("/objects/0/triangles", serde_json::json!(2)),
        ("/lights/0/name", serde_json::json!("bulb")),
        ("/lights/0/kind", serde_json::json!("point")),
        ("/area_lights/0/name", serde_json::json!("panel")),
        ("/area_lights/0/two_sided", serde_json::json!(true)),
        ("/area_lights/0/area", serde_json::json!(0.5)),
        ("/cameras/0/mirrored", serde_json::json!(false)),
        ("/warnings/0/place", serde_json::json!("a:1:2")),
        ("/hash", serde_json::json!(scene.hash_hex())),
    ] {
        assert_eq!(json.pointer(pointer), Some(&value), "{pointer}");
    }
    // Both sides of half a square metre: pi * 0.5 * 2 * radiance.
    let power = json
        .pointer("/area_lights/0/power/1")
        .unwrap()
        .as_f64()
        .unwrap();
    assert!((power - 2.0 * std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn summary_for_people() {
    let mut scene = square();
    scene.cameras[0].right = Vec3::NEG_X;
    scene.warnings.push(Warning {
        place: "a:1:2".into(),
        message: "left out".into(),
    });
    scene.materials = (0..50)
        .map(|i| material(&format!("m{i}"), &LAMBERT))
        .collect();
    let text = scene.summary().to_string();
    for words in [
        "triangles    2 (4 vertices)",
        "bounds       0 0 0 to 1 1 0",
        "m39",
        "and 10 more",
        "mirrored",
        "a:1:2: left out",
        "W/sr",
        &scene.hash_hex(),
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("m40"));
}
