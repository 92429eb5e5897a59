//! Parameters of glass that make no sense, or little: each is read in a stated way or refused with its
//! name.

use crate::glb::Glb;
use crate::gltf_materials::{square, with_material};
use crate::support::warns;
use glam::Vec3;
use rrf_materials::{Bsdf, DIELECTRIC, PRINCIPLED};
use serde_json::{Value, json};

fn glass(ior: f32, alpha_mode: &str) -> Value {
    json!({
        "alphaMode": alpha_mode,
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.4 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 0.1 },
            "KHR_materials_ior": { "ior": ior },
        },
    })
}

/// An index of 1 makes glass that neither bends nor reflects, however rough; 0 means infinite, and
/// light does not enter.
#[test]
fn indices_of_one_and_nought() {
    let scene = with_material(glass(1.0, "OPAQUE"));
    let clear = Bsdf::of(&scene.materials[0]);
    assert_eq!(clear.kind, &DIELECTRIC);
    let v = Vec3::new(0.6, 0.0, 0.8);
    for lobe in [0.0, 0.5, 0.99] {
        let through = clear.sample(Vec3::Z, v, [lobe, 0.5, 0.5]);
        assert!(through.l.abs_diff_eq(-v, 1e-6) && through.weight == Vec3::ONE);
    }
    assert!(!warns(&scene, "refraction"), "{:?}", scene.warnings);
    let scene = with_material(glass(0.0, "OPAQUE"));
    assert_eq!(scene.materials[0].kind, &PRINCIPLED);
    assert!(warns(&scene, "index of refraction of 0"));
}

#[test]
fn indices_below_one_are_refused() {
    for ior in [-1.5, 0.5] {
        let mut glb = Glb::new();
        let material = glb.push("materials", glass(ior, "OPAQUE"));
        square(&mut glb, Some(material));
        let message = glb.load().unwrap_err().to_string();
        assert!(
            message.contains(&format!(
                "index of refraction {ior} must be 0 or at least 1"
            )),
            "{message}"
        );
    }
}

#[test]
fn an_unknown_alpha_mode_is_refused() {
    let mut glb = Glb::new();
    let material = glb.push("materials", glass(1.5, "GLASS"));
    square(&mut glb, Some(material));
    let message = glb.load().unwrap_err().to_string();
    assert!(message.contains("alphaMode: Invalid value"), "{message}");
}

/// A lost picture of roughness leaves the factor, and of metalness nothing, with a warning.
#[test]
fn a_lost_texture_of_roughness_leaves_the_factor() {
    let mut glb = Glb::new();
    let image = glb.push("images", json!({ "uri": "gone.png" }));
    let texture = glb.push("textures", json!({ "source": image }));
    let material = glb.push(
        "materials",
        json!({ "pbrMetallicRoughness": {
            "roughnessFactor": 0.3, "metallicRoughnessTexture": { "index": texture } } }),
    );
    square(&mut glb, Some(material));
    let scene = glb.load().unwrap();
    let material = &scene.materials[0];
    assert_eq!((material.roughness, material.metallic), (0.3, 0.0));
    assert!(warns(&scene, "gone.png"), "{:?}", scene.warnings);
}
