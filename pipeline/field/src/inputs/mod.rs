//! What a net can read, each input described once: the raw columns of a row, and inputs computed
//! from them.
//!
//! The table in `registry.rs` is the only place that names an input. Evaluation ([`fill`], and a block of
//! rows at a time in nets), dependence ([`depends_on`]), the names and offsets of [`crate::columns`],
//! the graph for ONNX and `schemas/inputs.toml`, which Python's checks evaluate, follow from it.
//!
//! To add an input, add a line to the table and write `schemas/inputs.toml` anew:
//! `RRF_WRITE=1 cargo test -p rrf-field inputs`.

pub(crate) mod block;
pub(crate) mod lane;
mod number;
mod reads;
pub(crate) mod registry;
mod toml;

use crate::columns::Columns;
pub use number::Number;
pub use reads::{Reads, depends_on, depends_on_light, derivation, evaluate_all, place, reads};
pub use registry::{COUNT, INPUTS, Input, NAMES, RAW};
pub use toml::toml;

/// Computes an input for all rows into `out`.
/// A place beyond the list gives zeros; [`crate::Field::new`] refuses such models.
pub fn fill(input: u8, rows: &Columns, out: &mut Vec<f32>) {
    out.clear();
    match rows.columns.get(usize::from(input)) {
        Some(column) => out.extend_from_slice(column),
        None if usize::from(input) < COUNT => block::append(input, rows, out),
        None => out.resize(rows.len(), 0.0),
    }
}

#[cfg(test)]
mod tests;
