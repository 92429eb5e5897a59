//! What a Parquet file claims about itself, checked before the decoder believes it.
//!
//! The decoder allocates what headers say and follows a schema as deep as it goes. Here every
//! claim is held against the bytes that are there: schema depth and counts, column chunks that
//! lie within the file and not over each other, page sizes, numbers of values. What remains is
//! the sum of what the values decode to, which has a limit.

mod footer;
mod pages;
mod texts;
mod thrift;

use crate::error::StoreError;
use crate::formats::guard::{Guard, Limits};
use bytes::Bytes;
use parquet::basic::Type;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};

pub(crate) use footer::check_footer;

/// What the decoder may be asked for after the checks.
pub(crate) struct Checked {
    /// Rows of the file.
    pub rows: usize,
    /// Rows a batch, so that texts of a dictionary cannot make a batch exceed the limit.
    pub batch_rows: usize,
}

/// Checks row groups, column chunks and pages of a whole file.
pub(crate) fn check_pages(
    guard: &Guard,
    bytes: &Bytes,
    metadata: &ParquetMetaData,
    limits: Limits,
) -> Result<Checked, StoreError> {
    let mut chunks = Vec::new();
    let (mut rows, mut decoded, mut largest) = (0u64, 0u64, 1u64);
    for group in metadata.row_groups() {
        let group_rows = u64::try_from(group.num_rows())
            .map_err(|_| guard.corrupt("a row group of less than no rows"))?;
        rows = rows.saturating_add(group_rows);
        for column in group.columns() {
            let range = range(column, bytes.len())
                .ok_or_else(|| guard.corrupt("a column lies outside of the file"))?;
            let chunk = pages::walk(
                bytes.get(range.0..range.1).unwrap_or_default(),
                width(column),
            )
            .map_err(|reason| guard.corrupt(format!("{}: {reason}", name(column))))?;
            check_values(guard, column, &chunk, group_rows)?;
            if chunk.delta_length {
                texts::check(
                    guard,
                    bytes,
                    column,
                    usize::try_from(group_rows).unwrap_or(0),
                )?;
            }
            decoded = decoded.saturating_add(decoded_bytes(column, &chunk));
            largest = largest.max(amplified(column, &chunk));
            chunks.push(range);
        }
    }
    chunks.sort_unstable();
    let mut pairs = chunks.iter().zip(chunks.iter().skip(1));
    if pairs.any(|(a, b)| a.1 > b.0) {
        return Err(guard.corrupt("two columns lie over each other"));
    }
    if u64::try_from(metadata.file_metadata().num_rows()) != Ok(rows) {
        return Err(guard.corrupt("the rows of its groups do not sum to those of the file"));
    }
    if decoded > limits.decoded_bytes {
        let what = "the size of its decoded values in bytes";
        return Err(guard.too_large(what, decoded, limits.decoded_bytes));
    }
    // A batch of the largest texts takes a sixteenth of the limit at most.
    let most = usize::try_from(limits.decoded_bytes / 16 / largest).unwrap_or(usize::MAX);
    Ok(Checked {
        rows: usize::try_from(rows).unwrap_or(usize::MAX),
        batch_rows: limits.batch_rows.min(most).max(1),
    })
}

/// Where a column chunk lies; `None` outside of the file.
fn range(column: &ColumnChunkMetaData, size: usize) -> Option<(usize, usize)> {
    let data = column.data_page_offset();
    let start = match column.dictionary_page_offset() {
        // A group without rows may have a dictionary and no data.
        Some(dictionary) if dictionary > 0 && data == 0 => dictionary,
        Some(dictionary) if dictionary > 0 => dictionary.min(data),
        _ => data,
    };
    let start = usize::try_from(start).ok()?;
    let end = start.checked_add(usize::try_from(column.compressed_size()).ok()?)?;
    (end <= size).then_some((start, end))
}

fn check_values(
    guard: &Guard,
    column: &ColumnChunkMetaData,
    chunk: &pages::Chunk,
    rows: u64,
) -> Result<(), StoreError> {
    if chunk.delta {
        // Its decoder allocates by counts that only decoding finds.
        let name = name(column);
        let what = format!("column {name} is encoded as DELTA_BYTE_ARRAY, which is not read here");
        return Err(guard.unsupported(what, "Write it plain or with a dictionary"));
    }
    let flat = column.column_descr().max_rep_level() == 0;
    let claimed = u64::try_from(column.num_values()).ok();
    if claimed != Some(chunk.values) || (flat && chunk.values != rows) {
        let (name, found) = (name(column), chunk.values);
        return Err(guard.corrupt(format!(
            "{name}: its pages hold {found} values of {rows} rows"
        )));
    }
    Ok(())
}

/// Bytes a value, levels included; `None` for texts.
fn width(column: &ColumnChunkMetaData) -> Option<u64> {
    let descriptor = column.column_descr();
    let width = match descriptor.physical_type() {
        Type::BOOLEAN => 1,
        Type::INT32 | Type::FLOAT => 4,
        Type::INT64 | Type::DOUBLE => 8,
        Type::INT96 => 12,
        Type::FIXED_LEN_BYTE_ARRAY => u64::try_from(descriptor.type_length()).unwrap_or(0),
        Type::BYTE_ARRAY => return None,
    };
    let levels = [descriptor.max_def_level(), descriptor.max_rep_level()];
    Some(width + 2 * levels.iter().filter(|&&level| level > 0).count() as u64)
}

/// Bytes that a chunk's values take decoded, and the page at work. Texts are counted as in
/// their pages; what a dictionary repeats is counted while reading.
fn decoded_bytes(column: &ColumnChunkMetaData, chunk: &pages::Chunk) -> u64 {
    match width(column) {
        Some(width) => chunk
            .values
            .saturating_mul(width)
            .saturating_add(chunk.largest_page),
        None => chunk.values.saturating_mul(8).saturating_add(chunk.decoded),
    }
}

/// The most bytes that one value can decode to where values repeat others.
fn amplified(column: &ColumnChunkMetaData, chunk: &pages::Chunk) -> u64 {
    match width(column) {
        Some(_) => 1,
        None => chunk.dictionary.max(1),
    }
}

fn name(column: &ColumnChunkMetaData) -> String {
    column.column_path().string()
}
