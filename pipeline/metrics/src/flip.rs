//! FLIP for tone-mapped pictures (LDR-FLIP): the difference one sees when alternating two images.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A Difference
//! Evaluator for Alternating Images*, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020.
//! Section numbers below are that paper's.

use crate::color;
use crate::convolve::{Kernel, Plane, convolve};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Pixels per degree of vision at 0.7 m from a 0.7 m wide display of 3,840 pixels, the paper's.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Contrast sensitivity as sums of Gaussians (table 1): weights a and widths b [degrees²]
/// for the achromatic, red-green and blue-yellow channels.
const SENSITIVITY: [[(f64, f64); 2]; 3] = [
    [(1.0, 0.0047), (0.0, 1.0e-5)],
    [(1.0, 0.0053), (0.0, 1.0e-5)],
    [(34.1, 0.04), (13.5, 0.025)],
];

/// Exponent of the colour difference (sect. 4.1.3).
const COLOR_EXPONENT: f64 = 0.7;
/// Colour differences up to this share of the largest one ...
const KNEE: f64 = 0.4;
/// ... are spread over this share of [0, 1].
const KNEE_VALUE: f64 = 0.95;
/// Width of the features looked for [degrees] (sect. 4.2).
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f64 = 0.5;

/// FLIP of every pixel, in [0, 1]. `reference` and `test` are linear RGB in [0, 1], as shown
/// on the display, row-major, `width` pixels a row.
pub fn flip(reference: &[DVec3], test: &[DVec3], width: usize, pixels_per_degree: f64) -> Vec<f64> {
    let pictures = [reference, test].map(|picture| opponent(picture, width));
    let colors = [&pictures[0], &pictures[1]].map(|p| perceived(p, pixels_per_degree));
    let features = [&pictures[0], &pictures[1]].map(|p| features(&p[0], pixels_per_degree));
    let largest = largest_difference();
    (0..reference.len())
        .map(|i| {
            let color = color_difference(colors[0][i], colors[1][i], largest);
            let edge = (features[0].edges[i] - features[1].edges[i]).abs();
            let point = (features[0].points[i] - features[1].points[i]).abs();
            let feature = (edge.max(point) / 2f64.sqrt()).powf(FEATURE_EXPONENT);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// The picture in the linear opponent space YCxCz (sect. 4.1.1), a plane a channel.
fn opponent(picture: &[DVec3], width: usize) -> [Plane; 3] {
    let white = color::white();
    let pixels: Vec<[f64; 3]> = picture
        .iter()
        .map(|&rgb| {
            let t = color::xyz(rgb) / white;
            [116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z)]
        })
        .collect();
    [0, 1, 2].map(|c| Plane {
        width,
        values: pixels.iter().map(|p| p[c]).collect(),
    })
}

/// What the eye resolves of the picture, in CIELAB with a* and b* adjusted to the
/// luminance (Hunt; sect. 4.1.2 and 4.1.3).
fn perceived(picture: &[Plane; 3], pixels_per_degree: f64) -> Vec<DVec3> {
    let filtered: Vec<Plane> = picture
        .iter()
        .zip(SENSITIVITY)
        .map(|(plane, gaussians)| sensitivity_filter(plane, gaussians, pixels_per_degree))
        .collect();
    let (white, to_rgb) = (color::white(), color::xyz_to_rgb());
    (0..filtered[0].values.len())
        .map(|i| {
            let [y, cx, cz] = [0, 1, 2].map(|c: usize| filtered[c].values[i]);
            let y = (y + 16.0) / 116.0;
            let xyz = DVec3::new(y + cx / 500.0, y, y - cz / 200.0) * white;
            hunt(shown(xyz, to_rgb))
        })
        .collect()
}

/// The nearest colour that the display can show.
fn shown(xyz: DVec3, to_rgb: DMat3) -> DVec3 {
    color::xyz((to_rgb * xyz).clamp(DVec3::ZERO, DVec3::ONE))
}

/// CIELAB of XYZ with the chroma scaled by 0.01 L*.
fn hunt(xyz: DVec3) -> DVec3 {
    let lab = color::lab(xyz);
    let scale = 0.01 * lab.x;
    DVec3::new(lab.x, scale * lab.y, scale * lab.z)
}

/// One channel seen through its contrast sensitivity function: a weighted sum of Gaussian
/// blurs exp(−π² d² / b), d in degrees, the weights summing to 1 (eq. 3 and 4).
fn sensitivity_filter(plane: &Plane, gaussians: [(f64, f64); 2], pixels_per_degree: f64) -> Plane {
    let widest = SENSITIVITY
        .iter()
        .flatten()
        .map(|g| g.1)
        .fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let kernels = gaussians.map(|(a, b)| {
        let kernel = Kernel::new(radius, |x| {
            let degrees = x / pixels_per_degree;
            (-PI * PI * degrees * degrees / b).exp()
        });
        // The two-dimensional filter's sum is the square of the one-dimensional one's.
        let weight = a * (PI / b).sqrt() * kernel.sum().powi(2);
        (weight, kernel.normalized())
    });
    let total: f64 = kernels.iter().map(|k| k.0).sum();
    let mut out = Plane {
        width: plane.width,
        values: vec![0.0; plane.values.len()],
    };
    for (weight, kernel) in kernels.iter().filter(|k| k.0 > 0.0) {
        let blurred = convolve(plane, kernel, kernel);
        for (out, x) in out.values.iter_mut().zip(blurred.values) {
            *out += weight / total * x;
        }
    }
    out
}

/// Lengths of the edge and point responses of one picture.
struct Features {
    edges: Vec<f64>,
    points: Vec<f64>,
}

/// Edges and points by the first and second derivatives of a Gaussian (sect. 4.2),
/// on luminance scaled to [0, 1].
fn features(achromatic: &Plane, pixels_per_degree: f64) -> Features {
    let grey = Plane {
        width: achromatic.width,
        values: achromatic
            .values
            .iter()
            .map(|y| (y + 16.0) / 116.0)
            .collect(),
    };
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let blur = Kernel::new(radius, gaussian).normalized();
    let edge = Kernel::new(radius, |x| -x * gaussian(x)).normalized_by_sign();
    let point = Kernel::new(radius, |x| {
        (x * x / (deviation * deviation) - 1.0) * gaussian(x)
    })
    .normalized_by_sign();
    let length = |kernel: &Kernel| -> Vec<f64> {
        let x = convolve(&grey, kernel, &blur);
        let y = convolve(&grey, &blur, kernel);
        let pairs = x.values.iter().zip(&y.values);
        pairs.map(|(x, y)| x.hypot(*y)).collect()
    };
    Features {
        edges: length(&edge),
        points: length(&point),
    }
}

/// HyAB distance (Abasi, Tehran, Fairchild 2020) to the power of [`COLOR_EXPONENT`].
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    (d.x.abs() + d.y.hypot(d.z)).powf(COLOR_EXPONENT)
}

/// The largest colour difference a display can show: green against blue.
fn largest_difference() -> f64 {
    hyab(hunt(color::xyz(DVec3::Y)), hunt(color::xyz(DVec3::Z)))
}

/// The colour difference spread over [0, 1] (sect. 4.1.3).
fn color_difference(a: DVec3, b: DVec3, largest: f64) -> f64 {
    let difference = hyab(a, b);
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}
