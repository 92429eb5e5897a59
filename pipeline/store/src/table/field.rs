//! Fields of rows, rows of tables.

use super::source::TableRows;
use super::value::Value;
use crate::error::StoreError;
use crate::schema::{self, Arrays, Table};
use arrow::array::RecordBatch;

/// The type of a row's field: one column, or several whose names follow from the field's.
pub trait RowField: Sized {
    /// Adds the columns of the field `name`.
    fn write(name: &str, values: &[&Self], to: &mut Arrays);

    /// Reads the columns of the field `name`.
    ///
    /// # Errors
    /// [`StoreError::Schema`] for a column that is missing or of another type,
    /// [`StoreError::BadValue`] for a null.
    fn read(name: &str, from: &TableRows) -> Result<Vec<Self>, StoreError>;
}

impl<T: Value> RowField for T {
    fn write(name: &str, values: &[&T], to: &mut Arrays) {
        to.insert(
            name.into(),
            T::array(values.iter().map(|value| Some(*value))),
        );
    }

    fn read(name: &str, from: &TableRows) -> Result<Vec<T>, StoreError> {
        let values = <Option<T> as RowField>::read(name, from)?;
        let values = values.into_iter().enumerate();
        values
            .map(|(row, value)| value.ok_or_else(|| from.null(name, row)))
            .collect()
    }
}

impl<T: Value> RowField for Option<T> {
    fn write(name: &str, values: &[&Option<T>], to: &mut Arrays) {
        to.insert(
            name.into(),
            T::array(values.iter().map(|value| value.as_ref())),
        );
    }

    fn read(name: &str, from: &TableRows) -> Result<Vec<Option<T>>, StoreError> {
        let array = from.array(name)?;
        T::values(array).ok_or_else(|| from.wrong_type(name, array))
    }
}

/// A row of a table; [`crate::table_row!`] implements it.
pub trait TableRow: Sized {
    /// The table that it is a row of.
    const TABLE: Table;

    /// Adds the columns of the rows.
    fn write(rows: &[&Self], to: &mut Arrays);

    /// Reads all rows.
    ///
    /// # Errors
    /// As [`RowField::read`].
    fn read(from: &TableRows) -> Result<Vec<Self>, StoreError>;

    /// The rows as a batch of their table.
    ///
    /// # Errors
    /// [`StoreError::Columns`] where fields and schema differ.
    fn batch(rows: &[&Self]) -> Result<RecordBatch, StoreError> {
        let mut columns = Arrays::new();
        Self::write(rows, &mut columns);
        schema::table(Self::TABLE)?.batch(columns)
    }
}
