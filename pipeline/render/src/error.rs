//! Why a frame could not be made, read or written.

use std::path::PathBuf;

/// What went wrong and where.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A file cannot be written.
    #[error("{path}: cannot be written: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file cannot be read as an OpenEXR picture.
    #[error("{path}: cannot be read as OpenEXR: {reason}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// An OpenEXR file without the channels asked for.
    #[error("{path}: has no channel {wanted}; it has {found}", path = path.display())]
    Channel {
        /// The file.
        path: PathBuf,
        /// The channel that is missing.
        wanted: String,
        /// The channels that it has.
        found: String,
    },
    /// An OpenEXR file without the part asked for.
    #[error("{path}: has no part {wanted:?}; it has {found}", path = path.display())]
    Part {
        /// The file.
        path: PathBuf,
        /// The part that is missing.
        wanted: String,
        /// The parts that it has.
        found: String,
    },
    /// A picture without pixels, or with more than a 32-bit pixel id can name.
    #[error("a picture of {width}x{height} pixels cannot be made; give both sides from 1 to 65535")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// A view that shows nothing.
    #[error("the view cannot be rendered: {reason}")]
    View {
        /// The fault found.
        reason: &'static str,
    },
    /// A point light with a position or intensity that is not finite.
    #[error("point light {light} (from 0) has a position or intensity that is not finite")]
    Light {
        /// Its place in the list.
        light: usize,
    },
    /// Another light that cannot be computed with.
    #[error("light {name}: {reason}")]
    Source {
        /// Its name.
        name: String,
        /// The reason.
        reason: rrf_lights::LightError,
    },
    /// Nets know point lights only.
    #[error(
        "the scene's area lights cannot light a frame by the nets; \
         give point lights (--light x,y,z[,r,g,b]), or render the frame by path tracing"
    )]
    AreaLights,
    /// Samples that do not divide evenly over two halves and a pixel's positions.
    #[error(
        "{samples} paths a pixel cannot be shared by {aa}x{aa} positions in it and two halves; \
         give a multiple of {}", 2 * aa * aa
    )]
    Samples {
        /// Paths a pixel.
        samples: u32,
        /// Positions a side.
        aa: u32,
    },
    /// A camera path that cannot be followed.
    #[error("{path}: {reason}", path = path.display())]
    PathFile {
        /// The file.
        path: PathBuf,
        /// The row and what is wrong with it.
        reason: String,
    },
    /// Evaluation of the nets.
    #[error(transparent)]
    Field(#[from] rrf_field::FieldError),
    /// Evaluation of a transfer.
    #[error(transparent)]
    Transfer(#[from] rrf_transfer::TransferError),
    /// Tracing.
    #[error(transparent)]
    Trace(#[from] rrf_trace::TraceError),
}

impl RenderError {
    /// Whether other input is needed; otherwise the same could succeed if tried again.
    pub fn is_bad_input(&self) -> bool {
        match self {
            RenderError::Write { source, .. } => rrf_files::is_permanent(source),
            RenderError::Trace(error) => error.is_bad_input(),
            _ => true,
        }
    }
}
