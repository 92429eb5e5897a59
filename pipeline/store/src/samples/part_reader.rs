//! One part of the samples dataset, batch by batch, everything checked.

use super::CELL_ID;
use crate::content::ContentHash;
use crate::error::StoreError;
use crate::facts::{KEY_CELL, KEY_CONTENT, KEY_PART, KEY_SCENE, KEY_SEED, KEY_TASK, fact};
use crate::formats::Limits;
use crate::formats::parquet_file::{self, Batches};
use crate::manifest::RunFacts;
use crate::schema::{self, Table};
use crate::table::{Source, TableRows};
use arrow::array::RecordBatch;
use arrow::datatypes::UInt32Type;
use std::path::{Path, PathBuf};

pub(crate) const REMEDY: &str = "Delete the file and run again with --resume to make it anew";

/// The batches of one part. Schema, version, scene, seed, cell and part are checked when it is
/// opened, cell ids and nulls in every batch, the content hash after the last: use no rows of a
/// part that ended in an error.
pub struct PartReader {
    path: PathBuf,
    cell: u32,
    batches: Batches,
    content: Option<(ContentHash, String)>,
    task: String,
}

impl PartReader {
    /// Opens a part that must be of this cell, number, scene and seed.
    ///
    /// # Errors
    /// [`StoreError::Io`], [`StoreError::Corrupt`], [`StoreError::Schema`],
    /// [`StoreError::Version`], [`StoreError::Foreign`], [`StoreError::TooLarge`].
    pub fn open(
        path: &Path,
        cell: u32,
        part: u32,
        facts: &RunFacts,
    ) -> Result<PartReader, StoreError> {
        PartReader::by(path, cell, part, facts, Limits::default())
    }

    /// The same by as many rows a batch, and from no more bytes, as the limits say.
    ///
    /// # Errors
    /// As [`PartReader::open`].
    pub fn by(
        path: &Path,
        cell: u32,
        part: u32,
        facts: &RunFacts,
        limits: Limits,
    ) -> Result<PartReader, StoreError> {
        let batches = parquet_file::open(path, limits, REMEDY)?;
        let found = batches.schema();
        schema::table(Table::Samples)?.check(path, &found, REMEDY)?;
        let fact = |key| fact(&found, key);
        let expected = [
            ("scene hash", facts.scene_hash.clone(), fact(KEY_SCENE)),
            ("seed", facts.seed.to_string(), fact(KEY_SEED)),
            ("cell", cell.to_string(), fact(KEY_CELL)),
            ("part", part.to_string(), fact(KEY_PART)),
        ];
        for (fact, expected, found) in expected {
            if expected != found {
                return Err(foreign(path, fact, expected, found));
            }
        }
        Ok(PartReader {
            path: path.into(),
            cell,
            task: fact(KEY_TASK),
            content: Some((ContentHash::new(&found), fact(KEY_CONTENT))),
            batches,
        })
    }

    /// Rows that the file says it has.
    pub fn rows(&self) -> usize {
        self.batches.rows()
    }

    /// Hash of what the part was made from, empty where the file does not say.
    pub fn task(&self) -> String {
        self.task.clone()
    }

    fn check(&mut self, batch: &RecordBatch) -> Result<(), StoreError> {
        let rows = rows(&self.path, batch);
        for (field, array) in batch.schema().fields().iter().zip(batch.columns()) {
            rows.no_null(array.as_ref(), field.name())?;
        }
        let cells = rows.numbers::<UInt32Type>(CELL_ID)?;
        if let Some(other) = cells.iter().find(|&&id| id != self.cell) {
            let (expected, found) = (self.cell.to_string(), other.to_string());
            return Err(foreign(&self.path, "cell_id", expected, found));
        }
        match &mut self.content {
            Some((hash, _)) => hash.update(batch),
            None => Ok(()),
        }
    }

    fn check_content(&mut self) -> Option<Result<RecordBatch, StoreError>> {
        let (hash, expected) = self.content.take()?;
        let found = hash
            .finish()
            .expect(&expected, &self.path, "Parquet", REMEDY);
        found.err().map(Err)
    }
}

impl Iterator for PartReader {
    type Item = Result<RecordBatch, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        let batch = match self.batches.next() {
            None => return self.check_content(),
            Some(Ok(batch)) => batch,
            Some(Err(error)) => {
                self.content = None;
                return Some(Err(error));
            }
        };
        match self.check(&batch) {
            Ok(()) => Some(Ok(batch)),
            Err(error) => {
                self.content = None;
                self.batches.stop();
                Some(Err(error))
            }
        }
    }
}

pub(super) fn rows<'a>(path: &'a Path, batch: &'a RecordBatch) -> TableRows<'a> {
    let source = Source {
        path,
        table: Table::Samples.name(),
        remedy: REMEDY,
    };
    TableRows { batch, source }
}

fn foreign(path: &Path, fact: &'static str, expected: String, found: String) -> StoreError {
    StoreError::Foreign {
        path: path.into(),
        fact,
        expected,
        found,
        remedy: "The file belongs to another run or place: choose another run folder, \
                 or delete the file and run again with --resume",
    }
}
