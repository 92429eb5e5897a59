//! Frames from a baked field, and how far they are from the truth.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod color;
pub mod compare;
mod convolve;
mod error;
pub mod exr;
pub mod flip;
mod frame;
pub mod png;
pub mod tone;

pub use error::RenderError;
pub use frame::{Frame, Picture, luminance};
