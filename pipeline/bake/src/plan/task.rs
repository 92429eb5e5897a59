//! A task: the unit of work that can run anywhere, in any order, any number of times.
//!
//! A task reads files of the run, writes one part of the samples or one fit, and is identified by a
//! hash of everything that its output depends on. The output carries the hash: a task whose output
//! exists with the same hash is done.

use serde::{Deserialize, Serialize};

/// Kind of a task; tasks of one kind do not wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TaskKind {
    /// Draws the rows of a part, or takes them from a part of the round before.
    Extract,
    /// Fits the net of a cell to its parts.
    Train,
}

impl TaskKind {
    /// Name in tables and messages.
    pub fn name(self) -> &'static str {
        match self {
            TaskKind::Extract => "extract",
            TaskKind::Train => "train",
        }
    }
}

/// One task of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Kind of work.
    #[serde(rename = "stage")]
    pub kind: TaskKind,
    /// Round that the output belongs to.
    pub round: u32,
    /// Cell, or [`rrf_store::layout::TEST`] for test rows.
    pub cell: u32,
    /// Part number of an extraction.
    pub part: Option<u32>,
    /// blake3 of everything that the output depends on, 64 hexadecimal digits.
    pub hash: String,
    /// Predicted seconds of one core.
    pub seconds: f64,
    /// Upper bound of the memory needed \[bytes\].
    pub memory: u64,
    /// Memory that is enough when a fit keeps its rows in a file \[bytes\].
    pub least_memory: u64,
}
