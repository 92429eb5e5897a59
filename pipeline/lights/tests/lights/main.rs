//! Lights against their own densities and closed forms.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod closed;
mod ies;
mod maps;
mod samplers;
mod statistics;
