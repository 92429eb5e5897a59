//! Typed access to a batch's columns by name; a null in them is an error, not a zero.

use crate::error::StoreError;
use arrow::array::{Array, ArrowPrimitiveType, AsArray, PrimitiveArray, RecordBatch};
use std::path::Path;

/// What a reader of one file knows for its messages.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub path: &'a Path,
    pub table: &'static str,
    pub remedy: &'static str,
}

impl Source<'_> {
    pub(crate) fn schema_error(&self, difference: String) -> StoreError {
        StoreError::Schema {
            path: self.path.into(),
            table: self.table,
            difference,
            remedy: self.remedy,
        }
    }

    /// A table that is well-formed but makes no model.
    pub(crate) fn model(&self, place: String, reason: impl ToString) -> StoreError {
        StoreError::Model {
            path: self.path.into(),
            place,
            reason: reason.to_string(),
            remedy: self.remedy,
        }
    }

    pub(crate) fn null(&self, name: &str, row: usize) -> StoreError {
        StoreError::BadValue {
            path: self.path.into(),
            column: name.into(),
            row,
            reason: "no value (null)".into(),
        }
    }

    pub(crate) fn array<'b>(
        &self,
        batch: &'b RecordBatch,
        name: &str,
    ) -> Result<&'b dyn Array, StoreError> {
        batch
            .column_by_name(name)
            .map(|array| array.as_ref())
            .ok_or_else(|| self.schema_error(format!("column {name} is missing")))
    }

    /// A numeric column that may hold nulls.
    pub(crate) fn nullable<'b, T: ArrowPrimitiveType>(
        &self,
        batch: &'b RecordBatch,
        name: &str,
    ) -> Result<&'b PrimitiveArray<T>, StoreError> {
        let array = self.array(batch, name)?;
        array.as_primitive_opt::<T>().ok_or_else(|| {
            let (expected, found) = (T::DATA_TYPE, array.data_type());
            self.schema_error(format!("column {name}: expected {expected}, found {found}"))
        })
    }

    /// A numeric column without nulls.
    pub(crate) fn values<'b, T: ArrowPrimitiveType>(
        &self,
        batch: &'b RecordBatch,
        name: &str,
    ) -> Result<&'b [T::Native], StoreError> {
        let array = self.nullable::<T>(batch, name)?;
        self.no_null(array, name)?;
        Ok(array.values())
    }

    pub(crate) fn no_null(&self, array: &dyn Array, name: &str) -> Result<(), StoreError> {
        if array.null_count() == 0 {
            return Ok(());
        }
        let row = (0..array.len()).find(|&row| array.is_null(row));
        Err(self.null(name, row.unwrap_or_default()))
    }
}
