//! Colour differences against published data and a second implementation.

#![allow(clippy::unwrap_used)]

use glam::DVec3;
use rrf_metrics::color::{delta_e_2000, delta_e_ab, lab, xyz};
use rrf_metrics::tone::Exposure;
use rrf_metrics::{MetricsError, Picture, compare};

fn table(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| {
        line.split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect()
    })
    .collect()
}

#[test]
fn ciede2000_reproduces_the_published_pairs() {
    let rows = table(include_str!("data/ciede2000_sharma.tsv"));
    assert_eq!(rows.len(), 34);
    for row in rows {
        let (a, b) = (DVec3::from_slice(&row), DVec3::from_slice(&row[3..]));
        // Published to four decimals.
        for difference in [delta_e_2000(a, b), delta_e_2000(b, a)] {
            assert!(
                (difference - row[6]).abs() <= 5.01e-5,
                "{row:?}: {difference}"
            );
        }
    }
}

#[test]
fn cielab_and_differences_equal_colour_science() {
    let rows = table(include_str!("data/colour_science.tsv"));
    assert_eq!(rows.len(), 40);
    for row in rows {
        let labs = [0, 3].map(|at| lab(xyz(DVec3::from_slice(&row[at..]))));
        for (lab, at) in labs.iter().zip([6, 9]) {
            let want = DVec3::from_slice(&row[at..]);
            assert!(lab.abs_diff_eq(want, 1e-6), "{lab} {want}");
        }
        assert!((delta_e_ab(labs[0], labs[1]) - row[12]).abs() < 1e-6);
        assert!((delta_e_2000(labs[0], labs[1]) - row[13]).abs() < 1e-6);
    }
}

fn picture(pixels: Vec<[f32; 3]>, width: u32) -> Picture {
    Picture {
        width,
        height: pixels.len() as u32 / width,
        pixels: pixels.into_iter().map(Into::into).collect(),
    }
}

#[test]
fn measures_follow_their_definitions() {
    // Greys 1 and 0.01 (below epsilon = 0.05 * 0.505), the test picture off by 0.1 and 0.02.
    let reference = picture(vec![[1.0; 3], [0.01; 3]], 2);
    let test = picture(vec![[1.1; 3], [0.03; 3]], 2);
    let got = compare(&reference, &test, Some(Exposure { ev: -1.0 })).unwrap();
    let epsilon: f64 = 0.05 * 0.505;
    let relative = ((0.1f64.powi(2) + (0.02 / epsilon).powi(2)) / 2.0).sqrt();
    let rel_mse = (0.01 / 1.01 + 0.0004 / 0.0101) / 2.0;
    let l = |y: f64| 116.0 * y.cbrt() - 16.0;
    let delta_e =
        (((l(0.55) - l(0.5)).powi(2) + (l(0.015) - 903.296_296_3 * 0.005).powi(2)) / 2.0).sqrt();
    for (name, want) in [
        ("relative_error", relative),
        ("rel_mse", rel_mse),
        ("delta_e_ab", delta_e),
    ] {
        let value = got.value(name).unwrap();
        // The pixels are f32: 0.1 and 0.02 are differences of rounded numbers.
        assert!((value / want - 1.0).abs() < 1e-5, "{name}: {value} {want}");
    }
    assert!((got.epsilon / epsilon - 1.0).abs() < 1e-5);
    assert_eq!(got.exposure.ev, -1.0);
}

#[test]
fn equal_pictures_differ_by_nothing() {
    let pixels = (0..64).map(|i| [0.02 * i as f32, 0.5, 1.0 / (1.0 + i as f32)]);
    let picture = picture(pixels.collect(), 8);
    for measure in compare(&picture, &picture, None).unwrap().measures {
        assert_eq!(measure.value, 0.0, "{}", measure.name);
    }
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    let good = picture(vec![[1.0; 3]; 6], 3);
    let tall = picture(vec![[1.0; 3]; 6], 2);
    let refused = compare(&good, &tall, None).unwrap_err();
    assert!(refused.to_string().contains("3x2 and 2x3"), "{refused}");

    let mut bad = good.clone();
    bad.pixels[4].y = f32::NAN;
    let refused = compare(&good, &bad, None).unwrap_err();
    assert!(matches!(
        refused,
        MetricsError::NotFinite { picture: "tested", x: 1, y: 1, value } if value.is_nan()
    ));
    bad.pixels[4].y = f32::INFINITY;
    let refused = compare(&bad, &good, None).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("reference picture has inf at x 1, y 1")
    );

    let black = picture(vec![[0.0; 3]; 6], 3);
    let refused = compare(&black, &good, None).unwrap_err();
    assert!(matches!(refused, MetricsError::BlackReference));
    let none = Picture::default();
    let refused = compare(&none, &none, None).unwrap_err();
    assert!(matches!(refused, MetricsError::Empty));
}
