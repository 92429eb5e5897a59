//! Errors of a bake.

use rrf_extract::ExtractError;
use rrf_field::FieldError;
use rrf_scene::SceneError;
use rrf_store::StoreError;
use rrf_trace::TraceError;
use rrf_train::TrainError;
use rrf_transfer::TransferError;
use std::path::PathBuf;

/// Reason that a bake stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The time limit.
    Time,
    /// A signal (SIGINT, SIGTERM).
    Interrupt,
}

impl Halt {
    /// The reason in words.
    pub fn text(self) -> &'static str {
        match self {
            Halt::Time => "the time limit",
            Halt::Interrupt => "a signal",
        }
    }
}

/// Error of a bake, with the facts of the stage that failed.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The scene file cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene cannot be traced.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// Nothing could be extracted.
    #[error(transparent)]
    Extract(#[from] ExtractError),
    /// A table or the run folder cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The nets and the tree do not form a model.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A fit cannot start.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// A transfer cannot be made.
    #[error(transparent)]
    Transfer(TransferError),
    /// The run was baked by another method than is needed.
    #[error("{path}: is a run of `--method {found}`; this works on runs of `--method {needed}`", path = path.display())]
    Method {
        /// The folder.
        path: PathBuf,
        /// Method that the run was baked by.
        found: &'static str,
        /// Method that the command works on.
        needed: &'static str,
    },
    /// The run folder already holds a run.
    #[error("{path}: already holds a run. Choose another folder, or continue it with --resume", path = path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds a run with other settings.
    #[error("{path}: was started with another {what} ({found}, now {asked}). Choose another folder, or give the same settings", path = path.display())]
    OtherRun {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// Value in the run.
        found: String,
        /// Value requested now.
        asked: String,
    },
    /// The plan has no such cell.
    #[error("cell {cell}: the plan has cells 0 to {last}")]
    NoSuchCell {
        /// The cell.
        cell: u32,
        /// The last one that exists.
        last: u32,
    },
    /// A plan is inconsistent.
    #[error("round {round}: {reason}")]
    Plan {
        /// The round.
        round: u32,
        /// The fault found.
        reason: String,
    },
    /// An extraction needs the scene.
    #[error("a part has to be drawn, but no scene is loaded")]
    NoContext,
    /// A setting is unknown or wrong, or contradicts another one or the scene.
    #[error("{option}: {reason}")]
    Setting {
        /// The option.
        option: String,
        /// The fault found.
        reason: String,
    },
    /// A round cannot be committed yet.
    #[error("{path}: {missing} tasks of round {round} are not done. Continue with `rrf bake --resume`", path = path.display())]
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
        "a task needs about {needed} bytes of memory, but --memory is {memory}. Allow more, or bake with more cells of fewer rows"
    )]
    Memory {
        /// Bytes that the largest task needs.
        needed: u64,
        /// Bytes allowed.
        memory: u64,
    },
    /// A transfer does not fit into memory.
    #[error(
        "the rows of the largest surface and the fits of {} threads need about {} MiB of memory, but --memory is {} MiB. Allow more, or bake with fewer --rows, --paths or --threads",
        rayon::current_num_threads(), needed.div_ceil(1 << 20), memory >> 20
    )]
    TransferMemory {
        /// Bytes that it needs.
        needed: u64,
        /// Bytes allowed.
        memory: u64,
    },
    /// The run's files could not be stored at their remote location.
    #[error("{0}")]
    Sync(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Stopped; finished tasks are kept.
    #[error("stopped by {}. Finished work is kept: continue with `rrf bake --resume`", match why { Halt::Time => "the time limit before the first round was done", Halt::Interrupt => "a signal" })]
    Halted {
        /// Why.
        why: Halt,
    },
    /// A transfer's bake was stopped.
    #[error("stopped by {} before the transfer was done; the surfaces that are finished are kept. Continue with `rrf bake --resume`", match why { Halt::Time => "the time limit", Halt::Interrupt => "a signal" })]
    TransferHalted {
        /// Why.
        why: Halt,
    },
    /// The run folder disappeared during the work.
    #[error("{path}: the run folder is gone: its disk was removed, or it was moved. Restore it and continue with `rrf bake --resume`", path = path.display())]
    Gone {
        /// The folder.
        path: PathBuf,
    },
    /// Files of somebody else lie where a renewal would remove everything.
    #[error("{path}: the settings have changed, and renewing the run would remove files that are not its own: {files}. Move them elsewhere", path = path.display(), files = listed(others))]
    NotOurs {
        /// The run folder.
        path: PathBuf,
        /// The files.
        others: Vec<PathBuf>,
    },
    /// The earlier fit that a fit starts from is missing.
    #[error("{path}: the earlier fit that cell {cell} starts from is missing or has changed. Restore it, or bake into a new folder", path = path.display())]
    EarlierFit {
        /// Where it should be.
        path: PathBuf,
        /// The cell that needs it.
        cell: u32,
    },
    /// A cell has no samples yet.
    #[error("{path}: cell {cell} has no samples. Run `rrf extract` or `rrf bake --resume` first", path = path.display())]
    NotExtracted {
        /// The run folder.
        path: PathBuf,
        /// The first cell without any.
        cell: u32,
    },
}

/// The first paths of a list, and how many there are more.
fn listed(paths: &[PathBuf]) -> String {
    const NAMED: usize = 5;
    let named = paths.iter().take(NAMED);
    let named: Vec<String> = named.map(|path| path.display().to_string()).collect();
    match paths.len().saturating_sub(NAMED) {
        0 => named.join(", "),
        more => format!("{} and {more} more", named.join(", ")),
    }
}

impl BakeError {
    /// A plan that refers to a draw that it does not contain.
    pub(crate) fn missing_draw(round: u32, draw: u32) -> BakeError {
        BakeError::Plan {
            round,
            reason: format!("draw {draw} is missing. Bake into a new folder"),
        }
    }

    /// Whether a stage gave up because its user said so.
    pub(crate) fn was_told_to_stop(&self) -> bool {
        matches!(
            self,
            BakeError::Trace(TraceError::Halted)
                | BakeError::Extract(ExtractError::Trace(TraceError::Halted))
                | BakeError::Train(TrainError::Halted)
        )
    }

    /// Whether the same call fails until the input changes (exit code 2).
    pub fn is_bad_input(&self) -> bool {
        match self {
            BakeError::Store(error) => error.is_bad_input(),
            error if error.was_told_to_stop() => false,
            BakeError::Halted { .. }
            | BakeError::TransferHalted { .. }
            | BakeError::Unfinished { .. }
            | BakeError::Sync(_)
            | BakeError::Gone { .. } => false,
            _ => true,
        }
    }
}
