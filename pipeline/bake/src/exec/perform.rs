//! One task, from its inputs to its output.

use crate::error::BakeError;
use crate::exec::context::SamplingContext;
use crate::exec::watch::HaltCheck;
use crate::exec::{extract, fit};
use crate::plan::shard::Job;
use crate::plan::task::TaskKind;
use crate::run::folder::Run;

/// Performs a task: its output exists afterwards. A fit that would need more than `memory` bytes keeps
/// its rows in a file; its output is the same. A fit gives up where `halt` says so, an extraction where
/// the tracer of its context is told to.
///
/// # Errors
/// [`BakeError::NoContext`] for an extraction without a context, [`BakeError::Gone`], and all errors
/// of the stages.
pub fn perform(
    run: &Run,
    job: &Job,
    context: Option<&SamplingContext>,
    memory: Option<u64>,
    halt: Option<HaltCheck>,
) -> Result<(), BakeError> {
    run.unless_gone(Ok(()))?;
    let done = match job.task.kind {
        TaskKind::Extract => extract::extract_part(run, job, context),
        TaskKind::Train => fit::fit_cell(run, job, memory, halt),
    };
    run.unless_gone(done)
}
