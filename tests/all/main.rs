//! The program as a person calls it: files in, files, messages and exit codes out.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bad_folder;
mod bad_points;
mod bad_run;
mod bad_scene;
mod bad_usage;
mod baselines;
mod batch;
mod chain;
mod frames;
mod judge;
mod program;
mod same_bits;
mod skies;
mod smaller;
mod table;
mod tasks;
mod truth;
