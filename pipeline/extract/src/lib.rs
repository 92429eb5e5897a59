//! From a scene to training samples.
//!
//! [`plan`] draws candidate rows over the whole scene, grows the first kd-tree over them and
//! shares the rows out to its cells; [`extract_cell`] draws one cell's rows again from its own
//! stream, path-traces the indirect radiance of each as two independent half estimates, and
//! gives back one table. A cell depends on (scene, tree, seed, cell) only: extracted alone it
//! equals its part of the whole run.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod candidates;
mod config;
mod first_tree;
mod outlook;
mod planning;
mod sobol;
mod solids;
mod stage;

pub use candidates::{Accepted, Proposal, Rejection, Row, accept};
pub use config::{Census, ExtractConfig, ExtractError, LightBox};
pub use first_tree::Weights;
pub use outlook::{Lookout, Outlook};
pub use planning::{CellPlan, Plan, plan};
pub use stage::{ExtractedCell, extract_cell};
