//! The observer of a bake, which may stop it, and keeps what is done.

use super::progress::TransferProgress;
use crate::TransferError;

/// A stage of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferStage {
    /// Surface points are chosen.
    Points,
    /// The ensemble's lights are asked for, one by one.
    Lights,
    /// Rows are traced and cells fitted, counted in first rows.
    Cells,
}

impl TransferStage {
    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            TransferStage::Points => "points",
            TransferStage::Lights => "lights",
            TransferStage::Cells => "cells",
        }
    }
}

/// Observes a bake. Every method has a default; a function that tells whether to stop is one too.
pub trait TransferWatch: Sync {
    /// Whether the bake is to stop. It is asked every second or so of work.
    fn halted(&self) -> bool {
        false
    }
    /// Whether cells that err may get further rows; where a clock decides, it decides the bits too.
    fn may_refine(&self) -> bool {
        true
    }
    /// Bytes that rows and fits may take; none for no limit. Where it is too little for further rows of
    /// cells that err, it decides the bits.
    fn memory(&self) -> Option<u64> {
        None
    }
    /// The progress of an earlier bake of the same scene with the same settings, over a tree of so many
    /// nodes and columns; none where there is none.
    ///
    /// # Errors
    /// Those that end the bake.
    fn resume(
        &self,
        _nodes: usize,
        _columns: usize,
    ) -> Result<Option<TransferProgress>, TransferError> {
        Ok(None)
    }
    /// More surfaces are done.
    ///
    /// # Errors
    /// Those that end the bake.
    fn keep(&self, _progress: &TransferProgress) -> Result<(), TransferError> {
        Ok(())
    }
    /// A stage of `total` steps begins; the one before is over.
    fn begin(&self, _stage: TransferStage, _total: u64) {}
    /// More steps are done.
    fn advance(&self, _steps: u64) {}
}

impl<F: Fn() -> bool + Sync> TransferWatch for F {
    fn halted(&self) -> bool {
        self()
    }
}
