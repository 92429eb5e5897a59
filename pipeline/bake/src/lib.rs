//! A run from beginning to end, in rounds: plan, extract, train, commit, judge, decide.
//!
//! - [`plan`](RoundPlan): what a round does, a file;
//! - [`tasks`]: the round cut into pieces that know by a hash whether they are done; [`perform`]
//!   does one;
//! - [`commit`]: fits become the model; [`Judgement`]: how good it is;
//! - [`decide`]: what the next round does about which cells, or why there is none;
//! - [`rounds`]: all of this again and again, in this process.
//!
//! Stages read and write files of the run folder and nothing else, so that each can be run alone
//! and a run that was cut off goes on where it stopped.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod bake;
mod commit;
mod config;
mod cost;
mod crew;
mod decide;
mod error;
mod experience;
mod fitting;
mod job;
mod judge;
mod plan;
mod remedy;
mod rounds;
mod run;
mod seams;
mod seconds;
mod split;
mod task;
mod test_rows;
mod trim;
mod watch;
mod work;

pub use bake::bake;
pub use commit::{commit, missing};
pub use config::{BakeConfig, Preset};
pub use decide::{Next, Stop, decide};
pub use error::BakeError;
pub use job::{CHAPTER, Job};
pub use judge::{CellJudgement, Judgement};
pub use plan::{CellPlan, DrawPlan, PartPlan, RoundPlan};
pub use remedy::{Action, Kind, Remedy};
pub use rounds::{
    Ended, Standing, finish_round, first_plan, first_tasks, perform_stage, rounds, standing,
};
pub use run::{Judged, Run};
pub use seconds::{Seconds, read_seconds};
pub use split::is_held_out;
pub use task::{Stage, Task, is_done, tasks};
pub use test_rows::Tested;
pub use watch::{Halt, Watch};
pub use work::{Site, perform, perform_job};
