//! Files of a run: what they are called, what is in them, and how to read them without trust.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod arrow_check;
mod arrow_file;
pub mod atomic;
mod columns;
mod content;
pub mod error;
pub mod guard;
pub mod layout;
pub mod manifest;
pub mod model;
mod parquet_check;
mod parquet_file;
pub mod part_reader;
pub mod parts;
pub mod points;
mod points_check;
pub mod samples;
pub mod schema;

pub use error::StoreError;
