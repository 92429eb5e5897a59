//! The stages of a round: all tasks of one kind that are not done, side by side.

use crate::error::BakeError;
use crate::exec::context::SamplingContext;
use crate::exec::perform::perform;
use crate::exec::pool::WorkerPool;
use crate::exec::watch::Watch;
use crate::plan::round::RoundPlan;
use crate::plan::shard::Job;
use crate::plan::task::{Task, TaskKind};
use crate::plan::timings::Timings;
use crate::run::folder::Run;
use std::time::Instant;

/// The timing of a stage.
type Time = fn(&mut Timings) -> &mut f64;

/// Extracts the samples of a round; `only` limits this to some cells.
///
/// # Errors
/// [`BakeError::Halted`] when the watch says so: finished work is kept.
pub fn extract_samples(
    run: &Run,
    plan: &RoundPlan,
    context: &SamplingContext,
    only: Option<&[u32]>,
    watch: &dyn Watch,
) -> Result<(), BakeError> {
    let mut todo = unfinished(run, plan, TaskKind::Extract)?;
    todo.retain(|task| only.is_none_or(|cells| cells.contains(&task.cell)));
    let time: Time = |timings| &mut timings.extract;
    stage(run, plan, todo, Some(context), time, watch)
}

/// Fits the nets of a round.
///
/// # Errors
/// [`BakeError::NotExtracted`]; [`BakeError::Halted`] when the watch says so: finished work is kept.
pub fn train_nets(run: &Run, plan: &RoundPlan, watch: &dyn Watch) -> Result<(), BakeError> {
    let todo = unfinished(run, plan, TaskKind::Train)?;
    let time: Time = |timings| &mut timings.train;
    stage(run, plan, todo, None, time, watch)
}

/// The tasks of one kind that are not done.
pub(crate) fn unfinished(
    run: &Run,
    plan: &RoundPlan,
    kind: TaskKind,
) -> Result<Vec<Task>, BakeError> {
    let mut todo = Vec::new();
    for task in run.tasks(plan)? {
        if task.kind == kind && !run.is_done(&task)? {
            todo.push(task);
        }
    }
    Ok(todo)
}

/// Names the reason where work was given up.
pub(crate) fn halted<T>(result: Result<T, BakeError>, watch: &dyn Watch) -> Result<T, BakeError> {
    match (result, watch.halted()) {
        (Err(error), Some(why)) if error.was_told_to_stop() => Err(BakeError::Halted { why }),
        (result, _) => result,
    }
}

fn stage(
    run: &Run,
    plan: &RoundPlan,
    mut todo: Vec<Task>,
    context: Option<&SamplingContext>,
    time: Time,
    watch: &dyn Watch,
) -> Result<(), BakeError> {
    let Some(kind) = todo.first().map(|task| task.kind) else {
        return Ok(());
    };
    let start = Instant::now();
    // the long ones first, so that no thread is left alone with one at the end
    todo.sort_by(|a, b| b.seconds.total_cmp(&a.seconds).then(a.cell.cmp(&b.cell)));
    let weight = |task: &Task| (task.seconds * 1000.0) as u64 + 1;
    let pool = WorkerPool::for_tasks(&todo, watch.memory())?;
    watch.begin(kind, plan.round, todo.iter().map(weight).sum());
    let done = pool.run(&todo, |task| {
        if let Some(why) = watch.halted() {
            return Err(BakeError::Halted { why });
        }
        let halt = || watch.halted().is_some();
        let done = perform(
            run,
            &Job::of(plan, task)?,
            context,
            pool.memory,
            Some(&halt),
        );
        halted(done, watch)?;
        watch.sync().map_err(BakeError::Sync)?;
        watch.advance(weight(task));
        Ok(())
    });
    watch.end();
    let timed = run.add_time(plan.round, time, start);
    run.unless_gone(done.and(timed))
}
