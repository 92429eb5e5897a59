//! `rounds/000/tasks.parquet`: what schedulers read.

use crate::atomic::atomic_write;
use crate::error::StoreError;
use crate::facts;
use crate::formats::{Limits, parquet_file};
use crate::manifest::RunFacts;
use crate::schema::{self, Table};
use crate::table::{Source, TableRow, TableRows};
use crate::table_row;
use std::path::Path;

const REMEDY: &str = "Write the plan anew with `rrf plan RUN`";

table_row! {
    /// One row of the table; see `schemas/tasks.toml`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TaskRow of Tasks {
        /// Index of the task.
        pub task_id: u32,
        /// `extract` or `train`.
        pub stage: String,
        /// Round that the output belongs to.
        pub round: u32,
        /// The cell; none for rows of the whole domain that only judge.
        pub cell_id: Option<u32>,
        /// Part that an extraction makes.
        pub part: Option<u32>,
        /// blake3 of everything that the output depends on.
        pub input_hash: String,
        /// Seed of the run.
        pub seed: u64,
        /// Estimated seconds on one core.
        pub seconds: f64,
        /// Estimated bytes of memory.
        pub memory: u64,
    }
}

/// Writes the tasks of a run, whole or not at all.
///
/// # Errors
/// [`StoreError::Columns`], [`StoreError::Io`].
pub fn write_tasks(path: &Path, rows: &[TaskRow], facts: &RunFacts) -> Result<(), StoreError> {
    let mut batch = TaskRow::batch(&rows.iter().collect::<Vec<_>>())?;
    facts::stamp(&mut batch, facts);
    let bytes = parquet_file::encode(&batch).map_err(|e| StoreError::Columns {
        table: Table::Tasks.name(),
        reason: e.to_string(),
    })?;
    atomic_write(path, &bytes)
}

/// Reads the tasks of a run.
///
/// # Errors
/// [`StoreError::Io`], [`StoreError::Corrupt`], [`StoreError::Schema`], [`StoreError::Version`],
/// [`StoreError::Foreign`] for a plan of another run.
pub fn read_tasks(path: &Path, facts: &RunFacts) -> Result<Vec<TaskRow>, StoreError> {
    let batch = parquet_file::read(path, Limits::default(), REMEDY)?;
    let schema = batch.schema();
    schema::table(Table::Tasks)?.check(path, &schema, REMEDY)?;
    facts::expect(path, &schema, facts)?;
    let source = Source {
        path,
        table: Table::Tasks.name(),
        remedy: REMEDY,
    };
    TaskRow::read(&TableRows {
        batch: &batch,
        source,
    })
}
