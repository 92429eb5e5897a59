//! The plan of the first round.

use crate::error::BakeError;
use crate::exec::context::SamplingContext;
use crate::plan::round::RoundPlan;
use crate::plan::task::Task;
use crate::policy::cost;
use crate::policy::first::first_round;
use crate::run::folder::Run;
use crate::settings::BakeConfig;
use std::path::Path;

/// Plans the first round of a run, or reads its plan.
///
/// # Errors
/// [`BakeError::Extract`] where the scene has nothing to sample, [`BakeError::Store`].
pub fn plan_first(run: &Run, context: &SamplingContext) -> Result<RoundPlan, BakeError> {
    if let Some(plan) = run.read_plan(0)? {
        return Ok(plan);
    }
    let plan = first(&run.config, context)?;
    run.write_plan(&plan)?;
    Ok(plan)
}

/// The tasks of a first round, for an estimate of its cost. Nothing is written.
///
/// # Errors
/// As [`plan_first`].
pub fn estimate(config: &BakeConfig, context: &SamplingContext) -> Result<Vec<Task>, BakeError> {
    let run = Run::unwritten(Path::new(""), context.scene, config)?;
    run.tasks(&first(config, context)?)
}

fn first(config: &BakeConfig, context: &SamplingContext) -> Result<RoundPlan, BakeError> {
    let SamplingContext { scene, tracer, .. } = context;
    let first = rrf_extract::plan(scene, tracer, &config.extract)?;
    let diagonal = scene.bounds().map_or(0.0, |b| b.diagonal());
    let path_seconds = cost::path_seconds(tracer);
    let (paths, size) = (config.extract.paths, &config.train.size);
    Ok(first_round(first, diagonal, path_seconds, paths, size))
}
