//! `schemas/*.toml`: the single source of column names, types, units and meanings.
//!
//! The files are built into the program. [`table`] gives one as an Arrow schema; readers compare
//! what they find with it ([`TableSchema::check`]), writers hand their columns over by name
//! ([`TableSchema::batch`]), so a name or type that is not in `schemas/` cannot reach a file.

mod text;

use crate::error::StoreError;
use arrow::array::{ArrayRef, RecordBatch};
use arrow::datatypes::{DataType, FieldRef, Fields, Schema, SchemaRef};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

/// Metadata key of the schema's name.
pub const KEY_SCHEMA: &str = "rrf.schema";
/// Metadata key of the schema's version.
pub const KEY_VERSION: &str = "rrf.schema_version";

/// The tables that the pipeline reads and writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Table {
    /// Training samples, `samples/`.
    Samples,
    /// The kd-tree, `model/tree.arrow`.
    Tree,
    /// The nets, `model/weights.arrow`.
    Weights,
    /// How the fits went, `model/metrics.arrow`.
    Metrics,
    /// Queries.
    Points,
    /// Queries with path-traced radiance.
    Truth,
    /// Queries with the model's radiance.
    Answers,
    /// Tasks of a round, `rounds/000/tasks.parquet`.
    Tasks,
    /// Runs of a sweep.
    Results,
    /// The course of a fit, `rounds/000/fits/cell=000000/steps.arrow`.
    Steps,
}

/// Every table.
pub const TABLES: [Table; 10] = [
    Table::Samples,
    Table::Tree,
    Table::Weights,
    Table::Metrics,
    Table::Points,
    Table::Truth,
    Table::Answers,
    Table::Tasks,
    Table::Results,
    Table::Steps,
];

impl Table {
    /// The schema's name, `schemas/NAME.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Table::Samples => "samples",
            Table::Tree => "tree",
            Table::Weights => "weights",
            Table::Metrics => "metrics",
            Table::Points => "points",
            Table::Truth => "truth",
            Table::Answers => "answers",
            Table::Tasks => "tasks",
            Table::Results => "results",
            Table::Steps => "steps",
        }
    }

    /// The schema's text.
    pub fn text(self) -> &'static str {
        match self {
            Table::Samples => include_str!("../../../schemas/samples.toml"),
            Table::Tree => include_str!("../../../schemas/tree.toml"),
            Table::Weights => include_str!("../../../schemas/weights.toml"),
            Table::Metrics => include_str!("../../../schemas/metrics.toml"),
            Table::Points => include_str!("../../../schemas/points.toml"),
            Table::Truth => include_str!("../../../schemas/truth.toml"),
            Table::Answers => include_str!("../../../schemas/answers.toml"),
            Table::Tasks => include_str!("../../../schemas/tasks.toml"),
            Table::Results => include_str!("../../../schemas/results.toml"),
            Table::Steps => include_str!("../../../schemas/steps.toml"),
        }
    }
}

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

impl TableSchema {
    /// The columns that the schema adds to the one that it extends; all where it extends none.
    pub fn own(&self) -> impl Iterator<Item = &FieldRef> {
        self.arrow.fields().iter().skip(self.inherited)
    }

    /// A batch of this table from columns by name, put into the schema's order.
    ///
    /// # Errors
    /// [`StoreError::Columns`] where a column is missing, unknown, of another type or length.
    pub fn batch(&self, mut arrays: BTreeMap<&str, ArrayRef>) -> Result<RecordBatch, StoreError> {
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
