//! A scene prepared for sampling.

use crate::error::BakeError;
use crate::settings::BakeConfig;
use glam::Vec3;
use rrf_extract::Region;
use rrf_extract::{Eyes, NarrowLight, VisibilityQueries};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, Tracer};

/// A scene prepared for sampling. Training needs none.
pub struct SamplingContext<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) visibility: VisibilityQueries<'a>,
    pub(crate) eyes: Option<Eyes>,
    pub(crate) narrow: NarrowLight,
}

impl<'a> SamplingContext<'a> {
    /// Prepares a scene, without its own lights, for the settings of a bake.
    ///
    /// # Errors
    /// [`BakeError::Extract`] for settings that the scene does not allow.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer<'a>,
        config: &BakeConfig,
    ) -> Result<SamplingContext<'a>, BakeError> {
        config.validate(scene)?;
        refuse_endless(scene, tracer, config.extract.light_box)?;
        let visibility = VisibilityQueries::new(scene, tracer);
        let eye_box = config.extract.eye_box;
        let eyes = eye_box.map(|eye_box| Eyes::new(&visibility, eye_box));
        Ok(SamplingContext {
            scene,
            tracer,
            eyes: eyes.transpose()?,
            narrow: config.extract.narrow,
            visibility,
        })
    }
}

/// Places of lights and directions from each that are tried.
const TRIED: u32 = 64;
/// A reflectance that is counted as that of all light.
const ALL: f32 = 0.999;

/// Refuses a closed room of which no surface absorbs light: its radiance has no finite value.
fn refuse_endless(scene: &Scene, tracer: &Tracer, lights: Region) -> Result<(), BakeError> {
    let reflects_all = |&id: &u32| {
        let material = scene.materials.get(id as usize);
        material.is_some_and(|m| m.base_texture == INVALID && m.base_color.max_element() >= ALL)
    };
    if !scene.triangle_material.iter().all(reflects_all) {
        return Ok(());
    }
    let stream = Stream::new(0, Stage::Pilot, u32::MAX);
    let mut rays = Rays::default();
    for place in 0..TRIED {
        let u = stream.units(u64::from(place), 0, 0);
        let from = lights.at([u[0], u[1], u[2]]);
        for ray in 0..TRIED {
            let u = stream.units(u64::from(place), 1 + ray, 0);
            let (z, turn) = (2.0 * u[0] - 1.0, std::f32::consts::TAU * u[1]);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let toward = Vec3::new(r * turn.cos(), r * turn.sin(), z);
            rays.push(from, toward, f32::INFINITY);
        }
    }
    let mut hits = Hits::default();
    tracer.closest(&rays, &mut hits);
    if hits.triangle.contains(&INVALID) {
        return Ok(());
    }
    let reason = format!(
        "no surface absorbs light, and none of {} rays from the light box leaves the room: its light adds \
         up without end. Lower the reflectance of its materials (--default-albedo where there are none)",
        TRIED * TRIED
    );
    Err(BakeError::Setting {
        option: scene.source.display().to_string(),
        reason,
    })
}
