//! Rooms whose light has no finite sum.

use crate::error::BakeError;
use glam::Vec3;
use rrf_lights::uniform_sphere;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, Tracer};

/// Places and directions from each that are tried.
const TRIED: u32 = 64;
/// A reflectance that is counted as that of all light.
const ALL: f32 = 0.999;

/// Refuses a closed room of which no surface absorbs light: its radiance has no finite value. `place`
/// gives a place of the free space by three numbers in [0, 1); `named` says what space.
pub(crate) fn refuse_endless(
    scene: &Scene,
    tracer: &Tracer,
    named: &str,
    place: impl Fn([f32; 3]) -> Vec3,
) -> Result<(), BakeError> {
    let reflects_all = |&id: &u32| {
        scene.materials.get(id as usize).is_some_and(|m| {
            let closes = !m.kind.transmits && !m.opacity.lets_through();
            closes && m.base_texture == INVALID && m.base_color.max_element() >= ALL
        })
    };
    if !scene.triangle_material.iter().all(reflects_all) {
        return Ok(());
    }
    let stream = Stream::new(0, Stage::Pilot, u32::MAX);
    let mut rays = Rays::default();
    for index in 0..TRIED {
        let u = stream.units(u64::from(index), 0, 0);
        let from = place([u[0], u[1], u[2]]);
        for ray in 0..TRIED {
            let u = stream.units(u64::from(index), 1 + ray, 0);
            rays.push(from, uniform_sphere([u[0], u[1]]), f32::INFINITY);
        }
    }
    let mut hits = Hits::default();
    tracer.closest(&rays, &mut hits);
    if hits.triangle.contains(&INVALID) {
        return Ok(());
    }
    let reason = format!(
        "no surface absorbs light, and none of {} rays from {named} leaves the room: its light adds \
         up without end. Lower the reflectance of its materials (--default-albedo where there are none)",
        TRIED * TRIED
    );
    Err(BakeError::Setting {
        option: scene.source.display().to_string(),
        reason,
    })
}
