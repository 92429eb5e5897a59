//! What can go wrong between a folder and a store.

use std::path::PathBuf;

/// Why a run could not be fetched or stored.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// No store of this name.
    #[error("{url}: {reason}. Stores are s3://BUCKET/PATH, gs://BUCKET/PATH, az://CONTAINER/PATH")]
    Url {
        /// As it was given.
        url: String,
        /// The fault found.
        reason: String,
    },
    /// The store refused or could not be reached.
    #[error("{name}: cannot {action}: {source}")]
    Store {
        /// The object.
        name: String,
        /// What was tried.
        action: &'static str,
        /// The store's reason.
        source: object_store::Error,
    },
    /// Another writer has put other bytes under this name.
    #[error(
        "{name}: the store holds other bytes than this machine made. Give another folder, or the program version that began the run"
    )]
    Differs {
        /// The object.
        name: String,
    },
    /// This machine's copy.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
}

impl RemoteError {
    /// Whether the same call fails again until a person changes something (exit code 2).
    pub fn is_bad_input(&self) -> bool {
        matches!(self, RemoteError::Url { .. } | RemoteError::Differs { .. })
    }
}
