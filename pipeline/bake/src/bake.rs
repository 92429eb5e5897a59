//! A whole bake: load, plan, extract, train, evaluate, and again until a round is the last.

use crate::error::{BakeError, Halt};
use crate::exec::context::SamplingContext;
use crate::exec::evaluate::{evaluate_round, finished_part};
use crate::exec::plan::plan_first;
use crate::exec::stage::{extract_samples, halted, train_nets};
use crate::exec::watch::Watch;
use crate::plan::evaluation::{EvaluatedRound, Evaluation};
use crate::plan::stop::StopReason;
use crate::run::folder::Run;
use crate::run::rounds::Progress;
use crate::settings::BakeConfig;
use rrf_extract::Census;
use rrf_scene::Scene;
use rrf_store::StoreError;
use rrf_trace::Tracer;
use std::path::Path;

/// The result of a bake.
#[derive(Clone, Debug)]
pub struct BakeOutcome {
    /// Accepted and rejected candidates of the first plan.
    pub census: Census,
    /// Error of every cell and of the whole model, from the last committed round.
    pub evaluation: Evaluation,
    /// Number of committed rounds.
    pub rounds: u32,
    /// Why there is no further round.
    pub stop: StopReason,
}

/// Bakes a scene into the folder `run`. Everything that a round needs is in files of the folder, so that
/// an interrupted bake continues with the task that it was interrupted in.
///
/// # Errors
/// [`BakeError`] of any stage; [`BakeError::Halted`] where the watch stops the first round.
pub fn bake(
    scene: &Scene,
    config: &BakeConfig,
    run: &Path,
    resume: bool,
    watch: &dyn Watch,
) -> Result<BakeOutcome, BakeError> {
    let unlit = scene.unlit();
    let halt = || watch.halted().is_some();
    let tracer = Tracer::new(&unlit)?.until(&halt);
    let context = SamplingContext::new(&unlit, &tracer, config)?;
    let run = Run::create(run, scene, config, resume)?;
    let census = halted(plan_first(&run, &context), watch)?.census;
    watch.sync().map_err(BakeError::Sync)?;
    let mut mends = Mends(MOST_MENDS);
    loop {
        let Progress { evaluated, todo } = run.progress()?;
        let Some(mut round) = todo else {
            return outcome(&run, census, evaluated, None);
        };
        let work = extract_samples(&run, &round, &context, None, watch)
            .and_then(|()| train_nets(&run, &round, watch));
        match work {
            Err(halted @ BakeError::Halted { why: Halt::Time }) => {
                match (finished_part(&run, &round)?, evaluated) {
                    (Some(part), _) => round = part,
                    // the model of the round before stands
                    (None, Some(evaluated)) => {
                        let stop = round.compresses.unwrap_or(StopReason::Time);
                        return outcome(&run, census, Some(evaluated), Some(stop));
                    }
                    (None, None) => return Err(halted),
                }
            }
            Err(BakeError::Store(damage)) if mends.spend(&run, &damage)? => continue,
            work => work?,
        }
        let (evaluation, _) = match evaluate_round(&run, &round, watch) {
            Err(BakeError::Store(damage)) if mends.spend(&run, &damage)? => continue,
            evaluated => evaluated?,
        };
        watch.sync().map_err(BakeError::Sync)?;
        watch.evaluated(round.round, &evaluation);
    }
}

/// Damaged outputs that a bake makes again; a disk that damages more is to be replaced.
const MOST_MENDS: u32 = 100;

/// How many damaged outputs may still be made again.
struct Mends(u32);

impl Mends {
    /// Removes the damaged output that an error names, so that its task is done again.
    fn spend(&mut self, run: &Run, damage: &StoreError) -> Result<bool, BakeError> {
        match self.0.checked_sub(1) {
            Some(left) if run.discard(damage)? => self.0 = left,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// The result as of the last committed round, which stopped for its own reason or for `stop`.
fn outcome(
    run: &Run,
    census: Census,
    evaluated: Option<EvaluatedRound>,
    stop: Option<StopReason>,
) -> Result<BakeOutcome, BakeError> {
    let reason = |evaluated: &EvaluatedRound| stop.or(evaluated.stop);
    match evaluated.and_then(|evaluated| Some((reason(&evaluated)?, evaluated))) {
        Some((stop, evaluated)) => Ok(BakeOutcome {
            census,
            evaluation: evaluated.evaluation,
            rounds: evaluated.round + 1,
            stop,
        }),
        None => Err(BakeError::NotExtracted {
            path: run.folder.clone(),
            cell: 0,
        }),
    }
}
