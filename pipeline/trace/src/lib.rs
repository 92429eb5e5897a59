//! Light in a static scene by path tracing.
//!
//! [`Tracer`] makes a scene ready for rays; [`Tracer::sample_area`] and [`Tracer::locate`] name
//! points on its surface; [`indirect`] estimates what those points send to a viewer when a
//! point light shines, direct light left out. Random numbers are a function of
//! indices ([`Stream`]), so that any part of any result can be made again alone.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod bsdf;
mod error;
mod indirect;
mod math;
mod rays;
pub mod rng;
pub mod sobol;
mod surface;
mod tracer;
mod wave;
mod wide;

pub use error::TraceError;
pub use indirect::{Estimates, Queries, indirect};
pub use rays::{Hits, Rays};
pub use rng::Stream;
pub use surface::{Frame, SurfacePoint};
pub use tracer::Tracer;
