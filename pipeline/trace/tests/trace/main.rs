//! The tracer against closed forms, brute force, given values and itself.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod caustics;
mod chi_square;
mod determinism;
mod estimators;
mod furnace;
mod glass;
mod hierarchy;
mod lamps;
mod mirrors;
mod own_closed;
mod own_lights;
mod planes;
mod reach;
mod reference;
mod refusals;
mod scenes;
mod statistics;
mod surface;
