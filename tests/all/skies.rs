//! Skies that are given or refused, names of own lights, and lights that light nothing.

use crate::program::{Place, cornell, done, refused, says};

/// A floor of 2 x 2 under a wall.
const CORNER: &str = r#"
Material "matte" "rgb Kd" [ 0.5 0.5 0.5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
  "point P" [ -1 0 -1  -1 0 1  1 0 1  1 0 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ]
  "point P" [ -1 0 -1  1 0 -1  1 2 -1  -1 2 -1 ]
WorldEnd
"#;

/// A lat-long picture of 2 x 1 texels.
fn picture(texels: [f32; 2]) -> Vec<u8> {
    let mut bytes = b"PF\n2 1\n-1\n".to_vec();
    let channels = texels.into_iter().flat_map(|texel| [texel; 3]);
    bytes.extend(channels.flat_map(f32::to_le_bytes));
    bytes
}

#[test]
fn skies_that_are_none() {
    let place = Place::new();
    let scene = place.write("a.pbrt", format!("WorldBegin {CORNER}"));
    let nan = place.write("nan.pfm", picture([1.0, f32::NAN]));
    let negative = place.write("negative.pfm", picture([-1.0, 1.0]));
    let text = place.write("text.exr", "no picture");
    let absent = place.name("absent.exr");
    let output = place.name("a.exr");
    for (sky, words) in [
        (nan.as_str(), ["nan.pfm", "column 1, row 0"]),
        (&negative, ["negative.pfm", "column 0, row 0"]),
        (&text, ["text.exr", "picture"]),
        (&absent, ["absent.exr", "No such file"]),
        ("1,2", ["--sky", "3 numbers"]),
        ("1,-2,3", ["--sky", "negative"]),
    ] {
        for command in ["scene", "bake", "trace"] {
            let mut args = vec![command, &scene, "--sky", sky];
            if command != "scene" {
                args.extend(["-o", &output]);
            }
            refused(&args, &words);
        }
    }
    let with = place.write(
        "sky.pbrt",
        format!("WorldBegin LightSource \"infinite\" {CORNER}"),
    );
    refused(
        &["scene", &with, "--sky", "1,1,1"],
        &["sky.pbrt", "of its own"],
    );
    refused(&["scene", &scene, "--sky-rotate", "30"], &["--sky"]);
    assert!(!place.path("a.exr").exists());
}

#[test]
fn own_lights_are_listed_by_name() {
    let said = done(&["scene", &cornell(), "--sky", "1,2,3", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(found["lights"][0]["name"], "sky");
    assert_eq!(found["lights"][0]["kind"], "environment");
    assert_eq!(found["area_lights"][0]["name"], "light0");
    let said = done(&["scene", &cornell(), "--sky", "1,2,3"]);
    assert!(said.out.contains("constant, 1 2 3 W/(sr m²)"), "{said:?}");
}

/// A sun below the floor of what is seen is named, one above it is not.
#[test]
fn a_sun_below_the_floor_lights_nothing() {
    let place = Place::new();
    let picture = place.name("a.exr");
    for (height, is_dark) in [(-1, true), (1, false)] {
        let sun =
            format!("LightSource \"distant\" \"point from\" [0 {height} 0] \"point to\" [0 0 0]");
        let scene = place.write("sun.pbrt", format!("WorldBegin {sun} {CORNER}"));
        let view = ["--eye", "0,1,4", "--look-at", "0,1,0", "--size", "16x16"];
        let trace = [&["trace", &scene, "--spp", "4", "-o", &picture], &view[..]].concat();
        let said = done(&trace);
        assert_eq!(said.err.contains("lights nothing"), is_dark, "{said:?}");
        if is_dark {
            says(&said, &["\"light0\"", "horizon"]);
        }
    }
}
