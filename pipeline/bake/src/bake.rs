//! The whole chain.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::rounds::{Ended, rounds};
use crate::run::Run;
use crate::watch::Watch;
use crate::work::Site;
use rrf_scene::Scene;
use rrf_trace::Tracer;
use std::path::Path;

/// Bakes a scene into the folder `run`.
pub fn bake(
    scene: &Scene,
    config: &BakeConfig,
    run: &Path,
    resume: bool,
    watch: &dyn Watch,
) -> Result<Ended, BakeError> {
    let run = Run::create(run, scene, config, resume)?;
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene)?;
    rounds(&run, &Site::new(&scene, &tracer, &run.config)?, watch)
}
