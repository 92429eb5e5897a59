//! Fits a cell's radiance: a small net by Levenberg-Marquardt, or a baseline to compare it with.
//!
//! Rows and two half estimates of their radiance go in, a [`CellFit`] comes out:
//!
//! ```
//! use rrf_field::columns::{COUNT, Columns, L, P};
//! use rrf_train::{Size, TrainConfig, fit_cell};
//!
//! // 600 points on a plane under lights above it, radiance by the inverse square
//! let number = |row: usize, dimension: usize| (0.618 * (row * (dimension + 2)) as f32).fract();
//! let (mut rows, mut radiance) = (Columns::default(), Vec::new());
//! for i in 0..600 {
//!     let mut row = [0.0; COUNT];
//!     (row[P], row[P + 1]) = (number(i, 0), number(i, 1));
//!     (row[L], row[L + 2]) = (number(i, 2), 1.0 + number(i, 3));
//!     let square = (row[P] - row[L]).powi(2) + row[P + 1].powi(2) + row[L + 2].powi(2);
//!     rows.push(row);
//!     radiance.push([0.9 / square, 0.6 / square, 0.3 / square]);
//! }
//! let validation: Vec<bool> = (0..600).map(|i| i % 3 == 0).collect();
//! let config = TrainConfig {
//!     inputs: ["px", "py", "lx", "lz"].map(String::from).to_vec(),
//!     size: Size::Hidden(vec![8, 4]),
//!     ..TrainConfig::default()
//! };
//! let fit = fit_cell(0, &rows, [&radiance, &radiance], &validation, &config)?;
//! assert!(fit.validation_error.relative() < 0.02);
//! # Ok::<(), rrf_train::TrainError>(())
//! ```
//!
//! Each layer stands on those before it:
//!
//! - [`net`]: a net and its Jacobian over tiles of rows;
//! - `rows`: a cell's rows, in memory or in a file, in the units of a net;
//! - `cell`: which inputs and rows are used, and their scales;
//! - [`report`]: what comes out;
//! - `baseline`: what nets are compared with;
//! - [`fit`]: prepare, initialize, optimise, evaluate, report. The steps are those of `rrf_lm`.
//!
//! [`cut`] says where a cell is best cut in two.
//!
//! One net runs on one thread; train cells in parallel.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod baseline;
mod cell;
pub mod config;
pub mod cut;
pub mod end;
pub mod error;
pub mod fit;
pub mod net;
pub mod report;
mod rows;
mod start;

pub use config::{ARCHITECTURES, Batches, Decay, Schedule, Size, TrainConfig};
pub use end::FitEnd;
pub use error::TrainError;
pub use fit::{fit_cell, fit_from};
pub use net::blocks::Precision;
pub use report::{CellFit, HistoryRow};
pub use rows::samples::Samples;
pub use rrf_field::model::Kind;
pub use rrf_lm::{LmConfig, fix_kernels, linear_algebra};
pub use start::Start;
