//! Arrow IPC files: made in memory, written whole; read without trusting them.

use crate::atomic::{atomic_write, io_error};
use crate::error::StoreError;
use crate::guard::{Guard, Limits};
use arrow::array::RecordBatch;
use arrow::datatypes::SchemaRef;
use arrow::error::ArrowError;
use arrow::ipc::reader::FileReader;
use arrow::ipc::writer::FileWriter;
use std::io::Cursor;
use std::path::Path;

/// The bytes of an Arrow IPC file of one batch, not compressed.
pub(crate) fn encode(batch: &RecordBatch) -> Result<Vec<u8>, ArrowError> {
    let mut writer = FileWriter::try_new(Vec::new(), &batch.schema())?;
    writer.write(batch)?;
    writer.into_inner()
}

/// Writes one batch as `path`, whole or not at all.
pub(crate) fn write(
    path: &Path,
    table: &'static str,
    batch: &RecordBatch,
) -> Result<(), StoreError> {
    let bytes = encode(batch).map_err(|e| StoreError::Columns {
        table,
        reason: e.to_string(),
    })?;
    atomic_write(path, &bytes)
}

/// All batches of a file, and its schema.
pub(crate) fn read(
    path: &Path,
    limits: Limits,
    remedy: &'static str,
) -> Result<(SchemaRef, Vec<RecordBatch>), StoreError> {
    let guard = Guard {
        path,
        format: "Arrow IPC",
        remedy,
    };
    let bytes = std::fs::read(path).map_err(|e| io_error(path, "read", e))?;
    crate::arrow_check::check(&guard, &bytes, limits)?;
    guard.run(|| {
        let reader = FileReader::try_new(Cursor::new(bytes), None)?;
        let schema = reader.schema();
        let batches = reader.collect::<Result<Vec<_>, _>>()?;
        Ok::<_, ArrowError>((schema, batches))
    })
}
