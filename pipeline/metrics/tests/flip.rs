//! FLIP against its authors' program (`flip-evaluator`, see data/make_references.py).

#![allow(clippy::unwrap_used)]

use glam::DVec3;
use rrf_metrics::flip::{PIXELS_PER_DEGREE, flip};
use rrf_metrics::tone::srgb_decode;

fn linear(png: &[u8]) -> (Vec<DVec3>, usize) {
    let picture = image::load_from_memory(png).unwrap().to_rgb8();
    let decode = |byte: u8| f64::from(srgb_decode(f32::from(byte) / 255.0));
    let pixels = picture.pixels().map(|p| DVec3::from_array(p.0.map(decode)));
    (pixels.collect(), picture.width() as usize)
}

fn check(name: &str, reference: &[u8], test: &[u8], errors: &str) {
    let ((reference, width), (test, _)) = (linear(reference), linear(test));
    let got = flip(&reference, &test, width, PIXELS_PER_DEGREE);
    let want: Vec<f64> = errors
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(|line| line.split_whitespace().map(|x| x.parse::<f64>().unwrap()))
        .collect();
    assert_eq!(got.len(), want.len());
    let worst = got.iter().zip(&want).map(|(a, b)| (a - b).abs());
    let worst = worst.fold(0.0, f64::max);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let off = (mean(&got) - mean(&want)).abs();
    println!("{name}: worst pixel {worst:.2e}, mean {off:.2e}");
    assert!(worst < 1e-3 && off < 1e-4, "{name}: {worst} {off}");
}

macro_rules! check {
    ($name:literal) => {
        check(
            $name,
            include_bytes!(concat!("data/flip_", $name, "_reference.png")),
            include_bytes!(concat!("data/flip_", $name, "_test.png")),
            include_str!(concat!("data/flip_", $name, ".tsv")),
        )
    };
}

#[test]
fn equals_the_authors_program() {
    check!("same");
    check!("noisy");
    check!("shifted");
}

#[test]
fn is_symmetric() {
    let (a, width) = linear(include_bytes!("data/flip_noisy_reference.png"));
    let (b, _) = linear(include_bytes!("data/flip_noisy_test.png"));
    let there = flip(&a, &b, width, PIXELS_PER_DEGREE);
    assert_eq!(there, flip(&b, &a, width, PIXELS_PER_DEGREE));
}
