//! Why a transfer cannot be made.

/// A transfer that cannot be made, with the fact and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransferError {
    /// There is no surface, or no patch was asked for.
    #[error(
        "no patches: the scene needs a triangle with an area, and the count must be at least 1"
    )]
    NoPatches,
    /// A path count that two halves cannot share.
    #[error(
        "{paths} paths cannot be split into two equal halves: ask for an even number, at least 2"
    )]
    Paths {
        /// Paths asked for.
        paths: u32,
    },
    /// A vector over columns of another length than the patches have.
    #[error("{found} columns where the patches have {expected}: they belong to other patches")]
    Columns {
        /// Columns found.
        found: usize,
        /// Columns expected.
        expected: usize,
    },
    /// An ensemble without lights that give any row light.
    #[error(
        "no light of the {lights} examples reaches any of {rows} surface points that eyes see: name a light box in free space"
    )]
    NoLight {
        /// Rows that were asked.
        rows: usize,
        /// Lights given.
        lights: usize,
    },
    /// LAPACK gave up.
    #[error("a factorisation of {rows} by {columns} numbers failed: {reason}")]
    Factorisation {
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
        /// LAPACK's own words.
        reason: String,
    },
    /// No surface point was offered.
    #[error(
        "no rows: no surface point was seen from where eyes are; move the cameras or the eye box into free space"
    )]
    NoRows,
    /// The work needs more memory than it may have.
    #[error("the bake needs {needed} bytes of memory and may have {memory}")]
    Memory {
        /// Bytes needed.
        needed: u64,
        /// Bytes that it may have.
        memory: u64,
    },
    /// Somebody asked to stop.
    #[error("the bake of the transfer was stopped before it was done")]
    Halted,
}
