//! The bake of a transfer: one model for lights of every kind.
//!
//! Unlike a bake of nets it has no rounds and tasks; what is done is kept a batch of surfaces at a time:
//! [`bake_scene_transfer`].

mod bake;
mod config;
mod ensemble;
mod observer;
mod part_rows;
mod progress;
mod read;
mod run;
mod space;
mod summary;
mod tables;
mod test_rows;
mod test_truth;
#[cfg(test)]
mod tests;

pub use bake::{TransferOutcome, bake_scene_transfer};
pub use config::TransferBakeConfig;
pub use run::TransferRun;
pub use summary::{TransferSummary, TransferTest};
