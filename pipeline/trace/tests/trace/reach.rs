//! Which lights from afar reach what eyes see.

use crate::scenes::{Builder, lambert};
use glam::Vec3;
use rrf_lights::{DistantLight, Environment, LightSource};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::Tracer;

/// A room of 4 x 3 x 4 with a wall of two parts at x = 2: they leave a gap of 0.3 or none.
fn room(gap: f32) -> Scene {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::splat(0.5)));
    let (x, y, z) = (4.0 * Vec3::X, 3.0 * Vec3::Y, 4.0 * Vec3::Z);
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    for [at, a, b] in [
        [corner, x, z],
        [corner + y, x, z],
        [corner, y, z],
        [corner, x, y],
        [corner + z, x, y],
        [corner + x, (1.5 - gap) * Vec3::Y, z],
        [corner + x + 1.5 * Vec3::Y, 1.5 * Vec3::Y, z],
    ] {
        builder.quad(at, a, b, white, INVALID);
    }
    builder.scene
}

#[test]
fn a_gap_lets_in_the_sky_and_the_suns_beyond_it() {
    let sun = |x: f32, y: f32| {
        LightSource::from(DistantLight {
            toward: Vec3::new(x, y, 0.0).normalize(),
            irradiance: Vec3::ONE,
            diameter: 0.0,
        })
    };
    let sky = Environment::constant(Vec3::ONE).into();
    let sources = [
        sun(1.0, 0.5),
        sun(-1.0, 0.5),
        sun(1.0, -0.5),
        sun(0.0, -1.0),
        sky,
    ];
    let sources: Vec<&LightSource> = sources.iter().collect();
    let stream = Stream::new(1, Stage::Test, 0);
    for (gap, wanted) in [(0.3, [true, false, true, false, true]), (0.0, [false; 5])] {
        let scene = room(gap);
        let tracer = Tracer::new(&scene).unwrap();
        let eyes = [Vec3::new(-1.0, 1.0, 0.0), Vec3::new(0.0, 2.0, 1.0)];
        assert_eq!(tracer.reached(&eyes, &sources, stream), wanted, "{gap}");
        assert_eq!(tracer.reached(&[], &sources, stream), [false; 5]);
    }
}
