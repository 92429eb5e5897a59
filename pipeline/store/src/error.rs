//! Why a table was refused or not written: facts, place and remedy.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// What went wrong with a file of a run or a table of points.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The system refused to read, write or rename.
    #[error("{path}: cannot {action}: {source}{hint}", path = path.display(), hint = io_hint(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried: `read`, `write`, `create the folder`, ...
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not what its format requires: truncated, changed, or of another format.
    #[error("{path}: damaged or not a {format} file: {reason}. {remedy}", path = path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// The format expected: `Parquet`, `Arrow IPC`, `JSON`.
        format: &'static str,
        /// What was found.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A genuine file that uses what this program does not read.
    #[error("{path}: {what}. {remedy}", path = path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it uses.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The columns are not those of the table's schema.
    #[error("{path}: not a `{table}` table: {difference}. {remedy}", path = path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// The schema, as in `schemas/`.
        table: &'static str,
        /// Columns missing, unexpected or of another type, expected and found.
        difference: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Written by a program whose tables have another version.
    #[error("{path}: `{table}` table of version {found}, this program reads version {expected}. {remedy}", path = path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The schema, as in `schemas/`.
        table: &'static str,
        /// The version that this program knows.
        expected: u32,
        /// The version in the file, or `none`.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A file of another scene, seed, cell or part than the one asked for.
    #[error("{path}: {fact} is {found}, expected {expected}. {remedy}", path = path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs: `scene hash`, `seed`, `cell`, `part`.
        fact: &'static str,
        /// As the run has it.
        expected: String,
        /// As the file has it.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Reading the file would need more memory than allowed.
    #[error("{path}: {what} is {found}, the limit is {limit}. Split the table, or raise the limit if the file is genuine", path = path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large.
        what: &'static str,
        /// As the file claims or needs.
        found: u64,
        /// The limit.
        limit: u64,
    },
    /// A value that cannot be used, in a table that a person or another tool made.
    #[error("{path}: column {column}, row {row}: {reason}", path = path.display())]
    BadValue {
        /// The file.
        path: PathBuf,
        /// The column, or the first of three.
        column: String,
        /// Row from 0.
        row: usize,
        /// The fault and its remedy.
        reason: String,
    },
    /// The tables of a model do not make a model.
    #[error("{path}: {place}: {reason}. {remedy}", path = path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// `node 3`, `cell 12`.
        place: String,
        /// The fault found.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A file or folder that has no place in `samples/`.
    #[error("{path}: does not belong in a samples dataset (only cell=NNNNNN/part-NNNNN.parquet does), other programs stumble over it. Move it elsewhere", path = path.display())]
    Stray {
        /// The file or folder.
        path: PathBuf,
    },
    /// The ending names no table format.
    #[error("{path}: unknown table format (known: .parquet, .arrow, .ipc, .feather)", path = path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A cell without a part.
    #[error("{path}: no samples. Extract the cell first (`rrf extract`)", path = path.display())]
    NoSamples {
        /// The cell's folder.
        path: PathBuf,
    },
    /// Another process works on the folder.
    #[error("{path}: in use by {holder}. Wait until it is done, or choose another folder", path = path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
        /// Who holds it: `rrf bake (process 42 on host)`.
        holder: String,
    },
    /// The folder holds no run.
    #[error("{path}: not a run folder (no run.json in it). Make one with `rrf bake SCENE -o {path}`", path = path.display())]
    NotARun {
        /// The folder.
        path: PathBuf,
    },
    /// Columns handed over for writing do not fit the table's schema.
    #[error("cannot make a `{table}` table: {reason}")]
    Columns {
        /// The schema, as in `schemas/`.
        table: &'static str,
        /// Which column, expected and found.
        reason: String,
    },
    /// A schema file that was built into the program is wrong.
    #[error("schemas/{table}.toml, built into the program: {reason}")]
    BuiltIn {
        /// The schema.
        table: &'static str,
        /// The fault found.
        reason: String,
    },
}

impl StoreError {
    /// Whether a file of a run is not the one that was written: damaged, or of another run. One
    /// that a task makes can be made again.
    pub fn is_damage(&self) -> bool {
        match self {
            StoreError::Corrupt { .. }
            | StoreError::Unsupported { .. }
            | StoreError::Schema { .. }
            | StoreError::Version { .. }
            | StoreError::Foreign { .. }
            | StoreError::TooLarge { .. }
            | StoreError::BadValue { .. }
            | StoreError::Model { .. } => true,
            StoreError::Io { source, .. } => source.kind() == ErrorKind::NotFound,
            _ => false,
        }
    }

    /// The file concerned, where there is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            StoreError::Io { path, .. }
            | StoreError::Corrupt { path, .. }
            | StoreError::Unsupported { path, .. }
            | StoreError::Schema { path, .. }
            | StoreError::Version { path, .. }
            | StoreError::Foreign { path, .. }
            | StoreError::TooLarge { path, .. }
            | StoreError::BadValue { path, .. }
            | StoreError::Model { path, .. }
            | StoreError::Stray { path }
            | StoreError::UnknownFormat { path }
            | StoreError::NoSamples { path }
            | StoreError::Busy { path, .. }
            | StoreError::NotARun { path } => Some(path),
            StoreError::Columns { .. } | StoreError::BuiltIn { .. } => None,
        }
    }

    /// Whether the same call fails again until a person changes the input (exit code 2).
    /// Otherwise it could succeed when tried again (exit code 1): full disk, interrupted
    /// or failing device.
    pub fn is_bad_input(&self) -> bool {
        match self {
            StoreError::Io { source, .. } => rrf_files::is_permanent(source),
            StoreError::Busy { .. } => false,
            _ => true,
        }
    }
}

fn io_hint(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            ". Free some space and run again with --resume"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            ". Choose a folder that can be written"
        }
        _ => "",
    }
}
