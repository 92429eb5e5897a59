//! Properties of plans, parts and tasks: random splits, random orders, lost files, random plans.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod order;
mod partition;
mod plan;
mod room;
