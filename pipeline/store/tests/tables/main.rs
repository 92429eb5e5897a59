//! The store from outside: what is written is read back, byte for byte the same each time,
//! and what is damaged, foreign or hostile is refused with a reason.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod folder;
mod made;
mod manifest;
mod model;
mod points;
mod samples;
mod schema;
