//! Why something could not be exported.

use std::path::PathBuf;

/// What went wrong and where.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A file cannot be written.
    #[error("{path}: cannot be written: {reason}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
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
        !matches!(self, ExportError::Write { .. })
    }

    pub(crate) fn write(path: &std::path::Path, reason: impl ToString) -> ExportError {
        ExportError::Write {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        }
    }
}
