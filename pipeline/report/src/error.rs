//! Errors of sweeps, charts, pages and tables.

use std::path::{Path, PathBuf};

/// An error with its place.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file that cannot be read or written.
    #[error("{path}: cannot {action}: {reason}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// "be read", "be written", ...
        action: &'static str,
        /// The reason.
        reason: String,
    },
    /// A file or folder that is not what is needed.
    #[error("{path}: {reason}", path = path.display())]
    Input {
        /// The file or folder.
        path: PathBuf,
        /// The fault.
        reason: String,
    },
    /// A query that cannot be answered.
    #[error("{query}: {reason} (tables: {tables})")]
    Query {
        /// The query.
        query: String,
        /// The reason.
        reason: String,
        /// The tables that there are.
        tables: String,
    },
    /// The program `rrf` failed.
    #[error("{command}: {reason}")]
    Run {
        /// The command that was run.
        command: String,
        /// Exit code and standard error.
        reason: String,
        /// Whether the input was bad: trying again does not help.
        bad_input: bool,
    },
    /// A chart or a picture.
    #[error("the picture cannot be drawn: {0}")]
    Draw(String),
    /// Frames that cannot be compared.
    #[error(transparent)]
    Metrics(#[from] rrf_metrics::MetricsError),
    /// A run folder.
    #[error(transparent)]
    Bake(#[from] rrf_bake::BakeError),
    /// A table of a run.
    #[error(transparent)]
    Store(#[from] rrf_store::StoreError),
    /// A frame.
    #[error(transparent)]
    Render(#[from] rrf_render::RenderError),
    /// A table that polars cannot show.
    #[cfg(feature = "inspect")]
    #[error("the table cannot be shown: {0}")]
    Polars(#[from] polars::error::PolarsError),
    /// The nets.
    #[error(transparent)]
    Field(#[from] rrf_field::FieldError),
}

impl ReportError {
    /// Whether the input is at fault, and trying again does not help.
    pub fn is_bad_input(&self) -> bool {
        match self {
            ReportError::Input { .. } | ReportError::Query { .. } => true,
            ReportError::Field(_) | ReportError::Metrics(_) => true,
            ReportError::Run { bad_input, .. } => *bad_input,
            ReportError::File { .. } | ReportError::Draw(_) => false,
            #[cfg(feature = "inspect")]
            ReportError::Polars(_) => false,
            ReportError::Bake(error) => error.is_bad_input(),
            ReportError::Store(error) => error.is_bad_input(),
            ReportError::Render(error) => error.is_bad_input(),
        }
    }

    pub(crate) fn file(path: &Path, action: &'static str, reason: impl ToString) -> ReportError {
        ReportError::File {
            path: path.to_path_buf(),
            action,
            reason: reason.to_string(),
        }
    }

    pub(crate) fn input(path: &Path, reason: impl ToString) -> ReportError {
        ReportError::Input {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        }
    }
}
