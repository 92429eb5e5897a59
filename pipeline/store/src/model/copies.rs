//! Copies of the model's tables in Parquet.

use super::{REMEDY, TRANSFER_TABLES, path, read_metrics, read_model, read_transfer};
use crate::atomic::atomic_write;
use crate::error::StoreError;
use crate::formats::{Limits, arrow_file, parquet_file};
use crate::manifest::RunFacts;
use crate::schema::Table;
use std::path::{Path, PathBuf};

/// Writes `tree.parquet`, `weights.parquet` and `metrics.parquet` into a folder that is there, the same
/// columns and metadata as the run's own tables, which are checked as a whole first. Returns the files.
///
/// # Errors
/// Those of [`read_model`], [`StoreError::Columns`], [`StoreError::Io`].
pub fn write_parquet_copies(
    run: &Path,
    folder: &Path,
    facts: &RunFacts,
) -> Result<Vec<PathBuf>, StoreError> {
    read_model(run, facts)?;
    read_metrics(run, facts)?;
    copies(run, folder, &[Table::Tree, Table::Weights, Table::Metrics])
}

/// Writes the tables of a transfer as [`write_parquet_copies`] does those of nets.
///
/// # Errors
/// Those of [`read_transfer`], [`StoreError::Columns`], [`StoreError::Io`].
pub fn write_transfer_copies(
    run: &Path,
    folder: &Path,
    facts: &RunFacts,
) -> Result<Vec<PathBuf>, StoreError> {
    read_transfer(run, facts)?;
    copies(run, folder, &TRANSFER_TABLES)
}

fn copies(run: &Path, folder: &Path, tables: &[Table]) -> Result<Vec<PathBuf>, StoreError> {
    let copy = |&table: &Table| {
        let batch = arrow_file::read(&path(run, table), Limits::default(), REMEDY)?;
        let bytes = parquet_file::encode(&batch).map_err(|e| StoreError::Columns {
            table: table.name(),
            reason: e.to_string(),
        })?;
        let file = folder.join(format!("{}.parquet", table.name()));
        atomic_write(&file, &bytes)?;
        Ok(file)
    };
    tables.iter().map(copy).collect()
}
