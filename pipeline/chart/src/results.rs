//! A sweep's table: `results.parquet`, `schemas/results.toml`.

use crate::ChartError;
use rrf_store::points::{read_rows, write_rows};
use rrf_store::table_row;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What path tracing is called in the column `method`.
pub const PATH_TRACING: &str = "path tracing";
/// What one net a cell is called there.
pub const CELLS: &str = "cells";

table_row! {
    /// One run of a sweep; the columns of `schemas/results.toml`.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[allow(missing_docs)]
    pub struct Row of Results {
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
}

/// Writes the table, whole or not at all.
///
/// # Errors
/// [`ChartError::Store`].
pub fn write(path: &Path, rows: &[Row]) -> Result<(), ChartError> {
    Ok(write_rows(path, rows)?)
}

/// Reads the table.
///
/// # Errors
/// [`ChartError::Store`].
pub fn read(path: &Path) -> Result<Vec<Row>, ChartError> {
    Ok(read_rows(path)?)
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
