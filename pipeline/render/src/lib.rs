//! Frames of a baked scene.
//!
//! A pixel's journey: [`View::direction`] gives its camera rays; the points that they meet become
//! rows of raw columns, tile by tile; direct light is exact, by shadow rays; the indirect light is
//! that of the nets of a [`rrf_field::Field`], cell by cell. All of it reads in one look in
//! `shading/mod.rs`. [`render()`] puts the parts into a [`Frame`], [`trace_frame`] makes the same
//! view by path tracing, [`exr`] and [`png`] write them, and
//! `rrf_metrics` tells them apart.
//!
//! ```
//! use rrf_metrics::tone::Exposure;
//! use rrf_render::{Lights, PathOptions, View, png, trace_frame};
//! use rrf_scene::{LoadOptions, PointLight};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let file = "../../scenes/cornell-box/scene.pbrt";
//! let scene = rrf_scene::load(file.as_ref(), &LoadOptions::default())?.unlit();
//! let tracer = rrf_trace::Tracer::new(&scene)?;
//! let mut view = View::from(&scene.cameras[0]);
//! (view.width, view.height) = (24, 16);
//! let point = PointLight { position: [0.1, 1.6, 0.2].into(), intensity: [4.0; 3].into() };
//! let lights = Lights { points: vec![point], area: false, ..Lights::default() };
//! let options = PathOptions { spp: 4, aa: 1, seed: 1 };
//! let frame = trace_frame(&tracer, &view, &lights, options, &|_rows| ())?;
//! let picture = frame.picture();
//! let shown = png::tone_mapped(&picture, Exposure::automatic(&picture));
//! assert_eq!((shown.width(), shown.height()), (24, 16));
//! # Ok(())
//! # }
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod auxiliary;
mod direct;
mod error;
mod follow;
mod frame;
mod io;
mod options;
mod origin;
mod proxies;
mod shading;
mod tile;
mod timings;
mod traced;
mod view;
mod warnings;

pub use auxiliary::{Auxiliary, add_auxiliary};
pub use direct::ShadowRays;
pub use error::RenderError;
pub use follow::MOST_FOLLOWED;
pub use frame::Frame;
pub use io::{camera_path, exr, png};
pub use options::{Part, RenderOptions, Trusted};
pub use proxies::{AreaLights, LightProxy};
pub use shading::{MOST_RESIDUAL, Passes, PointAnswers, Renderer, render};
pub use tile::{OFF_CENTRE, raw};
pub use timings::{FrameStage, FrameTimings};
pub use traced::{PathOptions, trace_frame, trace_untrusted};
pub use view::{Lens, Lights, View};
pub use warnings::{Surroundings, ViewWarning, position_text};
