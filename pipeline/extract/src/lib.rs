//! From a scene to training samples.
//!
//! [`plan`] draws candidate rows over the whole scene, grows the first kd-tree over them and
//! shares the rows out to its cells; [`extract`] draws rows inside a box from a stream of their
//! own and path-traces the indirect radiance of each as two independent half estimates. A draw
//! depends on (scene, light box, eye box, seed, draw) only: made alone it equals its part of the whole
//! run.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod candidates;
mod census;
mod closed;
mod config;
mod error;
mod eyes;
mod first_tree;
mod halves;
mod patches;
mod planning;
mod region;
mod solids;
mod stage;
mod visibility;

pub use candidates::{Accepted, CandidateRow, Proposal, accept};
pub use census::{Census, Rejection};
pub use config::{ExtractConfig, NarrowLight, check_box};
pub use error::ExtractError;
pub use eyes::Eyes;
pub use first_tree::Weights;
pub use planning::{CellShare, FirstPlan, plan};
pub use region::Region;
pub use stage::{Draw, Drawn, extract};
pub use visibility::{PointClass, QueryScratch, VisibilityQueries};

/// The Cornell box without its lamp, for tests.
#[cfg(test)]
fn cornell() -> rrf_scene::Scene {
    let file = "../../scenes/cornell-box/scene.pbrt";
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let scene = rrf_scene::load(&path, &rrf_scene::LoadOptions::default());
    scene.unwrap().unlit()
}
