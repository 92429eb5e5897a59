//! No input, however broken, makes the reader panic.

use super::{TRIANGLE, read_bytes};
use crate::SceneError;
use proptest::collection::vec;
use proptest::prelude::*;

/// A version 4 scene with most that the format has.
const MANY: &str = r#"
# options
LookAt 0 1 5  0 1 0  0 1 0
Scale -1 1 1
Camera "perspective" "float fov" [ 40 ] "float lensradius" 0
Film "rgb" "integer xresolution" 400 "integer yresolution" [300] "string filename" "a\"b.exr"
Sampler "zsobol" "integer pixelsamples" 16
Integrator "volpath" "integer maxdepth" [ 100 ]
PixelFilter "gaussian" "float xradius" 2
Accelerator "bvh"
ColorSpace "rec2020"
Option "bool disablepixeljitter" true
WorldBegin
AttributeBegin
  Attribute "shape" "float radius" 2
  AreaLightSource "diffuse" "blackbody L" 4500 "float scale" 2
  Translate 0 3 0
  Shape "disk" "float radius" .5
AttributeEnd
Texture "t" "spectrum" "constant" "rgb value" [ .2 .4 .6 ]
MakeNamedMaterial "wall" "string type" "diffuse" "texture reflectance" "t"
NamedMaterial "wall"
TransformBegin
  Rotate 90 1 0 0
  ObjectBegin "o"
    Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 ] "normal N" [ 0 0 1 0 0 1 0 0 1 ]
      "point2 uv" [ 0 0 1 0 0 1 ] "integer indices" [ 0 1 2 ]
  ObjectEnd
TransformEnd
ObjectInstance "o"
Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" .1
Shape "cylinder" "float zmin" 0 "float zmax" 1
LightSource "point" "rgb I" [ 1 1 1 ] "point3 from" [ 0 2 0 ]
"#;

#[test]
fn the_large_sample_is_read() {
    let scene = read_bytes(MANY.as_bytes()).unwrap();
    assert_eq!((scene.area_lights.len(), scene.lights.len()), (1, 1));
    assert_eq!(scene.cameras[0].width, 400);
    assert_eq!(scene.cameras[0].right, glam::Vec3::X);
}

/// Cut anywhere, it is a shorter scene or an error with a place, never a panic.
#[test]
fn cut_at_every_byte() {
    for end in 0..MANY.len() {
        if let Err(SceneError::Syntax { line, column, .. }) = read_bytes(&MANY.as_bytes()[..end]) {
            assert!(line >= 1 && column >= 1);
        }
    }
}

/// One byte replaced at every place by bytes that mean something.
#[test]
fn one_byte_replaced() {
    for at in 0..MANY.len() {
        for byte in [b'"', b'[', b']', b'#', b'\\', b'-', b'9', b' ', 0, 0xff] {
            let mut bytes = MANY.as_bytes().to_vec();
            bytes[at] = byte;
            let _ = read_bytes(&bytes);
        }
    }
}

/// Words of the format in any order.
fn word() -> impl Strategy<Value = String> {
    let words: Vec<&str> = MANY.split_ascii_whitespace().collect();
    let numbers = ["1e38", "-1e38", "1e-45", "0", "-0", "4294967295", "1e308"];
    prop_oneof![
        6 => proptest::sample::select(words).prop_map(str::to_owned),
        1 => proptest::sample::select(numbers.to_vec()).prop_map(str::to_owned),
        1 => Just(TRIANGLE.to_owned()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in vec(any::<u8>(), 0..400)) {
        let _ = read_bytes(&bytes);
    }

    #[test]
    fn random_words(words in vec(word(), 0..80)) {
        let _ = read_bytes(words.join(" ").as_bytes());
        let _ = read_bytes(format!("WorldBegin {}", words.join(" ")).as_bytes());
    }

    #[test]
    fn random_lines(lines in vec(proptest::sample::select(MANY.lines().collect::<Vec<_>>()), 0..40)) {
        let _ = read_bytes(lines.join("\n").as_bytes());
        let _ = read_bytes(format!("WorldBegin\n{}", lines.join("\n")).as_bytes());
    }

    #[test]
    fn random_ply_bodies(body in vec(any::<u8>(), 0..200), big in any::<bool>(), count in 0..9_u64) {
        let format = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\nformat binary_{format}_endian 1.0\nelement vertex {count}\nproperty float x\nproperty double y\n\
             property short z\nelement face {}\nproperty list uint int vertex_indices\nend_header\n", u64::MAX
        ).into_bytes();
        bytes.extend(&body);
        prop_assert!(super::super::ply::read("mesh.ply".as_ref(), &bytes).is_err());
        prop_assert!(super::super::ply::read("mesh.ply".as_ref(), &body).is_err());
    }
}
