//! Training where other trainers break. Each test states what happens; always: every stored
//! number is finite, the steps are at most those asked for, and a reason to stop is given.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod baselines;
mod cells;
mod inputs;
mod online;
mod right_size;
mod same_bits;
mod sizes;
mod starts;
mod streaming;
mod targets;
