//! Columns of lists.

use crate::columns::Source;
use crate::error::StoreError;
use arrow::array::{Array, ArrayRef, ArrowPrimitiveType, AsArray, ListArray, RecordBatch};
use arrow::array::{ListBuilder, PrimitiveBuilder, StringBuilder};
use arrow::datatypes::{DataType, Field};
use std::sync::Arc;

fn item(data_type: DataType) -> Field {
    Field::new(Field::LIST_FIELD_DEFAULT_NAME, data_type, false)
}

/// A column of lists of numbers, null where `None`.
pub(super) fn numbers<'a, T: ArrowPrimitiveType>(
    rows: impl Iterator<Item = Option<&'a [T::Native]>>,
) -> ArrayRef {
    let mut builder = ListBuilder::new(PrimitiveBuilder::<T>::new()).with_field(item(T::DATA_TYPE));
    for row in rows {
        builder.values().append_slice(row.unwrap_or_default());
        builder.append(row.is_some());
    }
    Arc::new(builder.finish())
}

/// A column of lists of names.
pub(super) fn names<'a>(rows: impl Iterator<Item = Vec<&'a str>>) -> ArrayRef {
    let mut builder = ListBuilder::new(StringBuilder::new()).with_field(item(DataType::Utf8));
    for row in rows {
        for name in row {
            builder.values().append_value(name);
        }
        builder.append(true);
    }
    Arc::new(builder.finish())
}

/// The lists of a column, null allowed for whole rows.
pub(super) fn column<'b>(
    source: &Source,
    batch: &'b RecordBatch,
    name: &str,
) -> Result<&'b ListArray, StoreError> {
    let array = source.array(batch, name)?;
    let lists = array.as_list_opt::<i32>().ok_or_else(|| {
        source.schema_error(format!(
            "column {name}: expected a list, found {}",
            array.data_type()
        ))
    })?;
    Ok(lists)
}

/// One row's numbers, `None` where null.
pub(super) fn row<T: ArrowPrimitiveType>(
    source: &Source,
    lists: &ListArray,
    name: &str,
    row: usize,
) -> Result<Option<Vec<T::Native>>, StoreError> {
    if lists.is_null(row) {
        return Ok(None);
    }
    let values = lists.value(row);
    let numbers = values.as_primitive_opt::<T>().ok_or_else(|| {
        source.schema_error(format!("column {name}: expected lists of {}", T::DATA_TYPE))
    })?;
    if numbers.null_count() > 0 {
        return Err(source.null(name, row));
    }
    Ok(Some(numbers.values().to_vec()))
}

/// One row's names.
pub(super) fn row_of_names(
    source: &Source,
    lists: &ListArray,
    name: &str,
    row: usize,
) -> Result<Vec<String>, StoreError> {
    let values = (!lists.is_null(row)).then(|| lists.value(row));
    let names = values
        .as_ref()
        .and_then(|values| values.as_string_opt::<i32>());
    names
        .filter(|names| names.null_count() == 0)
        .map(|names| names.iter().flatten().map(str::to_string).collect())
        .ok_or_else(|| source.null(name, row))
}
