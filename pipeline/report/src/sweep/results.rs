//! A sweep's table: `results.parquet`, `schemas/results.toml`.

use crate::ReportError;
use rrf_store::points::{read_rows, write_rows};
use rrf_store::table_row;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of path tracing in the column `method`.
pub const PATH_TRACING: &str = "path tracing";

table_row! {
    /// One run of a sweep; the columns of `schemas/results.toml`.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[allow(missing_docs)]
    pub struct SweepRow of Results {
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
/// [`ReportError::Store`].
pub fn write_results(path: &Path, rows: &[SweepRow]) -> Result<(), ReportError> {
    Ok(write_rows(path, rows)?)
}

/// Reads the table.
///
/// # Errors
/// [`ReportError::Store`].
pub fn read_results(path: &Path) -> Result<Vec<SweepRow>, ReportError> {
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
            SweepRow {
                method: "nets".into(),
                setting: "rows=1".into(),
                seed: u64::MAX,
                rows: Some(7),
                held_out_error: Some(0.25),
                flip: 0.5,
                ..SweepRow::default()
            },
            SweepRow {
                method: PATH_TRACING.into(),
                frame_seconds: 1e-3,
                ..SweepRow::default()
            },
        ];
        write_results(&path, &rows).unwrap();
        assert_eq!(read_results(&path).unwrap(), rows);
    }

    #[test]
    fn other_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.parquet");
        std::fs::write(&path, b"nothing of the kind").unwrap();
        assert!(read_results(&path).unwrap_err().is_bad_input());
    }
}
