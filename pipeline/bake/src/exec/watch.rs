//! The observer of a bake, which may stop it.

use crate::error::Halt;
use crate::plan::evaluation::Evaluation;
use crate::plan::task::TaskKind;
use crate::transfer::TransferSummary;
use std::time::Duration;

/// Asks whether to give up.
pub type HaltCheck<'a> = &'a (dyn Fn() -> bool + Sync);

/// Observes a bake. Every method has a default: `&()` neither shows nor limits anything.
pub trait Watch: Sync {
    /// A stage of `total` steps begins.
    fn begin(&self, _kind: TaskKind, _round: u32, _total: u64) {}
    /// A stage of `total` steps of another bake than that of nets begins.
    fn begin_stage(&self, _name: &'static str, _total: u64) {}
    /// More steps are done.
    fn advance(&self, _steps: u64) {}
    /// The stage is over.
    fn end(&self) {}
    /// A round was committed.
    fn evaluated(&self, _round: u32, _evaluation: &Evaluation) {}
    /// A transfer is finished.
    fn transferred(&self, _summary: &TransferSummary) {}
    /// Files of the run have changed: stores them at their remote location, if any.
    fn sync(&self) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        Ok(())
    }
    /// Memory that all tasks in work may need together \[bytes\]; none for no limit.
    fn memory(&self) -> Option<u64> {
        None
    }
    /// Time until the work should end; none for no limit.
    fn left(&self) -> Option<Duration> {
        None
    }
    /// The reason to give up, if any: asked many times a second, within tasks too. Once there is a reason
    /// there must remain one.
    fn halted(&self) -> Option<Halt> {
        None
    }
}

impl Watch for () {}
