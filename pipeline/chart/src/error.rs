//! Why a sweep, a chart or a page could not be made.

use std::path::PathBuf;

/// What went wrong and where.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// A file that cannot be read or written.
    #[error("{path}: cannot {action}: {reason}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// read, write, ...
        action: &'static str,
        /// The reason.
        reason: String,
    },
    /// A grid that says nothing that can be run.
    #[error("{path}: {reason}", path = path.display())]
    Grid {
        /// The grid's file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A table without what a chart needs.
    #[error("{path}: {reason}", path = path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The program itself failed on one run.
    #[error("{command}: {reason}")]
    Run {
        /// What was started.
        command: String,
        /// Exit code and standard error.
        reason: String,
        /// The input was bad: trying again does not help.
        bad_input: bool,
    },
    /// The drawing library's words.
    #[error("{path}: cannot be drawn: {reason}", path = path.display())]
    Draw {
        /// The picture.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A run folder.
    #[error(transparent)]
    Bake(#[from] rrf_bake::BakeError),
    /// A table of a run.
    #[error(transparent)]
    Store(#[from] rrf_store::StoreError),
    /// Frames that cannot be compared.
    #[error(transparent)]
    Metrics(#[from] rrf_metrics::MetricsError),
    /// A frame.
    #[error(transparent)]
    Render(#[from] rrf_render::RenderError),
}

impl ChartError {
    /// Whether the input is at fault, and trying again does not help.
    pub fn is_bad_input(&self) -> bool {
        match self {
            ChartError::Grid { .. } | ChartError::Table { .. } | ChartError::Metrics(_) => true,
            ChartError::Run { bad_input, .. } => *bad_input,
            ChartError::File { .. } | ChartError::Draw { .. } => false,
            ChartError::Bake(error) => error.is_bad_input(),
            ChartError::Store(error) => error.is_bad_input(),
            ChartError::Render(error) => error.is_bad_input(),
        }
    }

    pub(crate) fn file(
        path: &std::path::Path,
        action: &'static str,
        reason: impl ToString,
    ) -> ChartError {
        ChartError::File {
            path: path.to_path_buf(),
            action,
            reason: reason.to_string(),
        }
    }
}
