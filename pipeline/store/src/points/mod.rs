//! Tables of points: queries in, the same rows with answers out. `.parquet` or Arrow by ending.

mod check;
mod lights;

use crate::atomic::{atomic_write, check_writable};
use crate::error::StoreError;
use crate::formats::Limits;
use crate::formats::expanded::expanded_bytes;
use crate::formats::{arrow_file, parquet_file};
use crate::schema::{self, Table};
use crate::table::{Source, TableRow, TableRows};
use arrow::array::{ArrayRef, RecordBatch};
use arrow::datatypes::{FieldRef, Schema, SchemaRef};
use check::{expect_columns, geometry};
pub use lights::{POINT, SUN};
use lights::{lights, own_lights};
use rrf_field::columns::GEOMETRY;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const REMEDY: &str = "A points table has float32 columns px py pz nx ny nz vx vy vz lx ly lz";
const REMAKE: &str = "Make the table anew";

/// Queries as a file holds them.
#[derive(Clone, Debug)]
pub struct PointsTable {
    /// Every column of the file, as it was.
    pub batch: RecordBatch,
    /// `geometry[c][row]`: p, n, v, l in the order of [`rrf_field::columns::NAMES`]; world
    /// frame, metres; n and v scaled to unit length.
    pub geometry: [Vec<f32>; GEOMETRY],
    /// Names of lights in column `light`: [`POINT`], then others in the order of their first row.
    pub light_names: Vec<String>,
    /// Each row's light in `light_names`.
    pub light: Vec<u32>,
    /// Rows whose n or v was off unit length by more than one in a thousand.
    pub rescaled_rows: usize,
}

impl PointsTable {
    /// How many queries.
    pub fn len(&self) -> usize {
        self.batch.num_rows()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Parquet,
    Arrow,
}

/// Reads a points table. Columns are found by name in any order and may be float64, which is
/// rounded to the nearest float32; every other column is kept as it is.
///
/// # Errors
/// [`StoreError::BadValue`] naming column and row for a null, a number that is not finite, a
/// normal or viewer direction of length zero, and a viewer below the surface (n . v <= 0: the
/// normal must be on the side that is seen), a sun without a direction; [`StoreError::Schema`], [`StoreError::Io`],
/// [`StoreError::Corrupt`], [`StoreError::TooLarge`], [`StoreError::UnknownFormat`].
pub fn read_points(path: &Path, limits: Limits) -> Result<PointsTable, StoreError> {
    points_of(read(path, limits)?, path, limits)
}

/// As [`read_points`], of rows in memory; `path` is what errors call them.
///
/// # Errors
/// As [`read_points`].
pub fn points_of(
    batch: RecordBatch,
    path: &Path,
    limits: Limits,
) -> Result<PointsTable, StoreError> {
    let expanded = expanded_bytes(&batch);
    if expanded > limits.decoded_bytes {
        return Err(StoreError::TooLarge {
            path: path.into(),
            what: "the size of its values written out in bytes",
            found: expanded,
            limit: limits.decoded_bytes,
        });
    }
    let source = Source {
        path,
        table: Table::Points.name(),
        remedy: REMEDY,
    };
    let fields = batch.schema_ref().fields();
    for (i, field) in fields.iter().enumerate() {
        if fields.iter().take(i).any(|f| f.name() == field.name()) {
            return Err(source.schema_error(format!("column {} is there twice", field.name())));
        }
    }
    let rows = TableRows {
        batch: &batch,
        source,
    };
    expect_columns(&rows)?;
    let (light_names, light) = lights(&rows)?;
    let (geometry, rescaled_rows) = geometry(&rows, &own_lights(&light_names, &light))?;
    Ok(PointsTable {
        batch,
        geometry,
        light_names,
        light,
        rescaled_rows,
    })
}

/// Writes the rows of `input` with the columns that `table` adds, whole or not at all.
///
/// Order: the input's columns as they were, then the added ones. Columns of the input that an
/// earlier trace or query added (any that [`Table::Truth`] or [`Table::Answers`] add) are left
/// out, so that no value is taken for another's. The input's field metadata stay; its schema
/// metadata do not, they speak of the old file. `facts` go there instead.
///
/// # Errors
/// [`StoreError::Columns`] where `added` does not fit the schema or the rows,
/// [`StoreError::UnknownFormat`], [`StoreError::Io`].
pub fn write_points(
    path: &Path,
    input: &RecordBatch,
    table: Table,
    added: BTreeMap<&str, ArrayRef>,
    facts: &[(&str, String)],
) -> Result<(), StoreError> {
    write_batch(path, table, &with_columns(input, table, added, facts)?)
}

/// Writes what [`with_columns`] made, whole or not at all.
///
/// # Errors
/// [`StoreError::Columns`], [`StoreError::UnknownFormat`], [`StoreError::Io`].
pub fn write_batch(path: &Path, table: Table, batch: &RecordBatch) -> Result<(), StoreError> {
    write(path, table, batch)
}

/// Writes the rows of a table that no run owns, whole or not at all.
///
/// # Errors
/// [`StoreError::Columns`], [`StoreError::UnknownFormat`], [`StoreError::Io`].
pub fn write_rows<R: TableRow>(path: &Path, rows: &[R]) -> Result<(), StoreError> {
    write(path, R::TABLE, &R::batch(&rows.iter().collect::<Vec<_>>())?)
}

/// Reads the rows of such a table.
///
/// # Errors
/// [`StoreError::Schema`], [`StoreError::Version`], [`StoreError::Io`], [`StoreError::Corrupt`],
/// [`StoreError::TooLarge`], [`StoreError::UnknownFormat`].
pub fn read_rows<R: TableRow>(path: &Path) -> Result<Vec<R>, StoreError> {
    let batch = read(path, Limits::default())?;
    schema::table(R::TABLE)?.check(path, batch.schema_ref(), REMAKE)?;
    let source = Source {
        path,
        table: R::TABLE.name(),
        remedy: REMAKE,
    };
    R::read(&TableRows {
        batch: &batch,
        source,
    })
}

fn read(path: &Path, limits: Limits) -> Result<RecordBatch, StoreError> {
    match format(path)? {
        Format::Arrow => arrow_file::read(path, limits, REMAKE),
        Format::Parquet => parquet_file::read(path, limits, REMAKE),
    }
}

fn write(path: &Path, table: Table, batch: &RecordBatch) -> Result<(), StoreError> {
    let bytes = match format(path)? {
        Format::Arrow => arrow_file::encode(batch).map_err(|e| e.to_string()),
        Format::Parquet => parquet_file::encode(batch).map_err(|e| e.to_string()),
    };
    let bytes = bytes.map_err(|reason| StoreError::Columns {
        table: table.name(),
        reason,
    })?;
    atomic_write(path, &bytes)
}

/// Whether `path` has an ending that [`write_points`] knows and can be written, to be asked
/// before a long trace.
///
/// # Errors
/// [`StoreError::UnknownFormat`], [`StoreError::Io`].
pub fn check_ending(path: &Path) -> Result<(), StoreError> {
    format(path)?;
    check_writable(path)
}

fn format(path: &Path) -> Result<Format, StoreError> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    match ending.unwrap_or_default().to_ascii_lowercase().as_str() {
        "parquet" => Ok(Format::Parquet),
        "arrow" | "ipc" | "feather" => Ok(Format::Arrow),
        _ => Err(StoreError::UnknownFormat { path: path.into() }),
    }
}

/// The rows of `input` with the columns that `table` adds, as [`write_points`] writes them.
///
/// # Errors
/// [`StoreError::Columns`] where `added` does not fit the schema or the rows.
pub fn with_columns(
    input: &RecordBatch,
    table: Table,
    mut added: BTreeMap<&str, ArrayRef>,
    facts: &[(&str, String)],
) -> Result<RecordBatch, StoreError> {
    let fail = |reason: String| StoreError::Columns {
        table: table.name(),
        reason,
    };
    let schema = schema::table(table)?;
    let earlier: Vec<&FieldRef> = schema::table(Table::Truth)?
        .own()
        .chain(schema::table(Table::Answers)?.own())
        .chain(schema.own())
        .collect();
    let mut fields: Vec<FieldRef> = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for (field, array) in input.schema_ref().fields().iter().zip(input.columns()) {
        if !earlier.iter().any(|e| e.name() == field.name()) {
            fields.push(field.clone());
            arrays.push(array.clone());
        }
    }
    for field in schema.own() {
        let name = field.name().as_str();
        let missing = || fail(format!("column {name} is missing"));
        fields.push(field.clone());
        arrays.push(added.remove(name).ok_or_else(missing)?);
    }
    if let Some(name) = added.keys().next() {
        return Err(fail(format!("column {name} is not in the schema")));
    }
    let mut metadata = schema.arrow.metadata().clone();
    for (key, value) in facts {
        metadata.insert(key.to_string(), value.clone());
    }
    let schema: SchemaRef = Arc::new(Schema::new_with_metadata(fields, metadata));
    RecordBatch::try_new(schema, arrays).map_err(|e| fail(e.to_string()))
}
