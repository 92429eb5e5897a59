//! A hash of the values themselves. Parquet's own page checksums are optional and seldom written,
//! Arrow files have none, and a flipped bit in floats decodes to other floats without complaint.

use crate::error::StoreError;
use arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use arrow::buffer::ScalarBuffer;
use arrow::datatypes::{ArrowNativeType, DataType, Schema};
use arrow::datatypes::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, UInt32Type, UInt64Type,
};
use std::path::Path;

/// blake3 over one blake3 a column, in the batch's order. A column's goes over its name, a zero
/// byte and its values: numbers in little-endian order, truth values as a byte, texts and lists
/// each as their length (u64) and what is in them; in a nullable column a byte before each value,
/// 1, or 0 and no value. Batches may be cut anywhere.
pub(crate) struct ContentHash {
    columns: Vec<(blake3::Hasher, bool)>,
}

impl ContentHash {
    pub(crate) fn new(schema: &Schema) -> ContentHash {
        let columns = schema.fields().iter().map(|field| {
            let mut hasher = blake3::Hasher::new();
            hasher.update(field.name().as_bytes()).update(&[0]);
            (hasher, field.is_nullable())
        });
        ContentHash {
            columns: columns.collect(),
        }
    }

    /// The hash of one batch.
    pub(crate) fn of(batch: &RecordBatch) -> Result<Content, StoreError> {
        let mut hash = ContentHash::new(batch.schema_ref());
        hash.update(batch)?;
        Ok(hash.finish())
    }

    pub(crate) fn update(&mut self, batch: &RecordBatch) -> Result<(), StoreError> {
        for ((hasher, nullable), array) in self.columns.iter_mut().zip(batch.columns()) {
            if !*nullable {
                feed(hasher, array)?;
                continue;
            }
            for row in 0..array.len() {
                hasher.update(&[u8::from(!array.is_null(row))]);
                if !array.is_null(row) {
                    feed(hasher, &array.slice(row, 1))?;
                }
            }
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> Content {
        let mut whole = blake3::Hasher::new();
        for (hasher, _) in self.columns {
            whole.update(hasher.finalize().as_bytes());
        }
        Content(whole.finalize().to_hex().to_string())
    }
}

/// A hash of values, in hexadecimal digits.
pub(crate) struct Content(pub String);

impl Content {
    /// Checks that these values, found in `path`, are those that were written.
    ///
    /// # Errors
    /// [`StoreError::Corrupt`].
    pub(crate) fn expect(
        &self,
        written: &str,
        path: &Path,
        format: &'static str,
        remedy: &'static str,
    ) -> Result<(), StoreError> {
        if self.0 == written {
            return Ok(());
        }
        let found = &self.0;
        Err(StoreError::Corrupt {
            path: path.into(),
            format,
            reason: format!("its values hash to {found}, written was {written}"),
            remedy,
        })
    }
}

/// Values without nulls.
fn feed(hasher: &mut blake3::Hasher, array: &ArrayRef) -> Result<(), StoreError> {
    match array.data_type() {
        DataType::Int8 => numbers(hasher, array.as_primitive::<Int8Type>().values()),
        DataType::Int16 => numbers(hasher, array.as_primitive::<Int16Type>().values()),
        DataType::Int32 => numbers(hasher, array.as_primitive::<Int32Type>().values()),
        DataType::UInt32 => numbers(hasher, array.as_primitive::<UInt32Type>().values()),
        DataType::UInt64 => numbers(hasher, array.as_primitive::<UInt64Type>().values()),
        DataType::Float32 => numbers(hasher, array.as_primitive::<Float32Type>().values()),
        DataType::Float64 => numbers(hasher, array.as_primitive::<Float64Type>().values()),
        DataType::Boolean => {
            for value in array.as_boolean().values() {
                hasher.update(&[u8::from(value)]);
            }
        }
        DataType::Utf8 => {
            for text in array.as_string::<i32>().iter().flatten() {
                hasher.update(&(text.len() as u64).to_le_bytes());
                hasher.update(text.as_bytes());
            }
        }
        DataType::List(_) => {
            for list in array.as_list::<i32>().iter().flatten() {
                hasher.update(&(list.len() as u64).to_le_bytes());
                feed(hasher, &list)?;
            }
        }
        other => {
            return Err(StoreError::BuiltIn {
                table: "any",
                reason: format!("a column of {other} has no content hash"),
            });
        }
    }
    Ok(())
}

/// Arrow's buffers are in machine order; the machines supported are little-endian.
fn numbers<T: ArrowNativeType>(hasher: &mut blake3::Hasher, values: &ScalarBuffer<T>) {
    hasher.update(values.inner().as_slice());
}
