//! A bake's watch as a transfer's bake knows it.

use super::progress::Kept;
use crate::error::{BakeError, Halt};
use crate::exec::watch::Watch;
use rrf_transfer::{TransferError, TransferProgress, TransferStage, TransferWatch};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Share of the time by which cells may be ahead of it and still get further rows.
const AHEAD: f64 = 0.1;

/// Passes on what a bake says of itself, and shares out its time.
pub(super) struct Observer<'a> {
    watch: &'a dyn Watch,
    /// Time left at the beginning, if there is a limit.
    limit: Option<Duration>,
    /// Steps of the present stage.
    total: AtomicU64,
    /// Those that are done.
    done: AtomicU64,
    /// Where the part that is done is kept.
    kept: Option<Kept<'a>>,
    /// Why it could not be.
    failed: Mutex<Option<BakeError>>,
}

impl<'a> Observer<'a> {
    /// From now on.
    pub(super) fn new(watch: &'a dyn Watch, kept: Option<Kept<'a>>) -> Observer<'a> {
        Observer {
            watch,
            limit: watch.left(),
            total: AtomicU64::new(1),
            done: AtomicU64::new(0),
            kept,
            failed: Mutex::new(None),
        }
    }

    /// The last stage is over.
    pub(super) fn end(&self) {
        self.watch.end();
    }

    /// Why a bake ended early: what is done could not be kept or read, or it was told to stop, or its own
    /// reason.
    pub(super) fn why(&self, error: TransferError) -> BakeError {
        let mut failed = self.failed.lock().unwrap_or_else(|p| p.into_inner());
        match (failed.take(), error, self.watch.halted()) {
            (Some(failed), ..) => failed,
            (None, _, Some(why)) => BakeError::TransferHalted { why },
            (None, TransferError::Halted, None) => BakeError::TransferHalted {
                why: Halt::Interrupt,
            },
            (None, TransferError::Memory { needed, memory }, None) => {
                BakeError::TransferMemory { needed, memory }
            }
            (None, error, None) => BakeError::Transfer(error),
        }
    }

    fn unless_failed<T>(&self, result: Result<T, BakeError>) -> Result<T, TransferError> {
        result.map_err(|error| {
            *self.failed.lock().unwrap_or_else(|p| p.into_inner()) = Some(error);
            TransferError::Halted
        })
    }
}

impl TransferWatch for Observer<'_> {
    fn halted(&self) -> bool {
        self.watch.halted().is_some()
    }

    /// As long as no more of the time is gone than of the surface is done: what is left has to be
    /// done once.
    fn may_refine(&self) -> bool {
        let (Some(limit), Some(left)) = (self.limit, self.watch.left()) else {
            return true;
        };
        let gone = 1.0 - left.as_secs_f64() / limit.as_secs_f64().max(f64::MIN_POSITIVE);
        let total = self.total.load(Ordering::Relaxed).max(1);
        let done = self.done.load(Ordering::Relaxed) as f64 / total as f64;
        gone < done + AHEAD
    }

    fn memory(&self) -> Option<u64> {
        self.watch.memory()
    }

    fn resume(&self, nodes: usize, _: usize) -> Result<Option<TransferProgress>, TransferError> {
        let kept = self.kept.as_ref();
        self.unless_failed(kept.map_or(Ok(None), |kept| kept.read(nodes)))
    }

    fn keep(&self, progress: &TransferProgress) -> Result<(), TransferError> {
        let Some(kept) = &self.kept else {
            return Ok(());
        };
        let stored = || self.watch.sync().map_err(BakeError::Sync);
        self.unless_failed(kept.write(progress).and_then(|()| stored()))
    }

    fn begin(&self, stage: TransferStage, total: u64) {
        self.total.store(total, Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
        self.watch.end();
        self.watch.begin_stage(stage.name(), total);
    }

    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.watch.advance(steps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// A clock that is set by hand.
    struct Clock(Mutex<u64>);

    impl Watch for Clock {
        fn left(&self) -> Option<Duration> {
            self.0.lock().ok().map(|left| Duration::from_secs(*left))
        }
    }

    #[test]
    fn time_is_shared_out_over_the_surface() {
        let clock = Clock(Mutex::new(100));
        let observer = Observer::new(&clock, None);
        observer.begin(TransferStage::Cells, 10);
        let at = |left: u64| {
            *clock.0.lock().unwrap() = left;
            observer.may_refine()
        };
        // 5 s gone of 100, nothing done; then 20 s
        assert_eq!([at(95), at(80)], [true, false]);
        observer.advance(5);
        assert_eq!([at(80), at(45), at(35)], [true, true, false]);
        assert!(Observer::new(&(), None).may_refine());
    }
}
