//! Rounds: plan, tasks, commit, and again.
//!
//! Everything that a round needs is in files of the run, so that a bake that was cut off goes on
//! with the task that it was cut off in, and so that the tasks may as well be done by others.

use crate::commit::{commit, missing};
use crate::config::BakeConfig;
use crate::cost;
use crate::crew;
use crate::decide::{Next, Stop, decide};
use crate::error::BakeError;
use crate::judge::Judgement;
use crate::plan::RoundPlan;
use crate::run::{Judged, Run};
use crate::seconds;
use crate::task::{Stage, Task, is_done, tasks};
use crate::trim;
use crate::watch::{Halt, Watch};
use crate::work::{Site, perform};
use rrf_extract::Census;
use rrf_store::layout::remove_unfinished;
use std::borrow::Cow;
use std::time::{Duration, Instant};

/// Where a run stands.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The round that was committed last, if any.
    pub judged: Option<Judged>,
    /// The round to do, or none when the run has ended.
    pub todo: Option<RoundPlan>,
}

/// Where a run stands, from its files. A round that lost files is to do again.
pub fn standing(run: &Run) -> Result<Standing, BakeError> {
    let (mut judged, mut round) = (None, 0);
    while let Some(plan) = run.read_plan(round)? {
        let found = run.read_judged(round)?;
        let ended = match found {
            None => {
                return Ok(Standing {
                    judged,
                    todo: Some(plan),
                });
            }
            Some(found) => {
                let ended = found.stop.is_some();
                judged = Some(found);
                ended
            }
        };
        if ended && (!run.has_model() || missing(run, &plan)? > 0) {
            return Ok(Standing {
                judged,
                todo: Some(plan),
            });
        }
        if ended {
            return Ok(Standing { judged, todo: None });
        }
        round += 1;
    }
    Ok(Standing { judged, todo: None })
}

/// Draws the first plan, or reads it.
pub fn first_plan(run: &Run, site: &Site) -> Result<RoundPlan, BakeError> {
    if let Some(plan) = run.read_plan(0)? {
        return Ok(plan);
    }
    let plan = plan_first(&run.config, site)?;
    run.write_plan(&plan)?;
    Ok(plan)
}

/// The tasks of a first round, for an estimate: nothing is written.
pub fn first_tasks(config: &BakeConfig, site: &Site) -> Result<Vec<Task>, BakeError> {
    let run = Run::unwritten(site.scene(), config)?;
    let plan = plan_first(config, site)?;
    tasks(&run, &plan)
}

fn plan_first(config: &BakeConfig, site: &Site) -> Result<RoundPlan, BakeError> {
    let first = rrf_extract::plan(site.scene(), site.tracer(), &config.extract)?;
    let diagonal = site.scene().bounds().map_or(0.0, |b| b.diagonal());
    let (paths, size) = (config.extract.paths, &config.train.size);
    let path = cost::path_seconds(site.tracer());
    Ok(RoundPlan::first(first, diagonal, path, paths, size))
}

/// Does the tasks of one stage that are not done; `only` limits them to some cells.
///
/// # Errors
/// [`BakeError::Halted`] when the watch says so: what is done stays.
pub fn perform_stage(
    run: &Run,
    plan: &RoundPlan,
    site: Option<&Site>,
    stage: Stage,
    only: Option<&[u32]>,
    watch: &dyn Watch,
) -> Result<(), BakeError> {
    let start = Instant::now();
    let mut todo = Vec::new();
    for task in tasks(run, plan)? {
        let wanted = only.is_none_or(|cells| cells.contains(&task.cell));
        if task.stage == stage && wanted && !is_done(run, &task)? {
            todo.push(task);
        }
    }
    if todo.is_empty() {
        return Ok(());
    }
    // the long ones first, so that no thread is left alone with one at the end
    todo.sort_by(|a, b| b.seconds.total_cmp(&a.seconds).then(a.cell.cmp(&b.cell)));
    let weight = |task: &Task| (task.seconds * 1000.0) as u64 + 1;
    let crew = crew::crew(&todo, watch.memory())?;
    watch.begin(stage, plan.round, todo.iter().map(weight).sum());
    let done = crew::work(crew.size, &todo, |task| {
        if let Some(why) = watch.halted() {
            return Err(BakeError::Halted { why });
        }
        perform(run, plan, site, task, crew.share)?;
        watch.keep().map_err(BakeError::Keep)?;
        watch.advance(weight(task));
        Ok(())
    });
    watch.end();
    let noted = seconds::add(run, plan.round, seconds::of(stage), start);
    run.unless_gone(done.and(noted))
}

/// Commits a round whose tasks are done and writes down what comes next: no more than should be done
/// in the time that is left, where that is limited.
pub fn finish_round(
    run: &Run,
    plan: &RoundPlan,
    left: Option<Duration>,
) -> Result<(Judgement, Next), BakeError> {
    run.unless_gone(finish(run, plan, left))
}

fn finish(
    run: &Run,
    plan: &RoundPlan,
    left: Option<Duration>,
) -> Result<(Judgement, Next), BakeError> {
    let start = Instant::now();
    let (plan, judgement) = committed(run, plan)?;
    let plan = plan.as_ref();
    let budget = match left {
        Some(left) => seconds::budget(run, plan, left)?,
        None => None,
    };
    let (next, remedies) = decide(run, plan, &judgement, budget)?;
    if let Next::Round(next) = &next {
        run.write_plan(next)?;
    }
    let stop = match &next {
        Next::Stop(stop) => Some(*stop),
        Next::Round(_) => None,
    };
    // no task is left to do: what lies unfinished, a killed one left
    remove_unfinished(&run.folder)?;
    run.write_judged(&Judged {
        round: plan.round,
        judgement: judgement.clone(),
        stop,
        remedies,
    })?;
    seconds::add(run, plan.round, |s| &mut s.judge, start)?;
    Ok((judgement, next))
}

/// Commits a round. Trimmed nets that cost the whole its target, by rows that did not choose them, are taken back, the
/// costliest half first.
fn committed<'a>(
    run: &Run,
    plan: &'a RoundPlan,
) -> Result<(Cow<'a, RoundPlan>, Judgement), BakeError> {
    let mut plan = Cow::Borrowed(plan);
    loop {
        let judgement = commit(run, &plan)?;
        match trim::taken_back(run, &plan, &judgement)? {
            Some(fewer) => plan = Cow::Owned(fewer),
            None => return Ok((plan, judgement)),
        }
    }
}

/// What rounds came to.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Candidates of the first plan, accepted and left out.
    pub census: Census,
    /// Error of every cell and of the whole, of the last round that was committed.
    pub judgement: Judgement,
    /// Rounds committed.
    pub rounds: u32,
    /// Why there is no further one.
    pub stop: Stop,
}

/// Does rounds until one says stop or the watch does.
pub fn rounds(run: &Run, site: &Site, watch: &dyn Watch) -> Result<Ended, BakeError> {
    let census = first_plan(run, site)?.census;
    watch.keep().map_err(BakeError::Keep)?;
    loop {
        let Standing { judged, todo } = standing(run)?;
        let Some(plan) = todo else {
            return ended(run, census, judged);
        };
        let work = [Stage::Extract, Stage::Train]
            .iter()
            .try_for_each(|&stage| perform_stage(run, &plan, Some(site), stage, None, watch));
        let cut_off = matches!(work, Err(BakeError::Halted { why: Halt::Time }));
        let (plan, work) = match cut_off.then(|| trim::trimmed_so_far(run, &plan)) {
            Some(smaller) => match smaller? {
                Some(smaller) => (smaller, Ok(())),
                None => (plan, work),
            },
            None => (plan, work),
        };
        match (work, judged) {
            // the model of the round before stands
            (Err(BakeError::Halted { why: Halt::Time }), Some(judged)) => {
                return Ok(Ended {
                    census,
                    judgement: judged.judgement,
                    rounds: judged.round + 1,
                    stop: plan.trims.unwrap_or(Stop::Time),
                });
            }
            (work, _) => work?,
        }
        let (judgement, _) = finish_round(run, &plan, watch.left())?;
        watch.keep().map_err(BakeError::Keep)?;
        watch.judged(plan.round, &judgement);
    }
}

fn ended(run: &Run, census: Census, judged: Option<Judged>) -> Result<Ended, BakeError> {
    let missing = || BakeError::NotExtracted {
        path: run.folder.clone(),
        cell: 0,
    };
    let judged = judged.ok_or_else(missing)?;
    Ok(Ended {
        census,
        rounds: judged.round + 1,
        stop: judged.stop.ok_or_else(missing)?,
        judgement: judged.judgement,
    })
}
