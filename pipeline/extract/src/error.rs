//! Why nothing could be extracted.

use crate::census::Census;
use crate::region::Region;

/// A refusal, with what would be right.
#[derive(Debug, thiserror::Error)]
pub enum ExtractError {
    /// The box of lights or of eyes is inside out or does not meet the scene.
    #[error("{what} box {bounds}: {message}")]
    Box {
        /// Of lights or of eyes.
        what: &'static str,
        /// The box.
        bounds: Region,
        /// The fault, and what would be right.
        message: String,
    },
    /// The scene has no surface.
    #[error("the scene has no triangles: there is no surface to light")]
    NoTriangle,
    /// No surface point is fit to learn from.
    #[error(
        "no usable row among {drawn} candidates ({census}): check the light box and that the surfaces face the room"
    )]
    NoRow {
        /// Candidates drawn.
        drawn: u64,
        /// Why they were left out.
        census: Census,
    },
    /// The tracer refused the rows.
    #[error(transparent)]
    Trace(#[from] rrf_trace::TraceError),
    /// A setting out of its range.
    #[error("{name} = {value}: {message}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// The value given.
        value: String,
        /// The range that would be right.
        message: &'static str,
    },
}

impl ExtractError {
    /// Whether the same call fails until the input changes (exit code 2).
    pub fn is_bad_input(&self) -> bool {
        match self {
            ExtractError::Trace(error) => error.is_bad_input(),
            _ => true,
        }
    }
}
