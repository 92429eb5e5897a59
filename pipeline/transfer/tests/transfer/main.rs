//! The transfer against closed forms, and against the path tracer that knows the light.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod book;
mod conditions;
mod irradiance;
mod model;
mod patches;
mod rows;
mod scenes;
mod schema;
mod sources;
