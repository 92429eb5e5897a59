//! Parquet files of unknown origin, read without trusting them.

use crate::atomic::io_error;
use crate::error::StoreError;
use crate::guard::{Guard, Limits};
use arrow::array::RecordBatch;
use arrow::datatypes::SchemaRef;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Names the format, not the build: the bytes must not differ between builds.
pub(crate) const CREATED_BY: &str = "rrf version 1";

/// Batches of one file; ends after the first error.
pub(crate) struct Batches {
    path: PathBuf,
    remedy: &'static str,
    schema: SchemaRef,
    rows: usize,
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
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        let reader = self.reader.as_mut()?;
        let next = guard(&self.path, self.remedy).run(|| reader.next().transpose());
        match next {
            Ok(None) => {
                self.reader = None;
                None
            }
            Ok(Some(batch)) => Some(Ok(batch)),
            Err(error) => {
                self.reader = None;
                Some(Err(error))
            }
        }
    }
}

/// Opens a file.
pub(crate) fn open(
    path: &Path,
    limits: Limits,
    remedy: &'static str,
) -> Result<Batches, StoreError> {
    let file = File::open(path).map_err(|e| io_error(path, "read", e))?;
    let (schema, rows, reader) = guard(path, remedy).run(|| {
        let builder = ParquetRecordBatchReaderBuilder::try_new(file)?;
        let schema = builder.schema().clone();
        let rows = builder.metadata().file_metadata().num_rows();
        let reader = builder.with_batch_size(limits.batch_rows).build()?;
        Ok::<_, parquet::errors::ParquetError>((schema, rows, reader))
    })?;
    Ok(Batches {
        path: path.into(),
        remedy,
        schema,
        rows: usize::try_from(rows).unwrap_or(0),
        reader: Some(reader),
    })
}

fn guard<'a>(path: &'a Path, remedy: &'static str) -> Guard<'a> {
    Guard {
        path,
        format: "Parquet",
        remedy,
    }
}
