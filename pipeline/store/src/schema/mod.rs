//! `schemas/*.toml`: the single source of column names, types, units and meanings.
//!
//! The files are built into the program. [`table`] gives one as an Arrow schema; readers compare
//! what they find with it ([`TableSchema::check`]), writers hand their columns over by name
//! ([`TableSchema::batch`]), so a name or type that is not in `schemas/` cannot reach a file.

mod contract;
mod tables;
mod text;

use crate::error::StoreError;
pub use contract::{Arrays, Column, KEY_SCHEMA, KEY_VERSION, TableSchema};
use std::sync::LazyLock;
pub use tables::{TABLES, Table};

static ALL: LazyLock<Vec<Result<TableSchema, String>>> =
    LazyLock::new(|| TABLES.iter().map(|&t| text::parse(t)).collect());

/// The contract of one table.
///
/// # Errors
/// [`StoreError::BuiltIn`] where the schema file is wrong (a test reads them all).
pub fn table(table: Table) -> Result<&'static TableSchema, StoreError> {
    match ALL.get(table as usize) {
        Some(Ok(schema)) => Ok(schema),
        other => Err(StoreError::BuiltIn {
            table: table.name(),
            reason: match other {
                Some(Err(reason)) => reason.clone(),
                _ => "not listed".into(),
            },
        }),
    }
}
