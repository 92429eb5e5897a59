//! Light in a static scene by path tracing.
//!
//! [`Tracer`] makes a scene ready for rays; [`Tracer::sample_area`] and [`Tracer::locate`] name
//! points on its surface; [`indirect`] estimates what those points send to a viewer when a
//! point light shines, direct light left out; [`trace_rows`] makes pictures of a [`View`].
//! Paths travel in waves over columns (`wave`); their rays walk an eight-wide hierarchy
//! (`wide`); surfaces scatter by [`bsdf`]. Random numbers are a function of indices
//! ([`Stream`]), so that any part of any result can be made again alone, on any number of
//! threads.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod bsdf;
mod error;
mod frame;
mod indirect;
mod lamps;
mod math;
mod rays;
pub mod rng;
pub mod sobol;
mod surface;
mod tracer;
mod view;
mod wave;
mod wide;

pub use error::TraceError;
pub use frame::{Halves, Layers, Lights, PrimaryHits, direct_light, primary_hits, trace_rows};
pub use indirect::{Estimates, Estimator, Queries, Sampling, indirect, indirect_with};
pub use rays::{Hit, Hits, Rays};
pub use rng::Stream;
pub use surface::{Frame, SurfacePoint};
pub use tracer::Tracer;
pub use view::{Lens, View};
