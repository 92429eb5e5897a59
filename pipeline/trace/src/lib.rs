//! Light in a static scene by path tracing.
//!
//! [`Tracer`] makes a scene ready for rays; [`Tracer::sample_area`] and [`Tracer::locate`] name
//! points on its surface; [`indirect`] estimates what those points send to a viewer when a
//! point light shines, direct light left out; [`own_light`] what they send when a [`LightSet`] of
//! the scene's own lights shines.
//! Paths travel in waves over columns (`wave`); their rays walk an eight-wide hierarchy
//! (`walk`); surfaces scatter as [`rrf_materials`] says. Random numbers are a function of indices
//! (`Stream`), so that any part of any result can be made again alone, on any number of
//! threads.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bidirectional;
mod check;
mod error;
mod estimates;
mod facets;
mod indirect;
mod lamps;
mod light_set;
mod locate;
mod media;
mod mirrors;
mod openings;
mod own_light;
mod passing;
mod rays;
mod reach;
mod shading;
mod surface;
mod tracer;
mod walk;
mod wave;

pub use error::TraceError;
pub use estimates::{Estimates, Sampling};
pub use indirect::{Estimator, Queries, broad_indirect, indirect, indirect_with};
pub use light_set::LightSet;
pub use openings::Openings;
pub use own_light::{Illumination, Reflections, lamp_light, own_light, sun_light};
pub use rays::{Hits, Rays};
pub use surface::SurfacePoint;
pub use tracer::Tracer;
