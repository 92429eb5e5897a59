//! Errors of serving the page.

/// An error of the page's server.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The port is taken or not allowed.
    #[error(
        "127.0.0.1:{port}: cannot listen there: {source}; give another --port, or 0 for a free one"
    )]
    Bind {
        /// The port asked for.
        port: u16,
        /// The reason.
        source: std::io::Error,
    },
    /// The system gives no random numbers: no token can be made.
    #[error("the system gives no random numbers for the page's token: {0}")]
    Random(getrandom::Error),
    /// No thread to trace with.
    #[error("no threads for path tracing: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl ViewError {
    /// Whether other input is needed; otherwise the same could succeed if tried again.
    pub fn is_bad_input(&self) -> bool {
        matches!(self, ViewError::Bind { .. })
    }
}
