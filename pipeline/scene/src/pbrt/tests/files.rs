//! Files that a scene names: includes, meshes, pictures.

use super::{TRIANGLE, warnings};
use crate::{INVALID, LoadOptions, Scene, SceneError, load};
use glam::{Vec2, Vec3};
use std::fs;
use tempfile::TempDir;

/// Reads `scene.pbrt` beside other files.
pub(super) fn read(scene: &str, others: &[(&str, &[u8])]) -> (Result<Scene, SceneError>, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in others {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let path = folder.path().join("scene.pbrt");
    fs::write(&path, scene).unwrap();
    (load(&path, &LoadOptions::default()), folder)
}

pub(super) fn error(scene: &str, others: &[(&str, &[u8])]) -> String {
    read(scene, others).0.unwrap_err().to_string()
}

#[test]
fn includes_are_relative_to_their_file() {
    let inner = format!("Include \"deeper.pbrt\"\n{TRIANGLE}");
    let (scene, _folder) = read(
        "WorldBegin Include \"parts/inner.pbrt\" Import \"parts/deeper.pbrt\"",
        &[
            ("parts/inner.pbrt", inner.as_bytes()),
            ("parts/deeper.pbrt", TRIANGLE.as_bytes()),
        ],
    );
    assert_eq!(scene.unwrap().triangles.len(), 3);
}

/// `Include` leaves its changes of state behind, `Import` takes them back.
#[test]
fn state_after_include_and_import() {
    let shifted = |word: &str| {
        let text = format!("WorldBegin {word} \"shift.pbrt\" {TRIANGLE}");
        let (scene, _folder) = read(&text, &[("shift.pbrt", b"Translate 0 0 5")]);
        scene.unwrap().positions[0].z
    };
    assert_eq!(shifted("Include"), 5.0);
    assert_eq!(shifted("Import"), 0.0);
}

#[test]
fn faults_in_included_files() {
    let cycle = error(
        "WorldBegin\n  Include \"a.pbrt\"",
        &[("a.pbrt", b"\nInclude \"scene.pbrt\"")],
    );
    assert!(
        cycle.contains("a.pbrt:2:1") && cycle.contains("includes itself"),
        "{cycle}"
    );
    let open = error(
        "WorldBegin Include \"a.pbrt\" AttributeEnd",
        &[("a.pbrt", b" AttributeBegin")],
    );
    assert!(
        open.contains("a.pbrt:1:2") && open.contains("no AttributeEnd"),
        "{open}"
    );
    let folder = error("WorldBegin Include \"a\"", &[("a/b", b"")]);
    assert!(folder.contains("not a regular file"), "{folder}");
    let chain: Vec<(String, Vec<u8>)> = (0..40)
        .map(|i| {
            (
                format!("f{i}.pbrt"),
                format!("Include \"f{}.pbrt\"", i + 1).into_bytes(),
            )
        })
        .collect();
    let chain: Vec<(&str, &[u8])> = chain
        .iter()
        .map(|(n, b)| (n.as_str(), b.as_slice()))
        .collect();
    let deep = error("WorldBegin Include \"f0.pbrt\"", &chain);
    assert!(deep.contains("more than 32 deep"), "{deep}");
}

/// Files that double at each of 25 levels: 33 million includes are not followed.
#[test]
fn include_bomb() {
    let files: Vec<(String, Vec<u8>)> = (0..25)
        .map(|i| {
            (
                format!("f{i}.pbrt"),
                format!("Include \"f{0}.pbrt\" Include \"f{0}.pbrt\"", i + 1).into_bytes(),
            )
        })
        .chain([("f25.pbrt".to_owned(), Vec::new())])
        .collect();
    let files: Vec<(&str, &[u8])> = files
        .iter()
        .map(|(n, b)| (n.as_str(), b.as_slice()))
        .collect();
    let bomb = error("WorldBegin Include \"f0.pbrt\"", &files);
    assert!(bomb.contains("files are included"), "{bomb}");
}

#[test]
fn endings_and_missing_files() {
    let missing = load("nowhere.pbrt".as_ref(), &LoadOptions::default()).unwrap_err();
    assert!(
        matches!(missing, SceneError::Io { .. }) && missing.to_string().contains("nowhere.pbrt")
    );
    let unknown = load("scene.usd".as_ref(), &LoadOptions::default()).unwrap_err();
    assert!(matches!(unknown, SceneError::UnknownFormat { .. }));
}

/// Two triangles as a quad, with normals, coordinates and things to pass over.
fn ply(format: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement junk 2\nproperty list uchar short values\n\
         element vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
         element face 2\nproperty list uchar int vertex_indices\nproperty int material\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0f32]];
    if format == "ascii" {
        bytes.extend(b"2 7 -8\n0\n");
        for [x, y] in vertices {
            bytes.extend(format!("{x} {y} 2.5 9 0 0 1 {x} {y}\n").bytes());
        }
        bytes.extend(b"4 0 1 2 3 5\n3 0 1 2 -6\n");
        return bytes;
    }
    let big = format.contains("big");
    let mut put = |mut number: Vec<u8>| {
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    put(vec![2]);
    put(7i16.to_le_bytes().to_vec());
    put((-8i16).to_le_bytes().to_vec());
    put(vec![0]);
    for [x, y] in vertices {
        put(x.to_le_bytes().to_vec());
        put(y.to_le_bytes().to_vec());
        put(2.5f64.to_le_bytes().to_vec());
        put(vec![9]);
        for value in [0.0, 0.0, 1.0, x, y] {
            put(value.to_le_bytes().to_vec());
        }
    }
    for (corners, material) in [(&[0, 1, 2, 3][..], 5), (&[0, 1, 2], -6)] {
        put(vec![corners.len() as u8]);
        for corner in corners.iter().chain([&material]) {
            put(i32::to_le_bytes(*corner).to_vec());
        }
    }
    bytes
}

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];
const PLY_SCENE: &str = "WorldBegin Shape \"plymesh\" \"string filename\" \"mesh.ply\"";

#[test]
fn ply_in_three_formats() {
    for format in FORMATS {
        let (scene, _folder) = read(PLY_SCENE, &[("mesh.ply", &ply(format))]);
        let scene = scene.unwrap();
        assert_eq!(
            scene.triangles,
            [[0, 1, 2], [0, 2, 3], [0, 1, 2]],
            "{format}"
        );
        assert_eq!(scene.positions[2], Vec3::new(1.0, 1.0, 2.5));
        assert_eq!(scene.normals, [Vec3::Z; 4]);
        assert_eq!(scene.uvs[3], Vec2::new(0.0, 1.0));
    }
}

#[test]
fn ply_truncated_at_every_byte() {
    for format in FORMATS {
        let whole = ply(format);
        // The last ASCII number may lose its last digits and stay a number.
        let end = whole.len() - if format == "ascii" { 3 } else { 0 };
        for cut in 0..end {
            let folder = "mesh.ply".as_ref();
            let result = super::super::ply::read(folder, &whole[..cut]);
            let Err(SceneError::Content { place, .. }) = result else {
                panic!("{format} {cut}")
            };
            assert!(
                place.starts_with("header") || place.contains(' '),
                "{place}"
            );
        }
    }
}

#[test]
fn ply_faults() {
    let simple = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{vertices}\n{faces}\n"
        )
    };
    for (text, words) in [
        (
            simple("0 0 0 1 0 0 0 1 0", "3 0 1 3"),
            "face 0: vertex index 3, but there are 3",
        ),
        (
            simple("0 0 0 1 0 0 0 1 0", "3 0 1 -1"),
            "face 0: vertex index -1",
        ),
        (simple("0 0 0 1 0 0 0 1 0", "3 0 1 1.5"), "no whole number"),
        (simple("0 0 0 1 0 0 0 1 0", "3 0 1 nan"), "no whole number"),
        (
            simple("0 0 0 1 0 0 0 1 0", "2 0 1"),
            "2 corners; 3 to 16384",
        ),
        (simple("0 0 0 1 0 0 0 1 0", "0"), "0 corners"),
        (
            simple("0 0 0 1 nan 0 0 1 0", "3 0 1 2"),
            "vertex 1: NaN is not a finite number",
        ),
        (
            simple("0 0 0 1 x 0 0 1 0", "3 0 1 2"),
            "vertex 1: its data end or are no numbers",
        ),
        (
            simple("0 0 0", "").replace("vertex 3", "vertex 99999999999999"),
            "vertex 1: its data end",
        ),
        (
            simple("0 0 0 1 0 0 0 1 0", "").replace("face 1", "face 0"),
            "no faces",
        ),
        ("not ply\n".to_owned(), "header line 1"),
        (
            "ply\nformat binary 1.0\n".to_owned(),
            "unknown format `binary`",
        ),
        (
            "ply\nelement vertex many\n".to_owned(),
            "`many` is no count",
        ),
        ("ply\nproperty float x\n".to_owned(), "before any element"),
        (
            "ply\nelement a 1\nproperty list float int x\n".to_owned(),
            "cannot be a fraction",
        ),
        (
            "ply\nelement a 1\nproperty quad x\n".to_owned(),
            "unknown type `quad`",
        ),
        ("ply\nend_header\n".to_owned(), "no format line"),
    ] {
        let message = error(PLY_SCENE, &[("mesh.ply", text.as_bytes())]);
        assert!(
            message.contains("mesh.ply: ") && message.contains(words),
            "{message}"
        );
    }
}

/// A picture of 2 x 1 texels.
fn png(texels: [[u8; 3]; 2]) -> Vec<u8> {
    let mut picture = image::RgbImage::new(2, 1);
    for (x, texel) in texels.into_iter().enumerate() {
        picture.put_pixel(x as u32, 0, image::Rgb(texel));
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// sRGB decoding: 188 is 0.5029 linear (IEC 61966-2-1: ((188/255 + 0.055) / 1.055)^2.4).
#[test]
fn pictures_are_decoded_and_mapped() {
    let files: [(&str, &[u8]); 1] = [("a.png", &png([[0, 255, 188], [255, 255, 188]]))];
    let text = |texture: &str| {
        format!(
            "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" {texture} \
             Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"rgb scale\" [.5 1 1] \
             Material \"diffuse\" \"texture reflectance\" \"s\" {TRIANGLE}"
        )
    };
    let (scene, _folder) = read(&text("\"float uscale\" 3 \"float vdelta\" .5"), &files);
    let scene = scene.unwrap();
    let texture = &scene.textures[scene.materials[0].base_texture as usize];
    assert_eq!((texture.width, texture.height), (2, 1));
    assert!(
        (texture.texels[0] - Vec3::new(0.0, 1.0, 0.50289))
            .abs()
            .max_element()
            < 1e-4
    );
    assert_eq!(scene.materials[0].base_color, Vec3::new(0.5, 1.0, 1.0));
    // pbrt's own coordinates of a mesh without any, mapped.
    assert_eq!(
        scene.uvs,
        [
            Vec2::new(0.0, 0.5),
            Vec2::new(3.0, 0.5),
            Vec2::new(3.0, 1.5)
        ]
    );
    let (scene, _folder) = read(
        &text("\"string encoding\" \"linear\" \"bool invert\" true"),
        &files,
    );
    let texel = scene.unwrap().textures[0].texels[0];
    assert!(
        (texel - Vec3::new(1.0, 0.0, 67.0 / 255.0))
            .abs()
            .max_element()
            < 1e-6,
        "{texel}"
    );
    // A scale above 1 goes into the texels, which are then clamped with a warning.
    let (scene, _folder) = read(&text("\"float scale\" 4"), &files);
    let scene = scene.unwrap();
    assert!(
        warnings(&scene).contains("texels clamped"),
        "{}",
        warnings(&scene)
    );
    // Another mapping: the mean colour.
    let (scene, _folder) = read(&text("\"string mapping\" \"spherical\""), &files);
    let material = scene.unwrap().materials[0].clone();
    assert_eq!(material.base_texture, INVALID);
    assert!((material.base_color.x - 0.25).abs() < 1e-6);
}

#[test]
fn normal_maps_stay_linear() {
    let files: [(&str, &[u8]); 1] = [("n.png", &png([[128, 128, 255]; 2]))];
    let text = format!("WorldBegin Material \"diffuse\" \"string normalmap\" \"n.png\" {TRIANGLE}");
    let (scene, _folder) = read(&text, &files);
    let scene = scene.unwrap();
    let map = &scene.textures[scene.materials[0].normal_texture as usize];
    assert!((map.texels[0].x - 128.0 / 255.0).abs() < 1e-6);
}

#[test]
fn broken_pictures() {
    let text = format!(
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\"\n{TRIANGLE}"
    );
    let whole = png([[1, 2, 3]; 2]);
    for cut in [0, 10, whole.len() / 2, whole.len() - 20] {
        let message = error(&text, &[("a.png", &whole[..cut])]);
        assert!(
            message.contains("scene.pbrt:1:") && message.contains("cannot be read"),
            "{message}"
        );
    }
}

#[test]
fn spectra_from_files() {
    let text = format!(
        "WorldBegin Material \"conductor\" \"spectrum eta\" \"eta.spd\" \"spectrum k\" \"k.spd\" {TRIANGLE}"
    );
    let (scene, _folder) = read(
        &text,
        &[
            ("eta.spd", b"# glass\n400 1.5\n700 1.5\n"),
            ("k.spd", b"400 0 700 0"),
        ],
    );
    let own = scene.unwrap().materials[0].own.clone();
    assert_eq!((own[0].value, own[1].value), (Vec3::splat(1.5), Vec3::ZERO));
    let message = error(&text, &[("eta.spd", b"400 x"), ("k.spd", b"400 0")]);
    assert!(
        message.contains("eta.spd: `x` is not a number"),
        "{message}"
    );
}
