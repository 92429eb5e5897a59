//! A run from beginning to end: load, plan, extract, train, judge.
//!
//! Every stage reads and writes files of the run folder and nothing else, so that each can be
//! run alone and a run that was cut off goes on where it stopped.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bake;
mod config;
mod error;
mod judge;
mod run;
mod split;
mod stages;

pub use bake::{BakeReport, bake};
pub use config::{BakeConfig, Preset};
pub use error::BakeError;
pub use judge::{CellJudgement, Judgement, judge};
pub use run::Run;
pub use stages::{Watch, extract, plan, train};
