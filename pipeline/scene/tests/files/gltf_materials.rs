//! Materials and textures of glTF files built here.

use crate::glb::{Glb, png};
use crate::support::{notes, warns};
use glam::{Vec2, Vec3};
use rrf_materials::{DIELECTRIC, PRINCIPLED, ROUGH_DIELECTRIC, THIN_DIELECTRIC};
use rrf_scene::{LoadOptions, Scene, load};
use serde_json::{Value, json};

/// Upper left red, upper right green, lower left blue, lower right grey.
pub const PICTURE: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [188, 188, 188]];

/// A square with glTF's texture coordinates: (0, 0) at its upper left corner.
pub fn square(glb: &mut Glb, material: Option<usize>) {
    let positions = glb.floats(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ]);
    let uvs = glb.floats(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let indices = glb.integers(&[0, 1, 2, 0, 2, 3], 5123);
    let mut primitive = json!({
        "attributes": { "POSITION": positions, "TEXCOORD_0": uvs }, "indices": indices,
    });
    if let Some(material) = material {
        primitive["material"] = json!(material);
    }
    glb.place(primitive, json!({}));
}

pub fn with_material(material: Value) -> Scene {
    let mut glb = Glb::new();
    let material = glb.push("materials", material);
    square(&mut glb, Some(material));
    glb.load().unwrap()
}

/// Colour of texture `id` at the square's (x, y), through the scene's own coordinates.
fn at(scene: &Scene, id: u32, x: f32, y: f32) -> Vec3 {
    let uv = |v: usize| scene.uvs[v];
    let uv = uv(0) + (uv(1) - uv(0)) * x + (uv(3) - uv(0)) * y;
    scene.textures[id as usize].sample(uv)
}

#[test]
fn textures_lie_on_the_surface_as_gltf_says() {
    let mut glb = Glb::new();
    let colour = glb.texture(2, 2, &PICTURE);
    let normal = glb.texture(1, 1, &[[255, 128, 255]]);
    let material = glb.push(
        "materials",
        json!({
            "name": "painted",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0.25, "roughnessFactor": 0.75,
                "baseColorTexture": { "index": colour },
                "metallicRoughnessTexture": { "index": colour },
            },
            "normalTexture": { "index": normal, "scale": 0.5 },
        }),
    );
    square(&mut glb, Some(material));
    let scene = glb.load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);
    let material = &scene.materials[0];
    assert_eq!(
        (material.name.as_str(), material.kind),
        ("painted", &PRINCIPLED)
    );
    assert_eq!(material.base_color, Vec3::new(0.5, 1.0, 1.0));
    assert_eq!(
        (material.metallic, material.roughness, material.specular),
        (0.25, 0.75, 0.5)
    );
    // v grows upwards: the upper left corner is (0, 1).
    assert_eq!(scene.uvs[3], Vec2::new(0.0, 1.0));
    assert_eq!(scene.uvs[1], Vec2::new(1.0, 0.0));
    let base = |x, y| at(&scene, material.base_texture, x, y);
    assert_eq!(base(0.25, 0.75), Vec3::X);
    assert_eq!(base(0.75, 0.75), Vec3::Y);
    assert_eq!(base(0.25, 0.25), Vec3::Z);
    // sRGB 188 is linear 0.5029 (IEC 61966-2-1); as a number it is 188 / 255.
    assert!((base(0.75, 0.25) - 0.502_886).abs().max_element() < 1e-5);
    let mixed = at(&scene, material.roughness_metallic_texture, 0.75, 0.25);
    assert!((mixed - 188.0 / 255.0).abs().max_element() < 1e-6);
    // (1, 1/255, 1) with x and y halved is (0.5, 0.5/255, 1), then made unit.
    let bent = at(&scene, material.normal_texture, 0.3, 0.3) * 2.0 - 1.0;
    let want = Vec3::new(0.5, 0.5 / 255.0, 1.0).normalize();
    assert!((bent - want).abs().max_element() < 1e-6, "{bent}");
}

#[test]
fn a_texture_transform_moves_all_textures_alike() {
    let transform = json!({ "KHR_texture_transform": {
        "offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5],
    }});
    let mut glb = Glb::new();
    let texture = glb.texture(2, 2, &PICTURE);
    let moved = json!({ "index": texture, "extensions": transform });
    let material = glb.push(
        "materials",
        json!({
            "pbrMetallicRoughness": { "baseColorTexture": moved },
            "normalTexture": moved,
        }),
    );
    square(&mut glb, Some(material));
    let scene = glb.load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);
    // The lower left quadrant of the picture (blue), turned clockwise by a quarter: the
    // upper left corner shows the picture's own lower left corner.
    assert!(
        (scene.uvs[3] - Vec2::ZERO).length() < 1e-6,
        "{}",
        scene.uvs[3]
    );
    assert!(
        (scene.uvs[2] - Vec2::new(0.0, 0.5)).length() < 1e-6,
        "{}",
        scene.uvs[2]
    );
    let base = at(&scene, scene.materials[0].base_texture, 0.5, 0.5);
    assert!((base - Vec3::Z).length() < 1e-5, "{base}");

    // One texture elsewhere than the others cannot be followed: said so.
    glb.json["materials"][0]["normalTexture"] = json!({ "index": texture });
    assert!(warns(&glb.load().unwrap(), "different texture coordinates"));
}

#[test]
fn pictures_come_from_views_data_uris_and_files_and_are_shared() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("my pictures")).unwrap();
    let file = png(2, 2, &PICTURE);
    std::fs::write(folder.path().join("my pictures/a.png"), &file).unwrap();
    let mut glb = Glb::new();
    for uri in [
        "my%20pictures/a.png".to_owned(),
        format!("data:image/png;base64,{}", base64(&file)),
    ] {
        let image = glb.push("images", json!({ "uri": uri }));
        let texture = glb.push("textures", json!({ "source": image }));
        let base = json!({ "baseColorTexture": { "index": texture } });
        let material = glb.push("materials", json!({ "pbrMetallicRoughness": base }));
        square(&mut glb, Some(material));
        let again = json!({ "name": "again", "pbrMetallicRoughness": base });
        let material = glb.push("materials", again);
        square(&mut glb, Some(material));
    }
    // The buffer as a file and as a data URI, in a .gltf.
    std::fs::write(folder.path().join("all.bin"), &glb.bin).unwrap();
    for uri in [
        "all.bin".to_owned(),
        format!("data:;base64,{}", base64(&glb.bin)),
    ] {
        glb.json["buffers"] = json!([{ "byteLength": glb.bin.len(), "uri": uri }]);
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, glb.json.to_string()).unwrap();
        let scene = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!((scene.materials.len(), scene.textures.len()), (4, 2));
        assert_eq!(scene.textures[0], scene.textures[1]);
        assert_eq!(scene.textures[0].texels[2], Vec3::Z);
        assert_eq!(scene.triangles.len(), 8);
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0_u32, |bits, i| {
            bits << 8 | u32::from(group.get(i).copied().unwrap_or(0))
        });
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63] as char;
            text.push(if i <= group.len() { digit } else { '=' });
        }
    }
    text
}

#[test]
fn what_is_approximated_is_said() {
    for (material, part) in [
        (
            json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.5 } } }),
            "veil",
        ),
        (
            json!({ "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 } } }),
            "the coat is Mitsuba's",
        ),
        (
            json!({ "extensions": { "KHR_materials_specular": { "specularFactor": 0.5 } } }),
            "specularFactor",
        ),
        (
            json!({ "extensions": { "KHR_materials_specular": {
                "specularColorFactor": [1, 0.5, 0.5] } } }),
            "luminance",
        ),
        (
            json!({ "extensions": { "KHR_materials_ior": { "ior": 2.5 } } }),
            "specular 2.29",
        ),
        (
            json!({ "pbrMetallicRoughness": { "roughnessFactor": 1.5 } }),
            "roughness 1.5",
        ),
    ] {
        let scene = with_material(material);
        assert!(warns(&scene, part), "{part}: {:?}", scene.warnings);
    }
    let mut glb = Glb::new();
    glb.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_lights_punctual"]);
    square(&mut glb, None);
    let colour = glb.floats(&[[1.0, 0.0, 0.0]; 4]);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colour);
    let scene = glb.load().unwrap();
    let places: Vec<_> = notes(&scene).iter().map(|w| w.place.as_str()).collect();
    assert_eq!(
        places,
        ["KHR_materials_unlit", "mesh 0, primitive 0", "1 primitives"]
    );
}

#[test]
fn texture_repetition_is_only_a_warning_where_it_shows() {
    let scene = |scale: f32| {
        let mut glb = Glb::new();
        let texture = glb.texture(2, 2, &PICTURE);
        let sampler = glb.push("samplers", json!({ "wrapS": 33071, "magFilter": 9728 }));
        glb.json["textures"][texture]["sampler"] = json!(sampler);
        let transform = json!({ "KHR_texture_transform": { "scale": [scale, 1] } });
        let base = json!({ "index": texture, "extensions": transform });
        let pbr = json!({ "baseColorTexture": base });
        let material = glb.push("materials", json!({ "pbrMetallicRoughness": pbr }));
        square(&mut glb, Some(material));
        glb.load().unwrap()
    };
    assert!(warns(&scene(1.0), "nearest"));
    assert!(!warns(&scene(1.0), "repeated instead"));
    assert!(warns(&scene(1.5), "repeated instead"));
}

#[test]
fn specular_has_the_reflectance_of_the_index() {
    for ior in [1.0, 1.2, 1.33, 1.5, 1.7_f32] {
        let material = json!({ "extensions": { "KHR_materials_ior": { "ior": ior } } });
        let specular = with_material(material).materials[0].specular;
        // The index that `principled` makes of it.
        let eta = 2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0;
        assert!((eta - ior).abs() < 1e-5, "{ior}: {eta}");
    }
    let material = json!({ "extensions": { "KHR_materials_specular": { "specularFactor": 0.5 } } });
    assert!((with_material(material).materials[0].specular - 0.25).abs() < 1e-6);
    let material = json!({ "extensions": {
        "KHR_materials_ior": { "ior": 0 },
        "KHR_materials_specular": { "specularColorFactor": [0.02, 0.02, 0.02] },
    }});
    assert!((with_material(material).materials[0].specular - 0.25).abs() < 1e-6);
}

/// Glass by KHR_materials_transmission and _volume, opacity by alphaMode.
#[test]
fn glass_and_opacity() {
    let glass = |volume: serde_json::Value, roughness: f32| {
        let scene = with_material(json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": roughness },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": volume,
                "KHR_materials_ior": { "ior": 1.4 },
            },
        }));
        scene.materials[0].clone()
    };
    let volume = json!({ "thicknessFactor": 0.1, "attenuationDistance": 2,
        "attenuationColor": [1, 0.5, 0.25] });
    let solid = glass(volume.clone(), 0.0);
    assert_eq!((solid.kind, solid.own[0].value.x), (&DIELECTRIC, 1.4));
    let half = std::f32::consts::LN_2 / 2.0;
    let error = solid.own[1].value - Vec3::new(0.0, half, 2.0 * half);
    assert!(error.abs().max_element() < 1e-6);
    assert_eq!(glass(volume, 0.5).kind, &ROUGH_DIELECTRIC);
    assert_eq!(glass(json!({}), 0.0).kind, &THIN_DIELECTRIC);
    let alpha = |mode: &str| {
        let scene = with_material(json!({ "alphaMode": mode, "alphaCutoff": 0.25,
            "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5] } }));
        scene.materials[0].opacity
    };
    assert_eq!((alpha("BLEND").value, alpha("BLEND").cutoff), (0.5, None));
    assert!(!alpha("OPAQUE").lets_through() && !alpha("MASK").lets_through());
}
