//! Parquet files of unknown origin, read without trusting them.

use super::guard::{Guard, Limits};
use super::parquet_check::{check_footer, check_pages};
use crate::error::StoreError;
use arrow::array::{Array, RecordBatch};
use arrow::compute::concat_batches;
use arrow::datatypes::SchemaRef;
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use std::path::{Path, PathBuf};

/// Names the format, not the build: the bytes must not differ between builds.
pub(crate) const CREATED_BY: &str = "rrf version 1";

/// Batches of one file; ends after the first error.
pub(crate) struct Batches {
    path: PathBuf,
    remedy: &'static str,
    schema: SchemaRef,
    rows: usize,
    /// Bytes that may still be decoded.
    left: u64,
    limit: u64,
    reader: Option<ParquetRecordBatchReader>,
}

impl Batches {
    pub(crate) fn schema(&self) -> SchemaRef {
        self.schema.clone()
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn stop(&mut self) {
        self.reader = None;
    }

    fn read(&mut self) -> Result<Option<RecordBatch>, StoreError> {
        let Some(reader) = self.reader.as_mut() else {
            return Ok(None);
        };
        let guard = guard(&self.path, self.remedy);
        let Some(batch) = guard.run(|| reader.next().transpose())? else {
            return Ok(None);
        };
        let size = batch
            .columns()
            .iter()
            .map(|a| a.to_data().get_slice_memory_size());
        let size = size
            .sum::<Result<usize, _>>()
            .map_err(|e| guard.corrupt(e))?;
        match self.left.checked_sub(size as u64) {
            Some(left) => self.left = left,
            None => {
                let found = self.limit.saturating_add(size as u64 - self.left);
                let what = "the size of its decoded values in bytes, so far,";
                return Err(guard.too_large(what, found, self.limit));
            }
        }
        Ok(Some(batch))
    }
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.read().transpose();
        if !matches!(next, Some(Ok(_))) {
            self.reader = None;
        }
        next
    }
}

/// Opens a file. Its bytes are read at once, so that what was checked is what is decoded.
pub(crate) fn open(
    path: &Path,
    limits: Limits,
    remedy: &'static str,
) -> Result<Batches, StoreError> {
    let guard = guard(path, remedy);
    let bytes = guard.read(limits)?;
    check_footer(&guard, &bytes)?;
    let bytes = Bytes::from(bytes);
    let builder = guard.run(|| ParquetRecordBatchReaderBuilder::try_new(bytes.clone()))?;
    let checked = check_pages(&guard, &bytes, builder.metadata(), limits)?;
    let schema = builder.schema().clone();
    let reader = guard.run(|| {
        let reader = builder.with_batch_size(checked.batch_rows).build()?;
        Ok::<_, ParquetError>(reader)
    })?;
    Ok(Batches {
        path: path.into(),
        remedy,
        schema,
        rows: checked.rows,
        left: limits.decoded_bytes,
        limit: limits.decoded_bytes,
        reader: Some(reader),
    })
}

/// All rows of a file as one batch.
pub(crate) fn read(
    path: &Path,
    limits: Limits,
    remedy: &'static str,
) -> Result<RecordBatch, StoreError> {
    let batches = open(path, limits, remedy)?;
    let schema = batches.schema();
    let batches = batches.collect::<Result<Vec<_>, _>>()?;
    guard(path, remedy).run(|| concat_batches(&schema, &batches))
}

fn guard<'a>(path: &'a Path, remedy: &'static str) -> Guard<'a> {
    Guard {
        path,
        format: "Parquet",
        remedy,
    }
}

/// One batch as Parquet, the schema's metadata with it.
pub(crate) fn encode(batch: &RecordBatch) -> Result<Vec<u8>, ParquetError> {
    let metadata = batch.schema_ref().metadata().iter();
    let metadata = metadata.map(|(key, value)| KeyValue::new(key.clone(), value.clone()));
    let properties = WriterProperties::builder()
        .set_created_by(CREATED_BY.into())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_key_value_metadata(Some(metadata.collect()))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))?;
    writer.write(batch)?;
    writer.close()?;
    Ok(bytes)
}
