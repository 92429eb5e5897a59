//! Evidence: what a bake costs and what it gives.
//!
//! [`sweep::run`] bakes a scene with every setting of a [`grid::Grid`], measures each run against
//! a path-traced frame and keeps one row a run ([`results::Row`], `schemas/results.toml`);
//! [`chart::write`] draws the Pareto fronts of error against time and size, as SVG, PNG and one
//! page with hover and zoom; [`rounds::write`] does so for the rounds of runs; [`page::write`] is
//! all about one run on one page. No page needs anything from outside.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod chart;
mod draw;
mod error;
mod frames;
pub mod front;
pub mod grid;
mod html;
mod interactive;
pub mod page;
mod program;
pub mod results;
pub mod rounds;
pub mod sweep;

pub use error::ChartError;
pub use program::{Done, Program};
