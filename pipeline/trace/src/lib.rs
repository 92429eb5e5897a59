//! Light in a static scene by path tracing.
//!
//! [`Tracer`] makes a scene ready for rays; [`Tracer::sample_area`] and [`Tracer::locate`] name
//! points on its surface; [`indirect`] estimates what those points send to a viewer when a
//! point light shines, direct light left out; [`lamp_light`] what they send when the scene's own
//! lamps shine.
//! Paths travel in waves over columns (`wave`); their rays walk an eight-wide hierarchy
//! (`walk`); surfaces scatter as [`rrf_materials`] says. Random numbers are a function of indices
//! (`Stream`), so that any part of any result can be made again alone, on any number of
//! threads.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod check;
mod error;
mod estimates;
mod facets;
mod indirect;
mod lamp_light;
mod lamps;
mod locate;
mod mirrors;
mod rays;
mod shading;
mod surface;
mod tracer;
mod walk;
mod wave;

pub use error::TraceError;
pub use estimates::{Estimates, Sampling};
pub use indirect::{Estimator, Queries, indirect, indirect_with};
pub use lamp_light::{Reflections, lamp_light};
pub use rays::{Hits, Rays};
pub use surface::SurfacePoint;
pub use tracer::Tracer;
