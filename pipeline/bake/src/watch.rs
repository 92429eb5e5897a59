//! Who follows a bake, and may stop it.

use crate::judge::Judgement;
use crate::task::Stage;
use std::time::Duration;

/// Why a bake stops between two tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The time limit.
    Time,
    /// Someone asked for it (SIGINT, SIGTERM).
    Interrupt,
}

/// Follows a long stage.
pub trait Watch: Sync {
    /// A stage of `total` steps begins.
    fn begin(&self, stage: Stage, round: u32, total: u64);
    /// So many more steps are done.
    fn advance(&self, steps: u64);
    /// The stage is over.
    fn end(&self);
    /// A round was committed.
    fn judged(&self, _round: u32, _judgement: &Judgement) {}
    /// Files of the run have changed: keeps them where else they should be.
    fn keep(&self) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        Ok(())
    }
    /// Bytes that the tasks in hand may need together; none for no bound.
    fn memory(&self) -> Option<u64> {
        None
    }
    /// Time until none should begin any more; none for no limit.
    fn left(&self) -> Option<Duration> {
        None
    }
    /// Whether no further task should begin.
    fn halted(&self) -> Option<Halt> {
        None
    }
}
