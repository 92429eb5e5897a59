//! Where columns are read from, for messages.

use crate::error::StoreError;
use arrow::array::{Array, ArrowPrimitiveType, AsArray, RecordBatch};
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

    pub(crate) fn bad_value(&self, column: &str, row: usize, reason: String) -> StoreError {
        StoreError::BadValue {
            path: self.path.into(),
            column: column.into(),
            row,
            reason,
        }
    }
}

/// The rows of one file, column by column.
#[derive(Clone, Copy)]
pub struct TableRows<'a> {
    pub(crate) batch: &'a RecordBatch,
    pub(crate) source: Source<'a>,
}

impl<'a> TableRows<'a> {
    pub(crate) fn array(&self, name: &str) -> Result<&'a dyn Array, StoreError> {
        let array = self.batch.column_by_name(name).map(|array| array.as_ref());
        array.ok_or_else(|| {
            self.source
                .schema_error(format!("column {name} is missing"))
        })
    }

    /// A column of numbers without nulls.
    pub(crate) fn numbers<T: ArrowPrimitiveType>(
        &self,
        name: &str,
    ) -> Result<&'a [T::Native], StoreError> {
        let array = self.array(name)?;
        let numbers = array.as_primitive_opt::<T>();
        let numbers = numbers.ok_or_else(|| self.wrong_type(name, array))?;
        self.no_null(array, name)?;
        Ok(numbers.values())
    }

    pub(crate) fn no_null(&self, array: &dyn Array, name: &str) -> Result<(), StoreError> {
        match (0..array.len()).find(|&row| array.null_count() > 0 && array.is_null(row)) {
            None => Ok(()),
            Some(row) => Err(self.null(name, row)),
        }
    }

    pub(crate) fn null(&self, name: &str, row: usize) -> StoreError {
        self.source.bad_value(name, row, "no value (null)".into())
    }

    pub(crate) fn wrong_type(&self, name: &str, found: &dyn Array) -> StoreError {
        let difference = format!("column {name}: not of type {}", found.data_type());
        self.source.schema_error(difference)
    }
}
