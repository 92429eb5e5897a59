//! A sweep's table: `results.parquet`, `schemas/results.toml`.

use crate::ChartError;
use arrow::array::{Array, ArrayRef, AsArray, Float64Array, RecordBatch, RecordBatchOptions};
use arrow::array::{StringArray, UInt64Array};
use arrow::datatypes::{Float64Type, Schema, UInt64Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rrf_store::points::write_points;
use rrf_store::schema::Table;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// What path tracing is called in the column `method`.
pub const PATH_TRACING: &str = "path tracing";
/// What one net a cell is called there.
pub const CELLS: &str = "cells";

/// One run of a sweep; the columns of `schemas/results.toml`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Row {
    pub method: String,
    pub setting: String,
    pub seed: u64,
    pub preset: Option<String>,
    pub rows: Option<u64>,
    pub paths: Option<u64>,
    pub cells: Option<u64>,
    pub weights: Option<u64>,
    pub target: Option<f64>,
    pub bake_seconds: Option<f64>,
    pub bake_cpu_seconds: Option<f64>,
    pub frame_seconds: f64,
    pub frame_cpu_seconds: f64,
    pub model_bytes: Option<u64>,
    pub held_out_error: Option<f64>,
    pub held_out_error_se: Option<f64>,
    pub points_error: Option<f64>,
    pub points_error_se: Option<f64>,
    pub frame_error: f64,
    pub flip: f64,
    pub delta_e_2000: f64,
}

/// Writes the table, whole or not at all.
///
/// # Errors
/// [`ChartError::Store`], [`ChartError::Table`].
pub fn write(path: &Path, rows: &[Row]) -> Result<(), ChartError> {
    let text = |get: fn(&Row) -> Option<&str>| {
        Arc::new(rows.iter().map(get).collect::<StringArray>()) as ArrayRef
    };
    let whole = |get: fn(&Row) -> Option<u64>| {
        Arc::new(rows.iter().map(get).collect::<UInt64Array>()) as ArrayRef
    };
    let real = |get: fn(&Row) -> Option<f64>| {
        Arc::new(rows.iter().map(get).collect::<Float64Array>()) as ArrayRef
    };
    let columns = BTreeMap::from([
        ("method", text(|r| Some(&r.method))),
        ("setting", text(|r| Some(&r.setting))),
        ("seed", whole(|r| Some(r.seed))),
        ("preset", text(|r| r.preset.as_deref())),
        ("rows", whole(|r| r.rows)),
        ("paths", whole(|r| r.paths)),
        ("cells", whole(|r| r.cells)),
        ("weights", whole(|r| r.weights)),
        ("target", real(|r| r.target)),
        ("bake_seconds", real(|r| r.bake_seconds)),
        ("bake_cpu_seconds", real(|r| r.bake_cpu_seconds)),
        ("frame_seconds", real(|r| Some(r.frame_seconds))),
        ("frame_cpu_seconds", real(|r| Some(r.frame_cpu_seconds))),
        ("model_bytes", whole(|r| r.model_bytes)),
        ("held_out_error", real(|r| r.held_out_error)),
        ("held_out_error_se", real(|r| r.held_out_error_se)),
        ("points_error", real(|r| r.points_error)),
        ("points_error_se", real(|r| r.points_error_se)),
        ("frame_error", real(|r| Some(r.frame_error))),
        ("flip", real(|r| Some(r.flip))),
        ("delta_e_2000", real(|r| Some(r.delta_e_2000))),
    ]);
    let options = RecordBatchOptions::new().with_row_count(Some(rows.len()));
    let nothing = RecordBatch::try_new_with_options(Arc::new(Schema::empty()), vec![], &options)
        .map_err(|e| broken(path, e))?;
    Ok(write_points(path, &nothing, Table::Results, columns, &[])?)
}

/// Reads the table.
///
/// # Errors
/// [`ChartError::File`], [`ChartError::Table`] for a column that is missing or of another type.
pub fn read(path: &Path) -> Result<Vec<Row>, ChartError> {
    let file = std::fs::File::open(path).map_err(|e| ChartError::file(path, "be read", e))?;
    let batches = ParquetRecordBatchReaderBuilder::try_new(file)
        .and_then(|builder| builder.build())
        .map_err(|e| broken(path, e))?;
    let mut rows = Vec::new();
    for batch in batches {
        let batch = batch.map_err(|e| broken(path, e))?;
        let columns = Columns {
            batch: &batch,
            path,
        };
        for row in 0..batch.num_rows() {
            rows.push(columns.row(row)?);
        }
    }
    Ok(rows)
}

struct Columns<'a> {
    batch: &'a RecordBatch,
    path: &'a Path,
}

impl Columns<'_> {
    fn row(&self, at: usize) -> Result<Row, ChartError> {
        Ok(Row {
            method: self.needed("method", self.text("method", at)?)?,
            setting: self.needed("setting", self.text("setting", at)?)?,
            seed: self.needed("seed", self.whole("seed", at)?)?,
            preset: self.text("preset", at)?,
            rows: self.whole("rows", at)?,
            paths: self.whole("paths", at)?,
            cells: self.whole("cells", at)?,
            weights: self.whole("weights", at)?,
            target: self.real("target", at)?,
            bake_seconds: self.real("bake_seconds", at)?,
            bake_cpu_seconds: self.real("bake_cpu_seconds", at)?,
            frame_seconds: self.needed("frame_seconds", self.real("frame_seconds", at)?)?,
            frame_cpu_seconds: self
                .needed("frame_cpu_seconds", self.real("frame_cpu_seconds", at)?)?,
            model_bytes: self.whole("model_bytes", at)?,
            held_out_error: self.real("held_out_error", at)?,
            held_out_error_se: self.real("held_out_error_se", at)?,
            points_error: self.real("points_error", at)?,
            points_error_se: self.real("points_error_se", at)?,
            frame_error: self.needed("frame_error", self.real("frame_error", at)?)?,
            flip: self.needed("flip", self.real("flip", at)?)?,
            delta_e_2000: self.needed("delta_e_2000", self.real("delta_e_2000", at)?)?,
        })
    }

    fn column(&self, name: &str) -> Result<&ArrayRef, ChartError> {
        let column = self.batch.column_by_name(name);
        column.ok_or_else(|| {
            broken(
                self.path,
                format!("no sweep's table: column {name} is missing"),
            )
        })
    }

    fn wrong(&self, name: &str) -> ChartError {
        broken(
            self.path,
            format!("column {name} is not of the type in schemas/results.toml"),
        )
    }

    fn text(&self, name: &str, at: usize) -> Result<Option<String>, ChartError> {
        let array = self.column(name)?;
        let texts = array
            .as_string_opt::<i32>()
            .ok_or_else(|| self.wrong(name))?;
        Ok(texts.is_valid(at).then(|| texts.value(at).to_string()))
    }

    fn whole(&self, name: &str, at: usize) -> Result<Option<u64>, ChartError> {
        let array = self.column(name)?.as_primitive_opt::<UInt64Type>();
        let numbers = array.ok_or_else(|| self.wrong(name))?;
        Ok(numbers.is_valid(at).then(|| numbers.value(at)))
    }

    fn real(&self, name: &str, at: usize) -> Result<Option<f64>, ChartError> {
        let array = self.column(name)?.as_primitive_opt::<Float64Type>();
        let numbers = array.ok_or_else(|| self.wrong(name))?;
        Ok(numbers.is_valid(at).then(|| numbers.value(at)))
    }

    fn needed<T>(&self, name: &str, value: Option<T>) -> Result<T, ChartError> {
        value.ok_or_else(|| broken(self.path, format!("column {name} has a null")))
    }
}

fn broken(path: &Path, reason: impl ToString) -> ChartError {
    ChartError::Table {
        path: path.to_path_buf(),
        reason: reason.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.parquet");
        let rows = vec![
            Row {
                method: CELLS.into(),
                setting: "rows=1".into(),
                seed: u64::MAX,
                rows: Some(7),
                held_out_error: Some(0.25),
                flip: 0.5,
                ..Row::default()
            },
            Row {
                method: PATH_TRACING.into(),
                frame_seconds: 1e-3,
                ..Row::default()
            },
        ];
        write(&path, &rows).unwrap();
        assert_eq!(read(&path).unwrap(), rows);
    }

    #[test]
    fn other_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.parquet");
        std::fs::write(&path, b"nothing of the kind").unwrap();
        assert!(read(&path).unwrap_err().is_bad_input());
    }
}
