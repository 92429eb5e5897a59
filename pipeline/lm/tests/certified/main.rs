//! The solver on problems whose solutions others certified.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod dual;
mod models;
mod more_garbow_hillstrom;
mod nist;
