//! Nodes, data, pictures and values that mean nothing.

use crate::glb::Glb;
use crate::{broken, expect, rich};
use serde_json::{Value, json};

#[test]
fn nodes_that_are_no_trees_are_refused() {
    let nodes = |nodes: Value, roots: Value| {
        broken(|json| {
            json["nodes"] = nodes.clone();
            json["scenes"][0]["nodes"] = roots.clone();
        })
    };
    expect(
        nodes(
            json!([{ "children": [1] }, { "children": [0] }]),
            json!([0]),
        ),
        &["node 0", "its own ancestor"],
    );
    expect(
        nodes(json!([{ "children": [0] }]), json!([0])),
        &["its own ancestor"],
    );
    expect(
        nodes(
            json!([{ "children": [2] }, { "children": [2] }, {}]),
            json!([0, 1]),
        ),
        &["node 2", "child of node 0 and of node 1"],
    );
    expect(
        nodes(json!([{ "children": [1, 1] }, {}]), json!([0])),
        &["node 1"],
    );
    expect(
        nodes(json!([{}]), json!([0, 0])),
        &["scene 0", "listed twice"],
    );
    expect(
        nodes(json!([{ "children": [1] }, {}]), json!([0, 1])),
        &["node 1", "has a parent"],
    );
    expect(
        nodes(json!([{ "children": [9] }]), json!([0])),
        &["nodes[0].children[0]"],
    );
    expect(
        nodes(json!([{ "rotation": [0, 0, 0, 0] }]), json!([0])),
        &["node 0", "quaternion"],
    );
    let mut matrix = [0.0; 16];
    matrix[3] = 1.0;
    expect(
        nodes(json!([{ "matrix": matrix }]), json!([0])),
        &["node 0", "affine"],
    );
}

#[test]
fn lost_data_is_named() {
    let glb = rich();
    let mut lost = Glb::new();
    lost.json = glb.json.clone();
    lost.json["buffers"] = json!([{ "byteLength": glb.bin.len() }]);
    expect(lost.refused(), &["buffer 0", "no BIN chunk"]);

    let mut short = rich();
    short.json["buffers"] = json!([{ "byteLength": 1_u64 << 40 }]);
    expect(short.refused(), &["buffer 0", "truncated"]);

    for (uri, part) in [
        ("nowhere.bin", "nowhere.bin: cannot be read"),
        ("https://example.org/a.bin", "only data: URIs and files"),
        ("data:;base64,***", "data URI"),
        ("%FF%FE", "uri"),
        (".", "not a regular file"),
    ] {
        let mut glb = rich();
        glb.json["buffers"] = json!([{ "byteLength": 4, "uri": uri }]);
        let message = glb.load().unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn pictures_that_are_none_are_named() {
    let mut glb = rich();
    glb.json["images"][0] = json!({});
    expect(glb.refused(), &["material 0", "image 0: neither uri"]);
    glb.json["images"][0] = json!({ "bufferView": 1, "mimeType": "image/png" });
    expect(glb.refused(), &["material 0, image 0", "cannot be decoded"]);
    glb.json["images"][0] = json!({ "uri": "nowhere.png" });
    let warnings = glb.load().unwrap().warnings;
    let lost = warnings.iter().find(|w| w.message.contains("nowhere.png"));
    assert!(lost.is_some(), "{warnings:?}");
}

#[test]
fn values_without_meaning_are_refused() {
    let material = |material: Value| {
        let mut glb = rich();
        glb.json["materials"][0] = material;
        glb.refused()
    };
    let pbr = json!({ "pbrMetallicRoughness": { "roughnessFactor": 1e39 } });
    // beyond f32: JSON's reader says the place in the file
    expect(material(pbr), &["glTF's JSON", "out of range", "column"]);
    expect(
        material(json!({ "emissiveFactor": [-1, 0, 0] })),
        &["emission"],
    );
    expect(
        material(json!({ "emissiveFactor": [1e39, 0, 0] })),
        &["glTF's JSON", "out of range", "column"],
    );
    let extension = |name: &str, value: Value| material(json!({ "extensions": { name: value } }));
    expect(
        extension("KHR_materials_ior", json!({ "ior": 0.5 })),
        &["refraction"],
    );
    let specular = json!({ "specularFactor": 2 });
    expect(
        extension("KHR_materials_specular", specular),
        &["specularFactor"],
    );

    let mut glb = rich();
    glb.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-5);
    expect(glb.refused(), &["light 0", "none negative"]);
    let mut glb = rich();
    glb.json["cameras"][0]["perspective"]["yfov"] = json!(4);
    expect(glb.refused(), &["camera 0", "yfov"]);
}
