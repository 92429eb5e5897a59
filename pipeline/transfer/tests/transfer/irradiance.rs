//! Irradiance against closed forms.

use crate::scenes::{cornell, room};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::Tracer;
use rrf_transfer::{
    DirectLight, DistantSource, IncidentLight, PatchConfig, Patches, PointSource, Receiver,
    ReceiverId, Receivers,
};

const EVEN: fn(Vec3) -> f32 = |_| 1.0;

fn config(count: usize) -> PatchConfig {
    PatchConfig {
        count,
        ..PatchConfig::default()
    }
}

/// A closed room takes in all that a light inside it sends out: 4 pi W for 1 W/sr. So does each
/// side on its own: the outer ones get nothing.
#[test]
fn a_room_takes_in_what_its_light_sends_out() {
    let scene = room(Vec3::ZERO, Vec3::new(3.0, 2.0, 4.0), Vec3::ONE);
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &config(2_000), &EVEN).unwrap();
    let receivers = Receivers::new(&tracer, &patches, 8, None, Stream::new(1, Stage::Test, 0));
    for position in [Vec3::new(1.5, 1.0, 2.0), Vec3::new(0.4, 1.7, 3.2)] {
        let light = PointSource {
            position,
            intensity: Vec3::new(1.0, 2.0, 0.0),
        };
        let irradiance = receivers.irradiance(&light);
        let mut flux = [Vec3::ZERO; 2];
        for patch in 0..patches.len() as u32 {
            for back in [false, true] {
                let e = irradiance[patches.first_column(patch, back) as usize];
                flux[usize::from(back)] += e * patches.area[patch as usize];
            }
        }
        let inside = flux[0].x.max(flux[1].x);
        assert!(
            (inside / (4.0 * std::f32::consts::PI) - 1.0).abs() < 2e-3,
            "{inside}"
        );
        assert_eq!(flux[0].x.min(flux[1].x), 0.0);
        assert!((flux[0].y - 2.0 * flux[0].x).abs() <= 1e-4 * inside && flux[0].z == 0.0);
    }
}

/// Far from a light, a patch's irradiance is that of its centre; a box casts its shadow.
#[test]
fn shadows_and_cosines() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &config(4_000), &EVEN).unwrap();
    let receivers = Receivers::new(&tracer, &patches, 4, None, Stream::new(1, Stage::Test, 0));
    let position = Vec3::new(0.0, 1.9, 0.0);
    let intensity = Vec3::ONE;
    let irradiance = receivers.irradiance(&PointSource {
        position,
        intensity,
    });
    let at = |place: Vec3, normal: Vec3| {
        let point = tracer.locate(place, normal).unwrap();
        let back = point.normal.dot(normal) < 0.0;
        let patch = patches.patch(&point).unwrap();
        irradiance[patches.first_column(patch, back) as usize].x
    };
    for place in [Vec3::new(-0.1, 0.0, 0.5), Vec3::new(0.9, 0.0, -0.8)] {
        let to = position - place;
        let expected = to.y / to.length().powi(3);
        let found = at(place, Vec3::Y);
        assert!(
            (found / expected - 1.0).abs() < 0.05,
            "{place}: {found} {expected}"
        );
    }
    // under the short box, and behind the tall one
    assert_eq!(at(Vec3::new(0.33, 0.0, 0.37), Vec3::Y), 0.0);
    assert_eq!(at(Vec3::new(-0.5, 0.0, -0.98), Vec3::Y), 0.0);
}

/// A kind of light that the crate does not know.
struct Own;

impl DirectLight for Own {
    fn arrivals(&self, _: &Receiver, _: ReceiverId, arrive: &mut dyn FnMut(IncidentLight)) {
        let normal_irradiance = Vec3::splat(3.0);
        arrive(IncidentLight::straight(
            Vec3::Z,
            f32::INFINITY,
            normal_irradiance,
        ));
    }
}

/// Lights far away, and lights of other kinds; only the columns in use are asked for.
#[test]
fn other_lights_and_columns_in_use() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let patches = Patches::new(&scene, &config(500), &EVEN).unwrap();
    let stream = Stream::new(1, Stage::Test, 0);
    let all = Receivers::new(&tracer, &patches, 4, None, stream);
    assert_eq!(all.sides(), 2 * patches.len());
    // through the open front, straight at the back wall
    let sun = DistantSource {
        toward: Vec3::Z,
        irradiance: Vec3::splat(3.0),
    };
    let lit = all.irradiance(&sun);
    let place = tracer.locate(Vec3::new(0.0, 1.8, -1.0), Vec3::Z).unwrap();
    let back = place.normal.z < 0.0;
    let column = patches.first_column(patches.patch(&place).unwrap(), back) as usize;
    assert!((lit[column] - Vec3::splat(3.0)).abs().max_element() < 1e-4);
    assert_eq!(all.irradiance(&Own), lit);
    let used: Vec<bool> = (0..patches.columns()).map(|c| c == column).collect();
    let few = Receivers::new(&tracer, &patches, 4, Some(&used), stream);
    assert_eq!(few.sides(), 1);
    assert_eq!(few.irradiance(&sun)[column], lit[column]);
}
