//! Why two pictures could not be compared.

/// A fault of the pictures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MetricsError {
    /// Pictures without pixels.
    #[error("the pictures have no pixels")]
    Empty,
    /// Two pictures of different sizes.
    #[error(
        "the pictures differ in size: {}x{} and {}x{}; render both at one size",
        first.0, first.1, second.0, second.1
    )]
    SizeMismatch {
        /// Size of the first.
        first: (u32, u32),
        /// Size of the second.
        second: (u32, u32),
    },
    /// A pixel that is not a number or not finite.
    #[error("the {picture} picture has {value} at x {x}, y {y} (from the top left)")]
    NotFinite {
        /// "reference" or "tested".
        picture: &'static str,
        /// Column from the left.
        x: u32,
        /// Row from the top.
        y: u32,
        /// The value found.
        value: f32,
    },
    /// The reference has no light: relative measures are undefined.
    #[error("the reference picture is black everywhere; nothing can be compared relative to it")]
    BlackReference,
}
