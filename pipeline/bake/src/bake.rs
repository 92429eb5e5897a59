//! The whole chain.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::judge::{Judgement, judge};
use crate::run::Run;
use crate::stages::{Watch, extract, plan, train};
use rrf_extract::Census;
use rrf_scene::Scene;
use rrf_trace::Tracer;
use std::path::Path;
use std::time::{Duration, Instant};

/// What a bake did.
#[derive(Clone, Debug)]
pub struct BakeReport {
    /// Candidates accepted and left out by the plan.
    pub census: Census,
    /// Error of every cell and of the whole.
    pub judgement: Judgement,
    /// Seconds in plan and extraction.
    pub extracting: Duration,
    /// Seconds in training and judging.
    pub training: Duration,
}

/// Bakes a scene into the folder `run`.
pub fn bake(
    scene: &Scene,
    config: &BakeConfig,
    run: &Path,
    resume: bool,
    watch: &dyn Watch,
) -> Result<BakeReport, BakeError> {
    let start = Instant::now();
    let run = Run::create(run, scene, config, resume)?;
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene)?;
    let plan = plan(&run, &scene, &tracer)?;
    extract(&run, &scene, &tracer, &plan, None, watch)?;
    let extracting = start.elapsed();
    train(&run, &plan, watch)?;
    let judgement = judge(&run, &plan)?;
    Ok(BakeReport {
        census: plan.census,
        judgement,
        extracting,
        training: start.elapsed() - extracting,
    })
}
