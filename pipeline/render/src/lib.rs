//! Frames from a baked field, and how far they are from the truth.
//!
//! A pixel's journey: [`View::direction`] gives its camera rays; what they meet becomes rows of
//! raw columns, tile by tile; direct light is exact, by shadow rays; the indirect light is what
//! the nets of a [`rrf_field::Field`] say, cell by cell. [`render()`] puts the parts into a
//! [`Frame`], [`trace_frame`] does the same view by path tracing, [`exr`] and [`png`] write them,
//! `rrf_metrics` tells them apart.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod blend;
mod direct;
mod emitter;
mod error;
pub mod exr;
mod facts;
mod fallback;
mod few_columns;
mod frame;
mod layers;
mod learned;
mod notice;
pub mod path;
pub mod png;
mod probes;
mod render;
mod sampled;
mod stages;
mod stand_in;
mod tile;
mod trace_frame;
mod view;

pub use error::RenderError;
pub use fallback::trace_untrusted;
pub use frame::Frame;
pub use notice::{Notice, notices, on_surface};
pub use render::{Negative, Part, RenderOptions, Renderer, Trusted, render};
pub use sampled::ShadowRays;
pub use stages::Stages;
pub use stand_in::{Lamps, StandIn};
pub use tile::{OFF_CENTRE, raw};
pub use trace_frame::trace_frame;
pub use view::{Lens, Lights, View};
