//! OpenEXR and PNG files: what was written is what is read.

#![allow(clippy::unwrap_used)]

use glam::Vec3;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, RenderError, exr, png};

fn frame() -> Frame {
    let (width, height) = (37, 21);
    let count = width * height;
    let layer = |k: f32| -> Vec<Vec3> {
        let pixel = |i: u32| Vec3::new(i as f32, k, -0.1 * i as f32 + k);
        (0..count).map(pixel).collect()
    };
    Frame {
        width,
        height,
        full: layer(0.0),
        direct: Some(layer(1.0)),
        indirect: Some(layer(1e-20)),
        cell: Some(
            (0..count)
                .map(|i| if i == 5 { u32::MAX } else { i * 5_000_000 })
                .collect(),
        ),
        trust: Some((0..count).map(|i| (i % 5) as f32 / 4.0).collect()),
        attributes: vec![
            ("rrf.lights".to_string(), "0,1,2 π".to_string()),
            ("rrf.version".to_string(), "0.1.0".to_string()),
        ],
        albedo: Some(layer(0.5)),
        normal: Some(layer(0.3)),
        depth: Some((0..count).map(|i| 1e10 / (1 + i) as f32).collect()),
    }
}

#[test]
fn a_frame_survives_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.exr");
    let mut frame = frame();
    exr::write_exr(&path, &frame).unwrap();
    let read = exr::read_exr_frame(&path).unwrap();
    // OpenEXR text is Latin-1: the Greek letter is escaped.
    frame.attributes[0].1 = "0,1,2 \\u{3c0}".to_string();
    assert!(read == frame, "{:?}", read.attributes);
    assert_eq!(exr::read_exr(&path).unwrap(), frame.picture());
    let direct = exr::read_exr_layer(&path, "direct").unwrap();
    assert_eq!(Some(direct.pixels), frame.direct);
    // Two writes, the same bytes; nothing else left in the folder.
    let first = std::fs::read(&path).unwrap();
    exr::write_exr(&path, &frame).unwrap();
    assert!(first == std::fs::read(&path).unwrap(), "the same bytes");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_cannot_be_read_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.exr");
    let missing = exr::read_exr(&path).unwrap_err();
    assert!(matches!(missing, RenderError::Read { .. }), "{missing}");
    assert!(missing.is_bad_input());

    exr::write_exr(&path, &frame()).unwrap();
    let layer = exr::read_exr_layer(&path, "diffuse").unwrap_err();
    assert!(
        layer
            .to_string()
            .contains("no channel diffuse.R; it has B, G, R, Z, albedo.B")
    );

    let bytes = std::fs::read(&path).unwrap();
    for length in [0, 1, 4, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let cut = exr::read_exr(&path).unwrap_err();
        assert!(matches!(cut, RenderError::Read { .. }), "{length}: {cut}");
    }
    // Any one byte of the header or of the first pixels damaged: an error or a picture, no panic.
    for at in 0..bytes.len().min(2000) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        std::fs::write(&path, damaged).unwrap();
        let _ = exr::read_exr(&path);
    }
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none").join("frame.exr");
    let refused = exr::write_exr(&path, &frame()).unwrap_err();
    assert!(matches!(refused, RenderError::Write { .. }));
    assert!(refused.is_bad_input());
    let path = folder.path().join("frame.png");
    std::fs::create_dir(&path).unwrap();
    let shown = png::cell_map(&frame());
    assert!(png::write_png(&path, &shown).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let mut short = frame();
    short.full.pop();
    assert!(exr::write_exr(&folder.path().join("short.exr"), &short).is_err());
}

#[test]
fn a_png_shows_the_exposed_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.png");
    let mut frame = frame();
    frame.full[0] = Vec3::new(0.25, 0.5, 4.0);
    let shown = png::tone_mapped(&frame.picture(), Exposure { ev: -1.0 });
    png::write_png(&path, &shown).unwrap();
    let read = image::open(&path).unwrap().to_rgb8();
    assert_eq!(read.dimensions(), (37, 21));
    // sRGB of 0.125, 0.25 and 2 (clipped): 99, 137, 255 (IEC 61966-2-1).
    assert_eq!(read.get_pixel(0, 0).0, [99, 137, 255]);
    assert_eq!(png::contact_sheet(&[], 3).dimensions(), (8, 8));
    let sheet = png::contact_sheet(&[shown.clone(), shown.clone(), shown], 2);
    assert_eq!(sheet.dimensions(), (8 + 2 * 45, 8 + 2 * 29));
}
