//! Rays that look for near surroundings.

use rrf_trace::{Hits, Rays};

/// Rays to near surroundings, and the rows that they belong to.
#[derive(Default)]
pub(super) struct Probes {
    pub(super) rays: Rays,
    pub(super) rows: Vec<u32>,
    pub(super) hits: Hits,
}
