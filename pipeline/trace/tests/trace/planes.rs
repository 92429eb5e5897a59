//! Two planes: a small patch that looks at a wide one, on which a point light shines.

use crate::scenes::{Builder, lambert};
use crate::statistics::assert_z;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::INVALID;
use rrf_trace::{Estimator, Queries, Sampling, Tracer, indirect_with};

/// The light at height g on the axis lights the plane z = 0 with I g / (g^2 + r^2)^(3/2); the plane
/// (albedo b) sends the share b / pi of it to the patch (albedo a) at height h > g:
///
///   E = b I g h^2 Int_0^inf 2 r dr / ((g^2 + r^2)^(3/2) (h^2 + r^2)^2)
///
/// With u^2 = g^2 + r^2 and k^2 = h^2 - g^2 the integral is Int_g^inf 2 du / (u^2 (u^2 + k^2)^2), which
/// partial fractions turn into 1 / u^2, 1 / (u^2 + k^2) and 1 / (u^2 + k^2)^2.
fn radiance(a: f64, b: f64, g: f64, h: f64) -> f64 {
    let k2 = h * h - g * g;
    let k = k2.sqrt();
    let once = (std::f64::consts::FRAC_PI_2 - (g / k).atan()) / k;
    let twice = (once - g / (h * h)) / (2.0 * k2);
    let integral = 2.0 * ((1.0 / g - once) / (k2 * k2) - twice / k2);
    a / std::f64::consts::PI * b * g * h * h * integral
}

/// The closed form against a sum over rings.
#[test]
fn the_integral_is_right() {
    let (g, h) = (0.4, 1.1);
    let steps = 2_000_000;
    let sum: f64 = (0..steps)
        .map(|i| {
            // r = x / (1 - x) reaches infinity.
            let x = (f64::from(i) + 0.5) / f64::from(steps);
            let (r, dr) = (x / (1.0 - x), 1.0 / ((1.0 - x) * (1.0 - x)));
            2.0 * r * dr / ((g * g + r * r).powf(1.5) * (h * h + r * r).powi(2))
        })
        .sum::<f64>()
        / f64::from(steps);
    let truth = 1.0 / std::f64::consts::PI * g * h * h * sum;
    assert!((radiance(1.0, 1.0, g, h) / truth - 1.0).abs() < 1e-9);
}

#[test]
fn a_patch_sees_a_lit_plane() {
    let (a, b) = (Vec3::new(0.9, 0.5, 0.3), Vec3::new(0.2, 0.6, 1.0));
    let mut tests = Vec::new();
    for (g, h) in [(0.02f32, 1.0f32), (0.4, 1.1), (0.9, 1.0)] {
        for estimator in [Estimator::Connected, Estimator::NextEvent] {
            tests.push((g, h, estimator));
        }
    }
    for &(g, h, estimator) in &tests {
        let mut builder = Builder::default();
        let patch = builder.material(lambert(a));
        let plane = builder.material(lambert(b));
        // Beyond 30 heights the plane adds less than 30^-5.
        let corner = Vec3::new(-30.0, -30.0, 0.0);
        builder.quad(corner, Vec3::X * 60.0, Vec3::Y * 60.0, plane, INVALID);
        // So small that what it sends back to the plane does not count (1e-6).
        let corner = Vec3::new(-0.001, -0.001, h);
        builder.quad(corner, Vec3::Y * 0.002, Vec3::X * 0.002, patch, INVALID);
        let scene = builder.scene;
        let tracer = Tracer::new(&scene).unwrap();
        let point = tracer.locate(Vec3::new(0.0, 0.0, h), Vec3::NEG_Z).unwrap();
        let queries = Queries {
            points: &[point],
            viewers: &[Vec3::new(0.8, 0.0, -0.6)],
            lights: &[Vec3::new(0.0, 0.0, g)],
        };
        let sampling = Sampling {
            paths: 65_536,
            replicates: 64,
        };
        let stream = Stream::new(61, Stage::Test, 0);
        let found = indirect_with(&tracer, queries, sampling, estimator, stream, 0).unwrap();
        let truth = (0..3)
            .map(|c| radiance(f64::from(a[c]), f64::from(b[c]), f64::from(g), f64::from(h)) as f32);
        let truth = Vec3::from_slice(&truth.collect::<Vec<f32>>());
        // 64 replicates: Student's t, whose tail at the limit is a quarter longer.
        let (mean, error) = (found.mean(0), 1.25 * found.standard_error(0));
        let name = format!("light {g}, patch {h}, {estimator:?}");
        assert_z(&name, mean, error, truth, 2e-5, tests.len());
    }
}
