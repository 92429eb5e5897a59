//! OpenEXR files as other programs write them.

#![allow(clippy::unwrap_used)]

use glam::Vec3;
use rrf_metrics::Picture;
use rrf_render::exr::{self, Selection};
use std::path::PathBuf;

fn case(name: &str) -> PathBuf {
    let cases = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/cases/exr");
    cases.join(name)
}

fn read(name: &str) -> Picture {
    exr::read_exr(&case(name)).unwrap()
}

/// A smaller data window leaves black, a larger one is cut: the display window is compared.
#[test]
fn data_windows_are_placed() {
    let base = read("base.exr");
    for (name, least) in [("crop.exr", 0.1), ("overscan.exr", 1.0)] {
        let picture = read(name);
        let size = (picture.width, picture.height);
        assert_eq!(size, (base.width, base.height), "{name}");
        let pairs = || base.pixels.iter().zip(&picture.pixels);
        let same = pairs().filter(|(a, b)| a == b).count();
        assert!(pairs().all(|(a, b)| a == b || *b == Vec3::ZERO), "{name}");
        assert!(
            same as f64 >= least * base.pixels.len() as f64,
            "{name}: {same}"
        );
    }
}

#[test]
fn the_part_with_the_picture_is_found_or_named() {
    let path = case("multi2.exr");
    let base = read("base.exr");
    assert_eq!(exr::read_exr(&path).unwrap(), base);
    let part = |part| {
        exr::read_exr_part(
            &path,
            Selection {
                layer: "",
                part: Some(part),
            },
        )
    };
    assert_eq!(part("1").unwrap(), base);
    let refused = part("nowhere").unwrap_err();
    assert!(refused.is_bad_input());
    let message = refused.to_string();
    assert!(
        message.contains("no part \"nowhere\"; it has 0 \""),
        "{message}"
    );
    assert!(part("0").is_err());
}

/// A header's claim is held against the file before memory is taken.
#[test]
fn claimed_sizes_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let bytes = std::fs::read(case("base.exr")).unwrap();
    let find = |name: &[u8]| bytes.windows(name.len()).position(|w| w == name).unwrap();
    for (side, words) in [
        (99_999_i32, "each side may have"),
        (8_000, "truncated or damaged"),
    ] {
        let mut claimed = bytes.clone();
        for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            let at = find(name) + name.len() + 4 + 8;
            claimed[at..at + 8].copy_from_slice(&[side.to_le_bytes(); 2].concat());
        }
        std::fs::write(&path, claimed).unwrap();
        let message = exr::read_exr(&path).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
