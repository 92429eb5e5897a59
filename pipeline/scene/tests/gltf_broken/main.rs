//! Damaged glTF files: a message with file and place, never a panic, and never more memory
//! than the file's size accounts for. A binary of its own: its allocator watches every request.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../files/glb.rs"]
mod glb;
mod values;
mod watched;

use glb::{Glb, load_bytes};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rrf_scene::LoadOptions;
use serde_json::{Value, json};
use std::sync::atomic::Ordering;
use watched::LARGEST;

/// A few kilobytes of file may ask for this much at once: a picture's greatest possible
/// size, 8 * 1032 texels of 12 bytes a byte, stays below for the 78 bytes of the one here.
const MOST_BYTES: usize = 1 << 23;

/// Everything that is read: two materials, a texture, lights, cameras, sparse and strided
/// accessors, a hierarchy.
pub fn rich() -> Glb {
    let mut glb = Glb::new();
    let texture = glb.texture(2, 2, &[[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]]);
    let info = json!({ "index": texture });
    glb.push(
        "materials",
        json!({
            "pbrMetallicRoughness": { "baseColorTexture": info, "metallicRoughnessTexture": info },
            "normalTexture": info, "emissiveTexture": info, "emissiveFactor": [1, 1, 1],
            "extensions": { "KHR_materials_ior": { "ior": 1.4 } },
        }),
    );
    let positions = glb.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0; 3]]);
    let normals = glb.floats(&[[0.0, 0.0, 1.0]; 4]);
    let uvs = glb.floats(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let indices = glb.integers(&[0, 1, 2, 0, 2, 3], 5123);
    let ids = glb.integers(&[1, 3], 5121);
    let view = glb.json["accessors"][ids]["bufferView"].clone();
    let values = glb.json["accessors"][normals]["bufferView"].clone();
    let sparse = json!({
        "count": 2, "indices": { "bufferView": view, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    glb.json["accessors"][positions]["sparse"] = sparse;
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
    let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
    let child = glb.place(primitive.clone(), json!({ "scale": [1, -1, 1] }));
    let mut strip = primitive;
    strip["mode"] = json!(5);
    strip.as_object_mut().unwrap().remove("material");
    glb.place(strip, json!({ "rotation": [0, 0, 0.6, 0.8] }));
    glb.json["scenes"][0]["nodes"] = json!([1]);
    glb.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let lens = json!({ "yfov": 1.0, "znear": 0.1 });
    glb.push(
        "cameras",
        json!({ "type": "perspective", "perspective": lens }),
    );
    glb.root(json!({
        "children": [child], "camera": 0,
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    glb
}

/// The square of `rich`, alone, with one thing changed.
pub fn broken(change: impl Fn(&mut Value)) -> String {
    let mut glb = Glb::new();
    let positions = glb.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = glb.integers(&[0, 1, 2], 5123);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    glb.place(primitive, json!({ "name": "N" }));
    glb.json["buffers"] = json!([{ "byteLength": glb.bin.len() }]);
    assert!(glb.load().is_ok());
    change(&mut glb.json);
    glb.refused()
}

/// All parts are in the message.
pub fn expect(message: String, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

#[test]
fn accessors_out_of_range_are_refused() {
    const PLACE: &str = "mesh 0, primitive 0";
    let count = |n: Value| broken(|json| json["accessors"][0]["count"] = n.clone());
    expect(
        count(json!(4)),
        &[PLACE, "accessor 0", "4 elements of 12 bytes"],
    );
    expect(count(json!(u64::MAX)), &[PLACE, "do not fit"]);
    expect(count(json!(1_u64 << 60)), &[PLACE, "do not fit"]);
    expect(
        broken(|json| json["accessors"][0]["byteOffset"] = json!(u64::MAX - 3)),
        &[PLACE, "do not fit"],
    );
    expect(
        broken(|json| json["bufferViews"][0]["byteLength"] = json!(1_000_000)),
        &[PLACE, "buffer 0's"],
    );
    expect(
        broken(|json| json["bufferViews"][0]["byteOffset"] = json!(u64::MAX)),
        &[PLACE, "view 0"],
    );
    expect(
        broken(|json| json["bufferViews"][0]["byteStride"] = json!(8)),
        &[PLACE, "byteStride 8"],
    );
    expect(
        broken(|json| json["accessors"][0]["type"] = json!("VEC2")),
        &[PLACE, "POSITION", "VEC2", "must be VEC3"],
    );
    expect(
        broken(|json| json["accessors"][1]["componentType"] = json!(5126)),
        &[PLACE, "indices", "floats"],
    );
    expect(
        broken(|json| json["accessors"][0]["bufferView"] = json!(77)),
        &["accessors[0].bufferView", "Index out of bounds"],
    );
    expect(
        broken(|json| json["meshes"][0]["primitives"][0]["indices"] = json!(5)),
        &["meshes[0].primitives[0].indices"],
    );
    expect(
        broken(|json| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(5)),
        &[PLACE, "POSITION is accessor 5"],
    );
    expect(
        broken(|json| json["accessors"][1]["count"] = json!(2)),
        &[PLACE, "multiple of 3"],
    );
}

#[test]
fn declared_counts_ask_for_no_memory() {
    // No buffer view: nothing in the file limits the count.
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 1, "componentType": 5123 },
        "values": { "bufferView": 0 },
    });
    let message = broken(|json| {
        json["accessors"][0] = json!({
            "componentType": 5126, "count": 3_000_000_000_u64, "type": "VEC3", "sparse": sparse,
        });
        let primitive = json["meshes"][0]["primitives"][0].as_object_mut().unwrap();
        primitive.remove("indices");
    });
    expect(
        message,
        &["mesh 0, primitive 0", "more than 134217728 triangles"],
    );
    // The same with an index: only the used vertices count.
    let mut glb = Glb::new();
    let floats = glb.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let ids = glb.integers(&[1, 7], 5123);
    let view = |accessor: usize| glb.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": view(ids), "componentType": 5123 },
        "values": { "bufferView": view(floats) },
    });
    let positions = json!({
        "componentType": 5126, "count": 3_000_000_000_u64, "type": "VEC3", "sparse": sparse,
    });
    let positions = glb.push("accessors", positions);
    let indices = glb.integers(&[2_000_000_000, 1, 7], 5125);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    glb.place(primitive, json!({}));
    assert_eq!(glb.load().unwrap().positions.len(), 3);
}

#[test]
fn indices_and_positions_are_checked() {
    let mut glb = Glb::new();
    let positions = glb.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]]);
    glb.place(
        json!({ "attributes": { "POSITION": positions } }),
        json!({ "name": "N" }),
    );
    let message = glb.refused();
    expect(
        message,
        &["mesh 0, primitive 0", "vertex 2 at 0 NaN 0", "node 0 \"N\""],
    );

    let mut glb = Glb::new();
    let positions = glb.floats(&[[0.0; 3]; 3]);
    let indices = glb.integers(&[0, 1, 3], 5121);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    glb.place(primitive, json!({}));
    expect(
        glb.refused(),
        &["mesh 0, primitive 0", "corner 2 is vertex 3", "3 vertices"],
    );

    let overflow = |json: &mut Value| json["nodes"][0]["scale"] = json!([3e38, 3e38, 1]);
    let mut glb = Glb::new();
    let positions = glb.floats(&[[0.0; 3], [2.0; 3], [1.0, 0.0, 0.0]]);
    glb.place(
        json!({ "attributes": { "POSITION": positions } }),
        json!({}),
    );
    overflow(&mut glb.json);
    expect(glb.refused(), &["vertex 1", "not finite in world space"]);
}

#[test]
fn sparse_accessors_are_checked() {
    let with = |ids: &[u32]| {
        let mut glb = Glb::new();
        let values = glb.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let ids_accessor = glb.integers(ids, 5121);
        let view = |accessor: usize| glb.json["accessors"][accessor]["bufferView"].clone();
        let sparse = json!({
            "count": ids.len(),
            "indices": { "bufferView": view(ids_accessor), "componentType": 5121 },
            "values": { "bufferView": view(values) },
        });
        let accessor =
            json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse });
        let positions = glb.push("accessors", accessor);
        glb.place(
            json!({ "attributes": { "POSITION": positions } }),
            json!({}),
        );
        glb
    };
    assert!(with(&[0, 2]).load().is_ok());
    for ids in [&[2, 0][..], &[1, 1], &[0, 3]] {
        expect(with(ids).refused(), &["sparse indices must increase"]);
    }
    expect(with(&[0, 1, 2]).refused(), &["do not fit"]);
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = rich().bytes();
    load_bytes("scene.glb", &bytes, &LoadOptions::default()).unwrap();
    for end in 0..bytes.len() {
        let result = load_bytes("scene.glb", &bytes[..end], &LoadOptions::default());
        let message = result.unwrap_err().to_string();
        assert!(message.contains("scene.glb:"), "{end}: {message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2048,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Bytes anywhere replaced: a scene or an error, no panic, no great allocation.
    #[test]
    fn flipped_bytes_never_panic(flips in prop::collection::vec((any::<usize>(), any::<u8>()), 1..6)) {
        let mut bytes = rich().bytes();
        for (position, value) in flips {
            let position = position % bytes.len();
            bytes[position] = value;
        }
        LARGEST.store(0, Ordering::Relaxed);
        check(load_bytes("scene.glb", &bytes, &LoadOptions::default()));
        let largest = LARGEST.load(Ordering::Relaxed);
        prop_assert!(largest < MOST_BYTES, "{largest} bytes at once");
    }

    /// Digits of the JSON replaced by digits: well-formed, with wrong numbers.
    #[test]
    fn changed_numbers_never_panic(changes in prop::collection::vec((any::<usize>(), b'0'..=b'9'), 1..6)) {
        let mut bytes = rich().bytes();
        let digits: Vec<usize> = (20..bytes.len())
            .take_while(|&i| &bytes[i..i + 4] != b"BIN\0")
            .filter(|&i| bytes[i].is_ascii_digit())
            .collect();
        for (which, digit) in changes {
            let position = digits[which % digits.len()];
            bytes[position] = digit;
        }
        LARGEST.store(0, Ordering::Relaxed);
        check(load_bytes("scene.glb", &bytes, &LoadOptions::default()));
        let largest = LARGEST.load(Ordering::Relaxed);
        prop_assert!(largest < MOST_BYTES, "{largest} bytes at once");
    }
}

/// A scene that loads has columns that fit each other.
fn check(result: Result<rrf_scene::Scene, rrf_scene::SceneError>) {
    let Ok(scene) = result else { return };
    let count = scene.positions.len();
    assert!(scene.positions.iter().all(|p| p.is_finite()));
    assert!(
        scene
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < count)
    );
    assert_eq!((scene.normals.len(), scene.uvs.len()), (count, count));
    for column in [
        &scene.triangle_material,
        &scene.triangle_object,
        &scene.triangle_light,
    ] {
        assert_eq!(column.len(), scene.triangles.len());
    }
    let materials = scene.materials.len();
    assert!(
        scene
            .triangle_material
            .iter()
            .all(|&m| (m as usize) < materials)
    );
}
