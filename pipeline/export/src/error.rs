//! Why something could not be exported.

use std::path::{Path, PathBuf};

/// What went wrong and where.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A file cannot be written.
    #[error("{path}: cannot be written: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A model that is no net.
    #[error(
        "cell {cell}: {kind} models are not exported, only nets are; bake with `--method nets`"
    )]
    NoNet {
        /// The cell.
        cell: u32,
        /// What it is.
        kind: &'static str,
    },
    /// A model whose parts contradict each other.
    #[error("cell {cell}: {reason}; bake again")]
    Model {
        /// The cell.
        cell: u32,
        /// The fault found.
        reason: String,
    },
}

impl ExportError {
    /// Whether other input is needed; otherwise the same could succeed if tried again.
    pub fn is_bad_input(&self) -> bool {
        match self {
            ExportError::Write { source, .. } => rrf_files::is_permanent(source),
            _ => true,
        }
    }

    /// A file's content that cannot be made.
    pub(crate) fn encode(path: &Path, reason: impl ToString) -> ExportError {
        ExportError::Write {
            path: path.to_path_buf(),
            source: std::io::Error::other(reason.to_string()),
        }
    }
}

/// Writes a file whole or not at all.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    rrf_files::replace(path, bytes).map_err(|source| ExportError::Write {
        path: path.to_path_buf(),
        source,
    })
}
