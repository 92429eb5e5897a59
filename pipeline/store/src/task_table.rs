//! `rounds/000/tasks.parquet`: what schedulers read.

use crate::atomic::atomic_write;
use crate::columns::Source;
use crate::error::StoreError;
use crate::guard::Limits;
use crate::manifest::RunFacts;
use crate::parquet_file;
use crate::parts::{KEY_SCENE, KEY_SEED};
use crate::points::encode;
use crate::schema::{self, Table};
use arrow::array::{
    Array, ArrayRef, AsArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array,
};
use arrow::datatypes::{Float64Type, UInt32Type, UInt64Type};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const REMEDY: &str = "Write the plan anew with `rrf plan RUN`";

/// One row of the table; see `schemas/tasks.toml`.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskRow {
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
    /// Estimated seconds on one core.
    pub seconds: f64,
    /// Estimated bytes of memory.
    pub memory: u64,
}

/// Writes the tasks of a run, whole or not at all.
///
/// # Errors
/// [`StoreError::Columns`], [`StoreError::Io`].
pub fn write_tasks(path: &Path, rows: &[TaskRow], facts: &RunFacts) -> Result<(), StoreError> {
    let u32s = |get: fn(&TaskRow) -> u32| -> ArrayRef {
        Arc::new(UInt32Array::from_iter_values(rows.iter().map(get)))
    };
    let texts = |get: fn(&TaskRow) -> &str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(rows.iter().map(get)))
    };
    let cells: UInt32Array = rows.iter().map(|row| row.cell_id).collect();
    let parts: UInt32Array = rows.iter().map(|row| row.part).collect();
    let seconds = Float64Array::from_iter_values(rows.iter().map(|row| row.seconds));
    let memory = UInt64Array::from_iter_values(rows.iter().map(|row| row.memory));
    let arrays: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("task_id", u32s(|row| row.task_id)),
        ("stage", texts(|row| &row.stage)),
        ("round", u32s(|row| row.round)),
        ("cell_id", Arc::new(cells) as _),
        ("part", Arc::new(parts) as _),
        ("input_hash", texts(|row| &row.input_hash)),
        (
            "seed",
            Arc::new(UInt64Array::from(vec![facts.seed; rows.len()])) as _,
        ),
        ("seconds", Arc::new(seconds) as _),
        ("memory", Arc::new(memory) as _),
    ]);
    let mut batch = schema::table(Table::Tasks)?.batch(arrays)?;
    let metadata = batch.schema_metadata_mut();
    metadata.insert(KEY_SCENE.to_string(), facts.scene_hash.clone());
    metadata.insert(KEY_SEED.to_string(), facts.seed.to_string());
    let bytes = encode(&batch).map_err(|e| StoreError::Columns {
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
    let fact = |key: &str| schema.metadata().get(key).cloned().unwrap_or_default();
    let found = RunFacts {
        scene_hash: fact(KEY_SCENE),
        // Any seed but the one expected is refused; so is one that is no number.
        seed: fact(KEY_SEED).parse().unwrap_or(!facts.seed),
    };
    found.expect(path, facts)?;
    let source = Source {
        path,
        table: Table::Tasks.name(),
        remedy: REMEDY,
    };
    rows(&batch, &source)
}

fn rows(batch: &RecordBatch, source: &Source) -> Result<Vec<TaskRow>, StoreError> {
    let [task_id, round] =
        ["task_id", "round"].map(|name| source.values::<UInt32Type>(batch, name));
    let (task_id, round) = (task_id?, round?);
    let [stage, input_hash] = ["stage", "input_hash"].map(|name| texts(batch, source, name));
    let (stage, input_hash) = (stage?, input_hash?);
    let cell_id = source.nullable::<UInt32Type>(batch, "cell_id")?;
    let part = source.nullable::<UInt32Type>(batch, "part")?;
    let seconds = source.values::<Float64Type>(batch, "seconds")?;
    let memory = source.values::<UInt64Type>(batch, "memory")?;
    let row = |i: usize| TaskRow {
        task_id: task_id[i],
        stage: stage.value(i).into(),
        round: round[i],
        cell_id: cell_id.is_valid(i).then(|| cell_id.value(i)),
        part: part.is_valid(i).then(|| part.value(i)),
        input_hash: input_hash.value(i).into(),
        seconds: seconds[i],
        memory: memory[i],
    };
    Ok((0..batch.num_rows()).map(row).collect())
}

fn texts<'a>(
    batch: &'a RecordBatch,
    source: &Source,
    name: &'static str,
) -> Result<&'a StringArray, StoreError> {
    let array = source.array(batch, name)?;
    source.no_null(array, name)?;
    array
        .as_string_opt::<i32>()
        .ok_or_else(|| source.schema_error(format!("column {name}: not utf8")))
}
