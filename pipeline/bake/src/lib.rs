//! The bake of a scene: rounds of planning, extraction, training and evaluation.
//!
//! [`bake`] is the whole of it on one screen. Its stages stand on layers, each of which knows only
//! those before it:
//!
//! - `plan/`: plain data. A [`RoundPlan`] lists cells and draws, a [`Task`] is a unit of work, an
//!   [`Evaluation`] holds the errors of a model;
//! - `policy/`: pure functions from plans and evaluations to decisions: when to stop, which cells to
//!   refine and how, what to compress, what everything should cost;
//! - `run/`: the files of a run folder, by way of [`Run`];
//! - `exec/`: the work. [`plan_first`], [`extract_samples`], [`train_nets`] and [`evaluate_round`] are the stages of a round,
//!   [`perform`] does one task.
//!
//! [`Settings`] are the options of a bake, [`BakeConfig`] what they mean for a scene.
//!
//! ```
//! use rrf_bake::{BakeConfig, Preset, bake};
//! use rrf_extract::Region;
//! use rrf_scene::LoadOptions;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
//! let scene = rrf_scene::load(&room, &LoadOptions::default())?;
//! let light_box = Region { minimum: [-0.6, 1.3, -0.6], maximum: [0.6, 1.8, 0.6] };
//! let mut config = BakeConfig::preset(Preset::Preview, light_box, 1);
//! (config.extract.cells, config.extract.rows, config.extract.paths) = (2, 2_000, 16);
//!
//! let folder = tempfile::tempdir()?;
//! let outcome = bake(&scene, &config, folder.path(), false, &())?;
//!
//! let (error, standard_error) = outcome.evaluation.error();
//! println!("relative error {error:.3} ± {standard_error:.3}");
//! assert!(outcome.rounds == 1 && error < 0.5);
//! # Ok(())
//! # }
//! ```
//!
//! [`bake_scene_transfer`] bakes a transfer in place of nets, in one go (`transfer/`).
//!
//! Stages read and write files of the run folder and nothing else, so that each can be run alone, and
//! an interrupted bake continues where it stopped.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bake;
mod error;
mod exec;
mod plan;
mod policy;
mod run;
pub mod settings;
mod transfer;
mod verify;

pub use bake::{BakeOutcome, bake};
pub use error::{BakeError, Halt};
pub use exec::context::SamplingContext;
pub use exec::evaluate::evaluate_round;
pub use exec::perform::perform;
pub use exec::plan::{estimate, plan_first};
pub use exec::stage::{extract_samples, train_nets};
pub use exec::watch::{HaltCheck, Watch};
pub use plan::evaluation::{CellEvaluation, EvaluatedRound, Evaluation, TestError};
pub use plan::next::Next;
pub use plan::refinement::{Action, Refinement};
pub use plan::round::{CellPlan, DrawPlan, EarlierFit, PartPlan, RoundPlan};
pub use plan::shard::{Job, SHARD_TASKS};
pub use plan::stop::StopReason;
pub use plan::task::{Task, TaskKind};
pub use plan::timings::Timings;
pub use policy::held_out::is_held_out;
pub use run::folder::Run;
pub use run::manifest::kernels;
pub use run::method::RunMethod;
pub use run::rounds::Progress;
pub use settings::{BakeConfig, Preset, Settings};
pub use transfer::{
    TransferBakeConfig, TransferOutcome, TransferRun, TransferSummary, TransferTest,
    bake_scene_transfer,
};
pub use verify::{Damage, Verification, verify};
