//! How far an answer is from the truth: one definition of every error that is told anywhere.
//!
//! [`relative`] has the relative error of rows and pixels, [`estimate`] its forms with the
//! reference's Monte Carlo noise taken out, [`color`] and [`flip`] what a viewer sees. A
//! comparison of two frames is the list [`FRAME_METRICS`], evaluated by [`compare()`], or by
//! [`compare_noisy()`] where the reference is noisy.
//!
//! ```
//! use rrf_metrics::{Picture, compare, relative};
//!
//! let grey = |y: f32| Picture { width: 2, height: 1, pixels: vec![glam::Vec3::splat(y); 2] };
//! let comparison = compare(&grey(0.5), &grey(0.55), None)?;
//! // a tenth too bright everywhere
//! assert!((comparison.value("relative_error").unwrap() - 0.1).abs() < 1e-6);
//! println!("{}", relative::FORMULA);
//! # Ok::<(), rrf_metrics::MetricsError>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod color;
mod compare;
mod convolve;
mod error;
pub mod estimate;
pub mod flip;
pub mod frame;
mod noisy;
mod picture;
pub mod relative;
pub mod tone;

pub use compare::{Comparison, Measure, compare};
pub use error::MetricsError;
pub use estimate::ErrorEstimate;
pub use frame::{FRAME_METRICS, FrameMetric, Pair};
pub use noisy::{NoisyMeasure, compare_noisy};
pub use picture::Picture;
pub use relative::channel_mean;
