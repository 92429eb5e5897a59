//! A hash of the values themselves. Parquet's own page checksums are optional and seldom written,
//! and a flipped bit in compressed floats decodes to other floats without any complaint.

use crate::error::StoreError;
use arrow::array::{Array, AsArray, RecordBatch};
use arrow::buffer::Buffer;
use arrow::datatypes::{DataType, Float32Type, Schema, UInt32Type, UInt64Type};

/// blake3 over one blake3 a column, in schema order, each over the column's name, a zero byte
/// and its values in little-endian order. Batches may be cut anywhere.
pub(crate) struct ContentHash {
    columns: Vec<blake3::Hasher>,
}

impl ContentHash {
    pub(crate) fn new(schema: &Schema) -> ContentHash {
        let columns = schema
            .fields()
            .iter()
            .map(|field| {
                let mut hasher = blake3::Hasher::new();
                hasher.update(field.name().as_bytes()).update(&[0]);
                hasher
            })
            .collect();
        ContentHash { columns }
    }

    pub(crate) fn update(&mut self, batch: &RecordBatch) -> Result<(), StoreError> {
        for (hasher, array) in self.columns.iter_mut().zip(batch.columns()) {
            hasher.update(bytes(array.as_ref())?.as_slice());
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> String {
        let mut whole = blake3::Hasher::new();
        for hasher in self.columns {
            whole.update(hasher.finalize().as_bytes());
        }
        whole.finalize().to_hex().to_string()
    }
}

fn bytes(array: &dyn Array) -> Result<Buffer, StoreError> {
    // Arrow's buffers are in machine order; the machines supported are little-endian.
    match array.data_type() {
        DataType::Float32 => Ok(array.as_primitive::<Float32Type>().values().inner().clone()),
        DataType::UInt32 => Ok(array.as_primitive::<UInt32Type>().values().inner().clone()),
        DataType::UInt64 => Ok(array.as_primitive::<UInt64Type>().values().inner().clone()),
        other => Err(StoreError::BuiltIn {
            table: "samples",
            reason: format!("no content hash for {other}"),
        }),
    }
}
