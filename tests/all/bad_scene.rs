//! Scene files that are damaged, empty or odd: refused with file and place, or understood with
//! a warning; nothing is written for a scene that is refused.

use crate::program::{Place, bake_tiny, cornell, done, refused};
use crate::table;

/// A floor of 2 x 2 under a wall, no lights, no camera.
const CORNER: &str = r#"WorldBegin
Material "matte" "rgb Kd" [ 0.5 0.5 0.5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
  "point P" [ -1 0 -1  -1 0 1  1 0 1  1 0 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
  "point P" [ -1 0 -1  1 0 -1  1 2 -1  -1 2 -1 ]
WorldEnd
"#;

/// `rrf bake` and `rrf scene` refuse the file with these words, and no run folder appears.
fn both_refuse(name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
    let place = Place::new();
    let scene = place.write(name, bytes);
    let words = [&[name], words].concat();
    refused(&["scene", &scene], &words);
    refused(&["bake", &scene, "-o", &place.name("run")], &words);
    assert!(place.holds(&[name]), "{name}: something was written");
}

#[test]
fn truncated_pbrt() {
    let whole = std::fs::read(cornell()).expect("the scene");
    both_refuse("cut.pbrt", &whole[..1500], &["cut.pbrt:17:", "truncated"]);
}

#[test]
fn binary_named_pbrt() {
    let bytes = std::fs::read(env!("CARGO_BIN_EXE_rrf")).expect("the binary");
    both_refuse("tool.pbrt", &bytes[..4096], &["tool.pbrt:1:", "not text"]);
}

/// A .glb whose JSON speaks of a buffer that is not in the file.
#[test]
fn glb_without_buffer() {
    let mut json = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
        "min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}"#
        .to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let words = |n: usize| (n as u32).to_le_bytes();
    let mut glb = [*b"glTF", words(2), words(20 + json.len())].concat();
    glb.extend([words(json.len()), *b"JSON"].concat());
    glb.extend(&json);
    both_refuse("hollow.glb", glb, &["buffer"]);
}

#[test]
fn not_a_number_in_a_mesh() {
    let scene = CORNER.replacen("-1 0 1 ", "-1 nan 1 ", 1);
    both_refuse("nan.pbrt", scene, &["nan.pbrt:4:", "not a finite number"]);
}

#[test]
fn index_out_of_range() {
    let scene = CORNER.replacen("0 2 3", "0 2 9", 1);
    both_refuse("index.pbrt", scene, &["index.pbrt:3:", "9", "4 positions"]);
}

#[test]
fn no_triangles() {
    both_refuse("empty.pbrt", "WorldBegin\nWorldEnd\n", &["no triangles"]);
    let flat = CORNER.replace("0 1 2 0 2 3", "0 1 1 2 2 3");
    both_refuse("flat.pbrt", flat, &["no triangles"]);
}

#[test]
fn no_such_scene() {
    let place = Place::new();
    refused(
        &["scene", &place.name("no.pbrt")],
        &["no.pbrt", "No such file"],
    );
    let other = place.write("scene.blend", "BLENDER");
    refused(
        &["scene", &other],
        &["scene.blend", ".pbrt", ".glb", ".obj"],
    );
}

/// Triangles without an area among others: left out, and said.
#[test]
fn triangles_without_area() {
    let place = Place::new();
    let odd = CORNER.replacen("0 1 2 0 2 3", "0 1 2 0 2 3 1 1 2", 1);
    let said = done(&["scene", &place.write("odd.pbrt", odd), "--json"]);
    let found: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(found["triangles"], 4, "{}", said.out);
    let warnings = found["warnings"].to_string();
    assert!(
        warnings.contains("area") && warnings.contains("odd.pbrt"),
        "{warnings}"
    );
}

/// A scene without lights bakes: its lights come at render time. A picture of it needs one.
#[test]
fn no_lights() {
    let place = Place::new();
    let scene = place.write("dark.pbrt", CORNER);
    let run = place.name("run");
    bake_tiny(&scene, &run, &[]);
    let view = ["--eye", "0,1,4", "--look-at", "0,1,0", "--size", "16x16"];
    let picture = place.name("a.exr");
    let render = [&["render", &run, "-o", &picture], &view[..]].concat();
    refused(&render, &["no light", "--light"]);
    let trace = [&["trace", &scene, "--spp", "4", "-o", &picture], &view[..]].concat();
    refused(&trace, &["no light", "--light"]);
    assert!(!place.path("a.exr").exists());
    done(&[&render[..], &["--light", "0,1,0"]].concat());
}

/// And it answers at points: two facing walls of a corner light each other.
#[test]
fn no_camera() {
    let place = Place::new();
    let scene = place.write("corner.pbrt", CORNER);
    let call = [
        "trace",
        &scene,
        "--light",
        "0,1,0",
        "-o",
        &place.name("a.exr"),
    ];
    refused(&call, &["no camera", "--eye"]);
    let row = [0.3, 0.0, -0.5, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5];
    let columns: Vec<_> = table::GEOMETRY
        .into_iter()
        .zip(row.map(|x| vec![x]))
        .collect();
    let (input, out) = (place.name("in.parquet"), place.name("out.parquet"));
    table::write(&input, &columns);
    done(&[
        "trace", &scene, "--points", &input, "-o", &out, "--spp", "256",
    ]);
    let [radiance] = table::Table::read(&out).rgb("")[..] else {
        panic!("one row in, one row out");
    };
    assert!(radiance.iter().all(|&x| x > 0.0), "{radiance:?}");
}
