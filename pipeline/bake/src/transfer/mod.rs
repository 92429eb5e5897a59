//! The bake of a transfer: one model for lights of every kind.
//!
//! Unlike a bake of nets it works in memory and writes its tables at the end: [`bake_scene_transfer`].

mod bake;
mod config;
mod ensemble;
mod observer;
mod part_rows;
mod read;
mod run;
mod space;
mod summary;
mod tables;
#[cfg(test)]
mod tests;

pub use bake::{TransferOutcome, bake_scene_transfer};
pub use config::TransferBakeConfig;
pub use run::TransferRun;
pub use summary::TransferSummary;
