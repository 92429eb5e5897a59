//! A scene prepared for sampling.

use crate::error::BakeError;
use crate::exec::endless::refuse_endless;
use crate::settings::BakeConfig;
use rrf_extract::{Eyes, NarrowLight, VisibilityQueries};
use rrf_scene::Scene;
use rrf_trace::Tracer;

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
        let light_box = config.extract.light_box;
        refuse_endless(scene, tracer, "the light box", |u| light_box.at(u))?;
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
