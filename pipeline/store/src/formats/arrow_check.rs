//! What an Arrow IPC file claims about itself, checked before the decoder believes it.
//!
//! The decoder allocates what the footer says; a block longer than the file, a thousand blocks
//! over the same bytes, or eight bytes that promise 2^60 decompressed ones must end here.

use super::guard::{Guard, Limits};
use crate::error::StoreError;
use arrow::ipc::{Block, root_as_footer, root_as_message};

const MAGIC: &[u8] = b"ARROW1";
/// zstd codes 128 KiB of one value in 4 bytes.
const LARGEST_RATIO: u64 = 1 << 15;

/// Checks footer, blocks and compressed lengths of a whole file.
pub(crate) fn check(guard: &Guard, bytes: &[u8], limits: Limits) -> Result<(), StoreError> {
    let tail = bytes.len().checked_sub(10).filter(|&tail| tail >= 8);
    let (Some(tail), true) = (tail, bytes.starts_with(MAGIC) && bytes.ends_with(MAGIC)) else {
        return Err(guard.corrupt("it does not begin and end with ARROW1"));
    };
    let length = i32_at(bytes, tail).and_then(|n| usize::try_from(n).ok());
    let footer = length
        .and_then(|n| tail.checked_sub(n))
        .and_then(|start| bytes.get(start..tail))
        .ok_or_else(|| guard.corrupt("the footer's length is impossible"))?;
    let footer = root_as_footer(footer).map_err(|e| guard.corrupt(e))?;
    let blocks = footer.dictionaries().into_iter().flatten();
    let mut blocks: Vec<&Block> = blocks
        .chain(footer.recordBatches().into_iter().flatten())
        .collect();
    blocks.sort_by_key(|block| block.offset());
    let (mut end, mut decoded) = (0, 0u64);
    for block in blocks {
        let range = range(block, bytes.len(), end)
            .ok_or_else(|| guard.corrupt("a block lies outside of the file or over another"))?;
        end = range.2;
        decoded = decoded.saturating_add(decoded_bytes(guard, bytes, range)?);
    }
    if decoded > limits.decoded_bytes {
        let what = "the size of its decoded values in bytes";
        return Err(guard.too_large(what, decoded, limits.decoded_bytes));
    }
    Ok(())
}

/// Start, start of the body and end of a block that begins at `after` or later.
fn range(block: &Block, size: usize, after: usize) -> Option<(usize, usize, usize)> {
    let start = usize::try_from(block.offset()).ok()?;
    let body = start.checked_add(usize::try_from(block.metaDataLength()).ok()?)?;
    let end = body.checked_add(usize::try_from(block.bodyLength()).ok()?)?;
    (start >= after && end <= size).then_some((start, body, end))
}

/// How many bytes a block decodes to.
fn decoded_bytes(
    guard: &Guard,
    bytes: &[u8],
    (start, body, end): (usize, usize, usize),
) -> Result<u64, StoreError> {
    // A message begins with an optional continuation mark and its length.
    let mark = if i32_at(bytes, start) == Some(-1) {
        8
    } else {
        4
    };
    let message = bytes
        .get(start.saturating_add(mark)..body)
        .ok_or_else(|| guard.corrupt("a block has no message"))?;
    let message = root_as_message(message).map_err(|e| guard.corrupt(e))?;
    let batch = match message.header_as_dictionary_batch() {
        Some(dictionary) => dictionary.data(),
        None => message.header_as_record_batch(),
    };
    let batch = batch.ok_or_else(|| guard.corrupt("a block holds no record batch"))?;
    if batch.compression().is_none() {
        return Ok((end - body) as u64);
    }
    let mut decoded = 0u64;
    for buffer in batch.buffers().into_iter().flatten() {
        if buffer.length() == 0 {
            continue;
        }
        let at = usize::try_from(buffer.offset())
            .ok()
            .and_then(|offset| body.checked_add(offset))
            .filter(|at| at.saturating_add(8) <= end)
            .ok_or_else(|| guard.corrupt("a buffer lies outside of its block"))?;
        // -1: stored as it is.
        let length = i64_at(bytes, at).unwrap_or(-1);
        let length = if length == -1 {
            buffer.length()
        } else {
            length
        };
        // No codec of the format gets more out of a byte.
        let most = buffer.length().unsigned_abs().saturating_mul(LARGEST_RATIO);
        let length = u64::try_from(length).ok().filter(|&length| length <= most);
        let length =
            length.ok_or_else(|| guard.corrupt("a buffer decodes to an impossible length"))?;
        decoded = decoded.saturating_add(length);
    }
    Ok(decoded)
}

fn i32_at(bytes: &[u8], at: usize) -> Option<i32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(i32::from_le_bytes(four.try_into().ok()?))
}

fn i64_at(bytes: &[u8], at: usize) -> Option<i64> {
    let eight = bytes.get(at..at.checked_add(8)?)?;
    Some(i64::from_le_bytes(eight.try_into().ok()?))
}
