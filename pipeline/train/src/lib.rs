//! Solver-Marquardt training of a cell's net.
//!
//! Rows and two half estimates go in, a [`fit::CellFit`] comes out:
//!
//! - [`prepare`] leaves out rows that are not finite, drops inputs that do not vary, scales;
//! - [`tile`] runs a net over 128 rows at a time, [`blocks`] sums JᵀWJ from them without ever
//!   forming J, on one matrix kernel ([`gemm`]) and a vectorised tanh ([`simd`]);
//! - `rrf_lm` takes damped steps;
//! - [`problem`] makes a net and its relative loss such a problem;
//! - [`rows`] holds the rows in memory, or reads them again at each pass from a file where they
//!   are too many ([`spill`]);
//! - [`halves`] tells errors without Monte Carlo noise;
//! - `baseline` fits what nets are compared with;
//! - [`cut`] says where a cell is best cut in two;
//! - [`fit`] puts it together: [`fit::fit_cell`].
//!
//! One net runs on one thread; train cells in parallel.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod baseline;
pub mod blocks;
mod cell;
pub mod chunk;
pub mod config;
mod curvature;
pub mod cut;
mod descent;
pub mod end;
pub mod error;
mod evidence;
mod factors;
pub mod fit;
pub mod gemm;
pub mod halves;
mod judge;
mod logarithm;
pub mod online;
mod ordered;
mod place;
pub mod prepare;
pub mod problem;
mod products;
mod prune;

pub mod rows;
mod scratch;
mod search;
pub mod simd;
pub mod spill;
mod streamed;
mod tangent;
pub mod tile;
mod warm;

pub use blocks::Precision;
pub use config::{Batches, Decay, LADDER, Mode, Size, TrainConfig};
pub use error::TrainError;
pub use fit::{CellFit, CellMetrics, FitReport, HistoryRow, fit_cell, fit_from};
pub use halves::ErrorEstimate;
pub use end::FitEnd;
pub use rrf_field::model::Kind;
pub use rrf_lm::LmConfig;

#[cfg(test)]
mod made_up;
#[cfg(test)]
mod tests;
