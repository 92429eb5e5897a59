//! A room with a lamp and a small window, through which a sky shines in.

use crate::support::*;
use glam::Vec3;
use rrf_lights::{Environment, OwnLight};
use rrf_render::{Lights, ShadowRays};
use rrf_scene::Scene;

/// Plain shadow rays of each camera ray.
const PLAIN: u32 = 256;

/// Six by six metres, 2.5 high, with a window of one by one. Of the whole sky it lets through less than a
/// hundredth to most of the floor; lamp and sky are about as bright there.
fn room() -> (Scene, Lights) {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let walls = [
        [corner(-3.0, -3.0, 0.0), 6.0 * x, 6.0 * y],
        [corner(-3.0, -3.0, 2.5), 6.0 * x, 6.0 * y],
        [corner(-3.0, -3.0, 0.0), 6.0 * x, 2.5 * z],
        [corner(-3.0, 3.0, 0.0), 6.0 * x, 2.5 * z],
        [corner(3.0, -3.0, 0.0), 6.0 * y, 2.5 * z],
        [corner(-3.0, -3.0, 0.0), 6.0 * y, z],
        [corner(-3.0, -3.0, 2.0), 6.0 * y, 0.5 * z],
        [corner(-3.0, -3.0, 1.0), 2.5 * y, z],
        [corner(-3.0, 0.5, 1.0), 2.5 * y, z],
    ];
    let lamp = [corner(-0.2, -0.2, 2.4), 0.4 * y, 0.4 * x];
    let sky = OwnLight {
        name: "sky".into(),
        source: Environment::constant(Vec3::splat(3.0)).into(),
    };
    let lights = Lights {
        area: true,
        sources: vec![sky],
        ..Lights::default()
    };
    (scene(&walls, &[lamp], 5.0), lights)
}

/// Rays that learn where light comes from are unbiased, pixel by pixel against the path tracer and as a
/// whole against plain ones, which choose lights uniformly and look all over the sky. The noise comes
/// down to the bound, as it did not while all shadow rays looked all over the sky. Of plain rays too
/// few see the sky from a single pixel for a test of each.
#[test]
fn a_sky_through_a_window_down_to_a_bound() {
    let (scene, lights) = room();
    let bound = 0.002f32;
    let rays = ShadowRays {
        count: 2048,
        noise: Some(bound),
        ..ShadowRays::default()
    };
    let learned = frames_by(&scene, &lights, rays);
    assert_unbiased("window", &learned, &traced(&scene, &lights));
    let found = moments(&learned);
    let variance = found.iter().map(|(_, se2)| se2 * SEEDS as f64);
    let noise = (variance.sum::<f64>() / found.len() as f64).sqrt();
    // a variance that eight rays estimate sets the number of rays: a tenth is left for that
    assert!(noise < 1.1 * f64::from(bound), "{noise} over {bound}");
    let whole = |frames: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let sums = frames.iter().map(|frame| vec![frame.iter().sum()]);
        sums.collect()
    };
    let plain = whole(&frames(&scene, &lights, PLAIN, false));
    assert_unbiased("window, whole", &whole(&learned), &moments(&plain));
}
