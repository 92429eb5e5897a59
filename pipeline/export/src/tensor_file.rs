//! Named tensors as one safetensors file.

use crate::ExportError;
use crate::error::write_file;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::value::RawValue;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// A tensor's name, type, shape and little-endian bytes.
pub(crate) type Tensor = (String, Dtype, Vec<usize>, Vec<u8>);

/// Writes tensors and metadata; the same ones have the same bytes.
pub(crate) fn write_tensors<'a>(
    path: &Path,
    tensors: &[Tensor],
    metadata: impl Iterator<Item = (&'a str, String)>,
) -> Result<(), ExportError> {
    let views = tensors
        .iter()
        .map(|(name, dtype, shape, bytes)| {
            let view = TensorView::new(*dtype, shape.clone(), bytes);
            Ok((name, view.map_err(|e| ExportError::encode(path, e))?))
        })
        .collect::<Result<Vec<_>, ExportError>>()?;
    let metadata = metadata.map(|(name, value)| (name.to_string(), value));
    let metadata: HashMap<String, String> = metadata.collect();
    let bytes = safetensors::serialize(views, Some(metadata))
        .map_err(|e| ExportError::encode(path, e))
        .and_then(|bytes| sort_header(&bytes).map_err(|e| ExportError::encode(path, e)))?;
    write_file(path, &bytes)
}

/// The file with the names of its header in order: the library keeps metadata in a hash map, whose
/// order differs from one run to the next.
fn sort_header(file: &[u8]) -> Result<Vec<u8>, serde_json::Error> {
    let (length, rest) = file.split_at(size_of::<u64>().min(file.len()));
    let length = length.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
    let (header, data) = rest.split_at(length.min(rest.len()));
    let mut names: BTreeMap<&str, &RawValue> = serde_json::from_slice(header)?;
    let sorted = names.get("__metadata__").map(|raw| {
        let metadata: BTreeMap<String, String> = serde_json::from_str(raw.get())?;
        serde_json::value::to_raw_value(&metadata)
    });
    let sorted = sorted.transpose()?;
    if let Some(metadata) = &sorted {
        names.insert("__metadata__", metadata);
    }
    let mut header = serde_json::to_vec(&names)?;
    // tensors begin at a multiple of eight bytes
    header.resize(header.len().next_multiple_of(8), b' ');
    Ok([&(header.len() as u64).to_le_bytes(), &*header, data].concat())
}

pub(crate) fn floats(name: &str, shape: Vec<usize>, values: &[f32]) -> Tensor {
    let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    (name.into(), Dtype::F32, shape, bytes)
}

pub(crate) fn ids(name: &str, shape: Vec<usize>, values: &[u32]) -> Tensor {
    let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    (name.into(), Dtype::U32, shape, bytes)
}
