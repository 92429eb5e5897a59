//! Lights and cameras of glTF files built here.

use crate::glb::Glb;
use crate::gltf_materials::{PICTURE, square, with_material};
use crate::support::{notes, some_triangle, warns};
use glam::Vec3;
use rrf_scene::{INVALID, LightSource, LightUnits, LoadOptions};
use serde_json::{Value, json};

#[test]
fn emission_becomes_area_lights() {
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 10 } });
    let scene = with_material(json!({
        "emissiveFactor": [1, 0.5, 0], "extensions": strength, "doubleSided": true,
    }));
    assert_eq!(scene.triangle_light, [0, 0]);
    assert_eq!(scene.area_lights[0].radiance, Vec3::new(10.0, 5.0, 0.0));
    assert!(scene.area_lights[0].two_sided);
    let scene = with_material(json!({ "emissiveFactor": [1, 1, 1] }));
    assert!(!scene.area_lights[0].two_sided);
    // A strength without a factor emits nothing.
    let scene = with_material(json!({ "extensions": strength }));
    assert_eq!(
        (scene.triangle_light[0], scene.area_lights.len()),
        (INVALID, 0)
    );

    let mut glb = Glb::new();
    let texture = glb.texture(2, 2, &PICTURE);
    let material = json!({
        "emissiveFactor": [4, 4, 4], "emissiveTexture": { "index": texture },
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1] },
    });
    let material = glb.push("materials", material);
    square(&mut glb, Some(material));
    let scene = glb.load().unwrap();
    assert_eq!(scene.area_lights[0].radiance, Vec3::splat(4.0));
    // The square's triangles are (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1).
    for (triangle, place, want) in [
        (1, [0.25, 0.5], Vec3::X),
        (0, [0.0, 0.75], Vec3::Y),
        (0, [0.0, 0.25], Vec3::Z),
    ] {
        let share = scene.emitted_share(triangle, place);
        assert!((share - want).length() < 1e-5, "{triangle} {share}");
    }
    // Each channel is once 1 and once the grey's 0.5029 in four texels.
    let power = scene.summary().area_lights[0].power;
    let want = 4.0 * std::f64::consts::PI * (1.0 + 0.502_886) / 4.0;
    for channel in power {
        assert!((channel / want - 1.0).abs() < 0.02, "{power:?} {want}");
    }
    assert!(notes(&scene).is_empty(), "{:?}", scene.warnings);
}

/// A lamp is called by its material, a light by its node; names are unique, `sun` is reserved.
#[test]
fn names_of_lights() {
    let mut glb = Glb::new();
    let lamp = json!({ "name": "sun", "emissiveFactor": [1, 1, 1] });
    let [first, second] = [lamp.clone(), lamp].map(|lamp| glb.push("materials", lamp));
    for material in [first, second, first] {
        square(&mut glb, Some(material));
    }
    light(
        &mut glb,
        json!({ "type": "point" }),
        json!({ "name": "bulb" }),
    );
    light(&mut glb, json!({ "type": "point" }), json!({}));
    let scene = glb.load().unwrap();
    assert_eq!(scene.area_light_names, ["sun.own", "sun.own.2", "sun.own"]);
    assert_eq!(
        scene.own_light_names(),
        ["bulb", "light 1", "sun.own", "sun.own.2"]
    );
}

fn light(glb: &mut Glb, light: Value, node: Value) {
    let lights = &mut glb.json["extensions"]["KHR_lights_punctual"]["lights"];
    if lights.is_null() {
        *lights = json!([]);
    }
    let lights = lights.as_array_mut().unwrap();
    lights.push(light);
    let index = lights.len() - 1;
    let mut node = node;
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": index } });
    glb.root(node);
}

#[test]
fn punctual_lights_follow_their_nodes() {
    let mut glb = Glb::new();
    some_triangle(&mut glb);
    light(
        &mut glb,
        json!({ "type": "point" }),
        json!({ "translation": [1, 2, 3] }),
    );
    light(
        &mut glb,
        json!({ "type": "point", "range": 3, "intensity": 2, "color": [1, 0, 0.5] }),
        json!({}),
    );
    // Half a turn about x: -z becomes +z.
    let turned = json!({ "rotation": [1, 0, 0, 0], "translation": [1, 2, 3], "scale": [2, 2, 2] });
    light(
        &mut glb,
        json!({ "type": "directional", "intensity": 3 }),
        turned.clone(),
    );
    let cones = json!({ "innerConeAngle": 0.25, "outerConeAngle": 0.5 });
    light(&mut glb, json!({ "type": "spot", "spot": cones }), turned);
    light(&mut glb, json!({ "type": "spot", "spot": {} }), json!({}));
    let options = LoadOptions {
        light_units: LightUnits::Compat,
        ..LoadOptions::default()
    };
    let scene = glb.load_with(&options).unwrap();
    assert_eq!(scene.lights.len(), 5);
    assert_eq!(
        scene.points().next().unwrap().position,
        Vec3::new(1.0, 2.0, 3.0)
    );
    assert_eq!(scene.points().next().unwrap().intensity, Vec3::ONE);
    assert_eq!(
        scene.points().nth(1).unwrap().intensity,
        Vec3::new(2.0, 0.0, 1.0)
    );
    assert!(warns(&scene, "range"));
    let LightSource::Distant(sun) = &scene.lights[2].source else {
        panic!("{:?}", scene.lights[2]);
    };
    assert_eq!(
        (sun.toward, sun.irradiance, sun.diameter),
        (Vec3::NEG_Z, Vec3::splat(3.0), 0.0)
    );
    let LightSource::Spot(spot) = &scene.lights[3].source else {
        panic!("{:?}", scene.lights[3]);
    };
    assert_eq!((spot.axis, spot.intensity), (Vec3::Z, Vec3::ONE));
    assert_eq!(spot.position, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!((spot.inner, spot.outer), (0.25, 0.5));
    let LightSource::Spot(spot) = &scene.lights[4].source else {
        panic!("{:?}", scene.lights[4]);
    };
    assert_eq!((spot.inner, spot.outer), (0.0, std::f32::consts::FRAC_PI_4));
}

#[test]
fn units_of_emission_beside_candela_are_said() {
    let mut glb = Glb::new();
    let material = glb.push("materials", json!({ "emissiveFactor": [1, 1, 1] }));
    square(&mut glb, Some(material));
    light(&mut glb, json!({ "type": "point" }), json!({}));
    assert!(warns(&glb.load().unwrap(), "683"));
    let options = LoadOptions {
        light_units: LightUnits::Raw,
        ..LoadOptions::default()
    };
    assert!(!warns(&glb.load_with(&options).unwrap(), "683"));
}

#[test]
fn cameras_follow_their_nodes() {
    let mut glb = Glb::new();
    some_triangle(&mut glb);
    let upright = json!({ "yfov": 1.0, "aspectRatio": 0.5, "znear": 0.1 });
    let camera = json!({ "type": "perspective", "perspective": upright, "name": "c" });
    glb.push("cameras", camera);
    let flat = json!({ "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1 });
    glb.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": flat }),
    );
    // Half a turn about y: looks along +z, right is -x.
    glb.root(json!({ "camera": 0, "rotation": [0, 1, 0, 0], "translation": [0, 0, -4] }));
    glb.root(json!({ "camera": 1 }));
    let scene = glb.load().unwrap();
    assert_eq!(scene.cameras.len(), 1);
    let camera = &scene.cameras[0];
    assert_eq!(
        (camera.name.as_str(), camera.eye),
        ("c", Vec3::new(0.0, 0.0, -4.0))
    );
    assert!((camera.forward - Vec3::Z).length() < 1e-6);
    assert!((camera.right + Vec3::X).length() < 1e-6);
    assert!((camera.up - Vec3::Y).length() < 1e-6);
    assert_eq!((camera.width, camera.height), (512, 1024));
    let want = 2.0 * (0.5 * 0.5_f32.tan()).atan().to_degrees();
    assert!((camera.fov - want).abs() < 1e-4);
    assert!(warns(&scene, "orthographic"));
}
