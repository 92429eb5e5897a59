//! A table's contract, and what holds a file against it.

use super::tables::Table;
use crate::error::StoreError;
use arrow::array::{ArrayRef, RecordBatch};
use arrow::datatypes::{DataType, FieldRef, Fields, Schema, SchemaRef};
use std::collections::BTreeMap;
use std::path::Path;

/// Columns by name, on their way into a file.
pub type Arrays = BTreeMap<String, ArrayRef>;

/// Metadata key of the schema's name.
pub const KEY_SCHEMA: &str = "rrf.schema";
/// Metadata key of the schema's version.
pub const KEY_VERSION: &str = "rrf.schema_version";

/// One column as `schemas/` describes it.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Name in files.
    pub name: String,
    /// Type in Arrow's words: `float32`, `uint64`, `utf8`, `list<float32>`, ...
    #[serde(rename = "type")]
    pub type_name: String,
    /// Unit, `1` where there is none.
    pub unit: String,
    /// Coordinate frame: `world` or `none`.
    pub frame: String,
    /// Whether a value can be absent.
    pub nullable: bool,
    /// What the value says.
    pub meaning: String,
}

/// One table's contract.
#[derive(Clone, Debug)]
pub struct TableSchema {
    /// Which table.
    pub table: Table,
    /// Grows with every change of a column.
    pub version: u32,
    /// File format: `parquet`, `arrow` or either.
    pub format: String,
    /// Where in a run folder, or `any`.
    pub file: String,
    /// What a row is.
    pub doc: String,
    /// Columns in file order, those of the extended schema first.
    pub columns: Vec<Column>,
    /// How many of them come from the extended schema.
    pub inherited: usize,
    /// The same for Arrow; unit, frame and meaning are field metadata, name and version
    /// schema metadata.
    pub arrow: SchemaRef,
}

impl TableSchema {
    /// The columns that the schema adds to the one that it extends; all where it extends none.
    pub fn own(&self) -> impl Iterator<Item = &FieldRef> {
        self.arrow.fields().iter().skip(self.inherited)
    }

    /// A batch of this table from columns by name, put into the schema's order.
    ///
    /// # Errors
    /// [`StoreError::Columns`] where a column is missing, unknown, of another type or length.
    pub fn batch(&self, mut arrays: Arrays) -> Result<RecordBatch, StoreError> {
        let fail = |reason: String| StoreError::Columns {
            table: self.table.name(),
            reason,
        };
        let columns = self
            .arrow
            .fields()
            .iter()
            .map(|field| {
                arrays
                    .remove(field.name().as_str())
                    .ok_or_else(|| fail(format!("column {} is missing", field.name())))
            })
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(name) = arrays.keys().next() {
            return Err(fail(format!("column {name} is not in the schema")));
        }
        RecordBatch::try_new(self.arrow.clone(), columns).map_err(|e| fail(e.to_string()))
    }

    /// Compares a file's columns with the contract: names and types, in any order.
    ///
    /// # Errors
    /// [`StoreError::Schema`] naming every difference, [`StoreError::Version`].
    pub fn check(
        &self,
        path: &Path,
        found: &Schema,
        remedy: &'static str,
    ) -> Result<(), StoreError> {
        let version = found.metadata().get(KEY_VERSION);
        let name = found.metadata().get(KEY_SCHEMA);
        if name.is_some_and(|name| name == self.table.name())
            && version.is_some_and(|v| *v != self.version.to_string())
        {
            return Err(StoreError::Version {
                path: path.into(),
                table: self.table.name(),
                expected: self.version,
                found: version.cloned().unwrap_or_default(),
                remedy,
            });
        }
        let mut differences = differences(self.arrow.fields(), found.fields());
        if name.is_none_or(|name| name != self.table.name()) {
            differences.push(format!(
                "metadata {KEY_SCHEMA}: expected {}, found {}",
                self.table.name(),
                name.map_or("none", String::as_str)
            ));
        }
        if differences.is_empty() {
            return Ok(());
        }
        Err(StoreError::Schema {
            path: path.into(),
            table: self.table.name(),
            difference: differences.join("; "),
            remedy,
        })
    }
}

fn differences(expected: &Fields, found: &Fields) -> Vec<String> {
    let missing = expected.iter().filter_map(|e| {
        let same: Vec<_> = found.iter().filter(|f| f.name() == e.name()).collect();
        match same.as_slice() {
            [] => Some(format!("column {} is missing", e.name())),
            [f] if same_type(e.data_type(), f.data_type()) => None,
            [f] => Some(format!(
                "column {}: expected {}, found {}",
                e.name(),
                e.data_type(),
                f.data_type()
            )),
            _ => Some(format!("column {} is there {} times", e.name(), same.len())),
        }
    });
    let unknown = found
        .iter()
        .filter(|f| !expected.iter().any(|e| e.name() == f.name()))
        .map(|f| format!("column {} is not known", f.name()));
    missing.chain(unknown).collect()
}

/// Whether two types hold the same values; the name of a list's item does not matter.
fn same_type(a: &DataType, b: &DataType) -> bool {
    match (a, b) {
        (DataType::List(a), DataType::List(b)) => same_type(a.data_type(), b.data_type()),
        _ => a == b,
    }
}
