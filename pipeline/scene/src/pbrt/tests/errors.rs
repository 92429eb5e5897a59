//! Every fault of a text is named with its line and column.

use super::{TRIANGLE, read_bytes, syntax, world_v3, world_v4};
use crate::SceneError;

/// (text, line, column, words of the message)
const FAULTS: [(&str, u32, u32, &str); 45] = [
    ("", 1, 1, "without WorldBegin"),
    ("# only a comment\n", 2, 1, "without WorldBegin"),
    ("WorldBegin\nWorldBegin", 2, 1, "twice"),
    ("Frobnicate 3", 1, 1, "unknown directive `Frobnicate`"),
    ("  \n\t\"loose\"", 2, 2, "expected a directive"),
    ("]", 1, 1, "expected a directive"),
    ("Translate 1 2", 1, 14, "truncated"),
    ("Translate 1 2 x", 1, 15, "expected a number"),
    ("Translate 1 2 nan", 1, 15, "not a finite number"),
    ("Translate 1 2 1e999", 1, 15, "not a finite number"),
    ("Translate [1 2 3 4]", 1, 18, "expected `]`"),
    ("Translate 1 2 \"3\"", 1, 15, "expected a number"),
    ("Rotate 30 0 0 0", 1, 1, "no length"),
    ("LookAt 0 0 0  0 0 0  0 1 0", 1, 1, "span no view"),
    (
        "Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]",
        1,
        1,
        "perspective",
    ),
    ("Scale 1e300 1 1\nScale 1e300 1 1", 2, 1, "overflows"),
    (
        "CoordSysTransform \"nowhere\"",
        1,
        19,
        "no coordinate system",
    ),
    ("ActiveTransform Never", 1, 17, "All, StartTime or EndTime"),
    ("ColorSpace \"cmyk\"", 1, 12, "unknown colour space"),
    ("Camera \"fisheye\"", 1, 8, "unknown camera"),
    (
        "Camera \"perspective\" \"float fov\" 180",
        1,
        1,
        "must lie between 0 and 180",
    ),
    (
        "Camera \"perspective\" \"float fow\" 30",
        1,
        22,
        "no parameter \"fow\"",
    ),
    (
        "Camera \"perspective\" \"string fov\" \"30\"",
        1,
        22,
        "cannot be of type string",
    ),
    (
        "Camera \"perspective\" \"float fov\" [30 40]",
        1,
        22,
        "needs one value",
    ),
    (
        "Camera \"perspective\" \"float fov\" \"30\"",
        1,
        34,
        "expected a number",
    ),
    (
        "Camera \"perspective\" \"float fov",
        1,
        22,
        "ends inside this string",
    ),
    (
        "Camera \"perspective\" \"float fov\n\" 30",
        1,
        22,
        "no closing quote",
    ),
    (
        "Camera \"perspective\" \"floot fov\" 30",
        1,
        22,
        "unknown parameter type",
    ),
    (
        "Camera \"perspective\" \"fov\" 30",
        1,
        22,
        "\"type name\" is needed",
    ),
    (
        "Camera \"perspective\" \"float fov\" [30",
        1,
        37,
        "truncated",
    ),
    ("Camera perspective", 1, 8, "in quotes"),
    ("Scale 0 1 1\nCamera \"perspective\"", 2, 1, "no inverse"),
    (
        "Film \"rgb\" \"integer xresolution\" 0",
        1,
        1,
        "between 1 and 65536",
    ),
    (
        "Film \"rgb\" \"integer xresolution\" 1.5",
        1,
        12,
        "whole number",
    ),
    ("Film \"paper\"", 1, 1, "unknown film"),
    ("Shape \"sphere\"", 1, 1, "after WorldBegin"),
    ("WorldBegin\nFilm \"rgb\"", 2, 1, "before WorldBegin"),
    ("WorldBegin\nAttributeBegin\n", 2, 1, "no AttributeEnd"),
    ("WorldBegin\nAttributeEnd", 2, 1, "without AttributeBegin"),
    (
        "WorldBegin\nAttributeBegin\nTransformEnd",
        3,
        1,
        "inside AttributeBegin of line 2",
    ),
    (
        "WorldBegin\nObjectBegin \"a\"\nObjectBegin \"b\"",
        3,
        1,
        "inside another object",
    ),
    ("WorldBegin\nObjectInstance \"a\"", 2, 16, "no object \"a\""),
    (
        "WorldBegin\nAttributeBegin\nWorldEnd",
        2,
        1,
        "still open at WorldEnd",
    ),
    (
        "WorldBegin\nAttribute \"wall\" \"float a\" 1",
        2,
        11,
        "unknown Attribute target",
    ),
    ("Option \"bool x\" [true", 1, 22, "truncated"),
];

#[test]
fn faults_have_their_place() {
    for (text, line, column, words) in FAULTS {
        let (l, c, message) = syntax(read_bytes(text.as_bytes()));
        assert!(message.contains(words), "{text:?}: {message}");
        assert_eq!((l, c), (line, column), "{text:?}: {message}");
    }
}

/// Faults of a world's text, whose first line is line 3.
const WORLD_FAULTS: [(&str, u32, &str); 44] = [
    ("Material \"velvet\"", 10, "unknown material \"velvet\""),
    (
        "Material \"diffuse\" \"rgb reflectance\" [1 1]",
        20,
        "three numbers",
    ),
    (
        "Material \"diffuse\" \"blackbody reflectance\" 3000",
        20,
        "no black body gives",
    ),
    (
        "Material \"diffuse\" \"texture reflectance\" \"wood\"",
        20,
        "no texture \"wood\"",
    ),
    (
        "Material \"diffuse\" \"texture reflectance\" [1]",
        43,
        "does not fit",
    ),
    (
        "Material \"diffuse\" \"texture reflectance\" []",
        20,
        "has no value",
    ),
    (
        "Material \"diffuse\" \"rgb Kd\" [1 1 1]",
        20,
        "no parameter \"Kd\"",
    ),
    (
        "Material \"diffuse\" \"spectrum reflectance\" [400 1 300 1]",
        20,
        "do not increase",
    ),
    (
        "Material \"diffuse\" \"spectrum reflectance\" \"missing.spd\"",
        20,
        "no spectrum known here",
    ),
    (
        "Material \"conductor\" \"float roughness\" -1",
        1,
        "negative roughness",
    ),
    ("Material \"dielectric\" \"float eta\" 9", 23, "0.25 to 4"),
    ("Material \"dielectric\" \"float eta\" 0", 23, "0.25 to 4"),
    ("Material \"dielectric\" \"float eta\" -1.5", 23, "of -1.5"),
    (
        "Material \"mix\" \"string materials\" [\"a\" \"b\"]",
        10,
        "no material \"a\"",
    ),
    (
        "Material \"mix\" \"string materials\" [\"a\"]",
        10,
        "two materials",
    ),
    ("MakeNamedMaterial \"m\"", 19, "needs \"string type\""),
    (
        "Texture \"t\" \"colour\" \"constant\"",
        13,
        "float or spectrum",
    ),
    (
        "Texture \"t\" \"spectrum\" \"noise\"",
        24,
        "unknown texture class",
    ),
    (
        "Texture \"t\" \"spectrum\" \"imagemap\"",
        1,
        "needs a \"filename\"",
    ),
    ("LightSource \"sun\"", 13, "unknown light"),
    (
        "LightSource \"point\" \"rgb I\" [1 1 1] \"float scale\" -1",
        37,
        "negative",
    ),
    (
        "LightSource \"point\" \"blackbody I\" 100",
        21,
        "no temperature of a lamp",
    ),
    (
        "LightSource \"point\" \"blackbody I\" [1 2 3]",
        21,
        "temperature in kelvin",
    ),
    (
        "LightSource \"point\" \"spectrum I\" \"metal-Cu-k\"",
        21,
        "names no light",
    ),
    (
        "LightSource \"point\" \"spectrum I\" [400 0 700 0]",
        21,
        "no visible light",
    ),
    (
        "LightSource \"point\" \"float power\" 1e300",
        1,
        "three finite numbers",
    ),
    ("AreaLightSource \"neon\"", 17, "unknown area light"),
    (
        "AreaLightSource \"diffuse\" \"bool twosided\" \"maybe\"",
        27,
        "not true or false",
    ),
    ("Shape \"teapot\"", 7, "unknown shape \"teapot\""),
    ("Shape \"curve\"", 7, "not read here"),
    ("Shape \"trianglemesh\"", 1, "needs \"point3 P\""),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1]",
        22,
        "not a multiple of 3",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0]",
        1,
        "needs \"integer indices\"",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]",
        53,
        "multiple of 3",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
        53,
        "entry 2 of \"indices\" is 3",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 -1 2]",
        53,
        "entry 1 of \"indices\" is -1",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]",
        53,
        "1 entries for 3",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"point2 uv\" [0 0]",
        53,
        "1 entries for 3",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 NaN 1 0 0 0 1 0]",
        38,
        "not a finite number",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [0 0 1e200 1 0 0 0 1 0]",
        1,
        "beyond single precision",
    ),
    (
        "Shape \"sphere\" \"float radius\" 0",
        1,
        "radius 0; it must be above 0",
    ),
    ("Shape \"plymesh\"", 1, "needs \"string filename\""),
    (
        "Shape \"plymesh\" \"string filename\" \"none.ply\"",
        17,
        "cannot be read",
    ),
    ("Include \"none.pbrt\"", 9, "cannot be read"),
];

#[test]
fn faults_of_the_world_have_their_place() {
    for (text, column, words) in WORLD_FAULTS {
        let (l, c, message) = syntax(world_v4(text));
        assert!(message.contains(words), "{text:?}: {message}");
        // `Include` points at its directive.
        let column = if text.starts_with("Include") {
            1
        } else {
            column
        };
        assert_eq!((l, c), (3, column), "{text:?}: {message}");
    }
}

#[test]
fn bytes_that_are_no_text() {
    for (bytes, line, column) in [
        (&b"\x00\x01\x02"[..], 1, 1),
        (b"WorldBegin\nab\x00", 2, 3),
        (b"\x1f\x8b\x08\x00", 1, 4),
        (b"glTF\x02\x00\x00\x00", 1, 6),
        ("# \u{e9}\u{e9}\u{0}".as_bytes(), 1, 5),
    ] {
        let (l, c, message) = syntax(read_bytes(bytes));
        assert!(message.contains("not text"), "{message}");
        assert_eq!((l, c), (line, column), "{bytes:?}");
    }
}

/// Version 3 reads on past a parameter that it does not know, as pbrt-v3 does; version 4 stops.
#[test]
fn unknown_parameters_by_version() {
    let world = format!("Material \"matte\" \"rgb KD\" [1 0 0]\n{TRIANGLE}");
    let scene = world_v3(&world).unwrap();
    assert!(
        super::warnings(&scene)
            .contains("scene.pbrt:3:18: Material \"matte\" has no parameter \"KD\"")
    );
    let world = format!("{TRIANGLE} \"float thickness\" 3");
    assert!(matches!(
        world_v4(&world),
        Err(SceneError::Syntax { line: 3, .. })
    ));
}

#[test]
fn scenes_without_triangles_or_with_flat_ones() {
    let place = |result| match result {
        Err(SceneError::Content { message, .. }) => message,
        other => panic!("{other:?}"),
    };
    assert!(place(world_v4("")).contains("no triangles"));
    let flat = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0]";
    assert!(place(world_v4(flat)).contains("no triangles"));
    let scene = world_v4(&format!("{flat}\n{TRIANGLE}")).unwrap();
    assert_eq!(scene.triangles.len(), 1);
    assert!(super::warnings(&scene).contains("1 triangles without area"));
    assert!(super::warnings(&scene).contains("no lights"));
}

/// Messages stay short and printable whatever the text.
#[test]
fn messages_show_little_of_long_words() {
    let (.., message) = syntax(read_bytes("x".repeat(100_000).as_bytes()));
    assert!(message.len() < 200);
    let (.., message) = syntax(read_bytes("\u{1b}[31m".as_bytes()));
    assert!(!message.contains('\u{1b}'));
}
