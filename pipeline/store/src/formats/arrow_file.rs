//! Arrow IPC files: made in memory, written whole; read without trusting them.

use super::arrow_check;
use super::guard::{Guard, Limits};
use crate::atomic::atomic_write;
use crate::error::StoreError;
use arrow::array::RecordBatch;
use arrow::compute::concat_batches;
use arrow::error::ArrowError;
use arrow::ipc::CompressionType;
use arrow::ipc::reader::FileReader;
use arrow::ipc::writer::{FileWriter, IpcWriteOptions};
use std::io::Cursor;
use std::path::Path;

/// The bytes of an Arrow IPC file of one batch, not compressed.
pub(crate) fn encode(batch: &RecordBatch) -> Result<Vec<u8>, ArrowError> {
    encode_by(batch, None)
}

fn encode_by(batch: &RecordBatch, by: Option<CompressionType>) -> Result<Vec<u8>, ArrowError> {
    let options = IpcWriteOptions::default().try_with_compression(by)?;
    let mut writer = FileWriter::try_new_with_options(Vec::new(), &batch.schema(), options)?;
    writer.write(batch)?;
    writer.into_inner()
}

/// Writes one batch as `path`, compressed if asked for, whole or not at all. A file that has the bytes is
/// left alone.
pub(crate) fn write(
    path: &Path,
    table: &'static str,
    batch: &RecordBatch,
    by: Option<CompressionType>,
) -> Result<(), StoreError> {
    let bytes = encode_by(batch, by).map_err(|e| StoreError::Columns {
        table,
        reason: e.to_string(),
    })?;
    match rrf_files::read_regular(path, bytes.len() as u64) {
        Ok(own) if own == bytes => Ok(()),
        _ => atomic_write(path, &bytes),
    }
}

/// All rows of a file as one batch.
pub(crate) fn read(
    path: &Path,
    limits: Limits,
    remedy: &'static str,
) -> Result<RecordBatch, StoreError> {
    let guard = Guard {
        path,
        format: "Arrow IPC",
        remedy,
    };
    let bytes = guard.read(limits)?;
    arrow_check::check(&guard, &bytes, limits)?;
    guard.run(|| {
        let reader = FileReader::try_new(Cursor::new(bytes), None)?;
        let schema = reader.schema();
        let batches = reader.collect::<Result<Vec<_>, _>>()?;
        concat_batches(&schema, &batches)
    })
}
