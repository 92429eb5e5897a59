//! Texts in DELTA_LENGTH_BYTE_ARRAY: their number stands once more within the page, and the
//! decoder allocates by it.

use super::thrift::varint;
use crate::error::StoreError;
use crate::formats::guard::Guard;
use bytes::Bytes;
use parquet::basic::Encoding;
use parquet::column::page::{Page, PageReader};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use std::sync::Arc;

/// Checks the pages of a chunk whose headers have been checked.
pub(super) fn check(
    guard: &Guard,
    bytes: &Bytes,
    column: &ColumnChunkMetaData,
    rows: usize,
) -> Result<(), StoreError> {
    let bytes = Arc::new(bytes.clone());
    let mut pages = guard.run(|| SerializedPageReader::new(bytes, column, rows, None))?;
    while let Some(page) = guard.run(|| pages.get_next_page())? {
        if page.encoding() != Encoding::DELTA_LENGTH_BYTE_ARRAY {
            continue;
        }
        let most = u64::from(page.num_values());
        let count = values(&page, column).and_then(count);
        if count.is_none_or(|count| count > most) {
            let name = column.column_path().string();
            let found = count.map_or("an unknown number of".into(), |n| n.to_string());
            let reason = format!("{name}: {found} texts in a page of {most} values");
            return Err(guard.corrupt(reason));
        }
    }
    Ok(())
}

/// A page's bytes after its levels (parquet-format, "Data pages").
fn values<'a>(page: &'a Page, column: &ColumnChunkMetaData) -> Option<&'a [u8]> {
    match page {
        Page::DataPage { buf, .. } => {
            let descriptor = column.column_descr();
            let levels = [descriptor.max_rep_level(), descriptor.max_def_level()];
            let mut rest = buf.as_ref();
            for _ in levels.iter().filter(|&&level| level > 0) {
                let length = u32::from_le_bytes(rest.get(..4)?.try_into().ok()?);
                rest = rest.get(4..)?.get(usize::try_from(length).ok()?..)?;
            }
            Some(rest)
        }
        Page::DataPageV2 {
            buf,
            def_levels_byte_len: definition,
            rep_levels_byte_len: repetition,
            ..
        } => buf.get(usize::try_from(definition.checked_add(*repetition)?).ok()?..),
        Page::DictionaryPage { .. } => None,
    }
}

/// Third number of the header of DELTA_BINARY_PACKED lengths (parquet-format, Encodings.md):
/// block size, miniblocks a block, values.
fn count(bytes: &[u8]) -> Option<u64> {
    let mut at = 0;
    let [_, _, count] = [(); 3].map(|()| varint(bytes, &mut at));
    count
}
