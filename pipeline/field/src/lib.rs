//! The baked field: a kd-tree whose leaves hold small neural nets, or what nets are compared with
//! ([`model::Kind`]).
//! Plain slices in, plain slices out; no files, no scene.
//!
//! A row is a query: surface point p, normal n, unit direction to the viewer v,
//! light position l, material parameters a (see [`columns`]).

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod baseline;
pub mod borders;
mod check;
pub mod columns;
mod derived;
mod error;
mod evaluate;
mod exp;
mod kernel;
mod kind;
mod lights;
pub mod model;
pub mod net;
mod packed;
pub mod rng;
mod spent;
mod tanh;
pub mod tree;
mod walk;

pub use baseline::{probes, quadratic};
pub use borders::{Borders, Span};
pub use error::FieldError;
pub use evaluate::Field;
pub use exp::{EXP_ERROR, MAX_EXPONENT};
pub use lights::{Light, Lit, Workspace};
pub use spent::Spent;
pub use tanh::TANH_ERROR;
