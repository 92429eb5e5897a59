//! Why a bake stopped.

use crate::watch::Halt;
use rrf_extract::ExtractError;
use rrf_field::FieldError;
use rrf_scene::SceneError;
use rrf_store::StoreError;
use rrf_trace::TraceError;
use rrf_train::TrainError;
use std::path::PathBuf;

/// What went wrong in a run, with the stage's own facts inside.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The scene file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene cannot be traced.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// Nothing could be extracted.
    #[error(transparent)]
    Extract(#[from] ExtractError),
    /// A table or the run folder.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The fits' nets and the tree do not make a model.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A fit could not start.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// The run folder already holds a run.
    #[error("{path}: already holds a run. Choose another folder, or go on with it by --resume", path = path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds a run with other settings.
    #[error("{path}: was begun with another {what} ({found}, now {asked}). Choose another folder, or give the same settings", path = path.display())]
    OtherRun {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// As the run has it.
        found: String,
        /// As asked for now.
        asked: String,
    },
    /// A cell asked for by number that the plan does not have.
    #[error("cell {cell}: the plan has cells 0 to {last}")]
    NoSuchCell {
        /// The cell.
        cell: u32,
        /// The last one that exists.
        last: u32,
    },
    /// A plan that does not hold together.
    #[error("round {round}: {reason}. Bake into a new folder")]
    Plan {
        /// The round.
        round: u32,
        /// What is wrong.
        reason: String,
    },
    /// An extraction needs the scene.
    #[error("a part has to be drawn, and no scene was loaded")]
    NoSite,
    /// A round cannot be committed yet.
    #[error("{path}: {missing} tasks of round {round} are not done. Go on by `rrf bake --resume`", path = path.display())]
    Unfinished {
        /// The run folder.
        path: PathBuf,
        /// The round.
        round: u32,
        /// Tasks that are not done.
        missing: usize,
    },
    /// A task does not fit into memory.
    #[error(
        "a task needs about {needed} bytes of memory, --memory is {memory}: allow more, or bake with more cells of fewer rows"
    )]
    Memory {
        /// Bytes that the largest task needs.
        needed: u64,
        /// Bytes allowed.
        memory: u64,
    },
    /// The run's files could not be kept elsewhere.
    #[error("{0}")]
    Keep(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Stopped between two tasks; everything done so far stays.
    #[error("stopped by {}; what is done stays: go on by `rrf bake --resume`", match why { Halt::Time => "the time limit before the first round was done", Halt::Interrupt => "a signal" })]
    Halted {
        /// Why.
        why: Halt,
    },
    /// The run folder is not where it was when the work began.
    #[error("{path}: the run folder is gone in the middle of the work: its disk was taken away, or it was moved. Bring it back and go on by `rrf bake --resume`", path = path.display())]
    Gone {
        /// The folder.
        path: PathBuf,
    },
    /// What a fit goes on from is not there.
    #[error("{path}: the fit from which cell {cell} goes on is missing, or is another one. Bring it back, or bake into a new folder", path = path.display())]
    EarlierFit {
        /// Where it should be.
        path: PathBuf,
        /// The cell that needs it.
        cell: u32,
    },
    /// The run has no samples yet.
    #[error("{path}: cell {cell} has no samples. Run `rrf extract` or `rrf bake --resume` first", path = path.display())]
    NotExtracted {
        /// The run folder.
        path: PathBuf,
        /// The first cell without any.
        cell: u32,
    },
}

impl BakeError {
    /// Whether the same call fails again until a person changes the input (exit code 2).
    pub fn is_bad_input(&self) -> bool {
        match self {
            BakeError::Store(error) => error.is_bad_input(),
            BakeError::Halted { .. }
            | BakeError::Unfinished { .. }
            | BakeError::Keep(_)
            | BakeError::Gone { .. } => false,
            _ => true,
        }
    }
}
