//! Files forged to hurt: each claim is false in one place only.

use crate::{frugally, made};
use arrow::ipc::{Block, root_as_footer};
use rrf_store::Limits;
use rrf_store::StoreError;
use rrf_store::layout::part_path;
use rrf_store::parts::write_part;
use rrf_store::points::read_points;
use std::path::Path;

/// A Parquet file of a footer only.
fn parquet(footer: &[u8]) -> Vec<u8> {
    let length = (footer.len() as u32).to_le_bytes();
    [b"PAR1", footer, &length, b"PAR1"].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value > 127 {
        bytes.push((value & 127) as u8 | 128);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// `FileMetaData` with a schema of groups, each with that many children.
fn schema(children: impl Iterator<Item = u64>) -> Vec<u8> {
    let children: Vec<u64> = children.collect();
    // version: i32 1; schema: list of structures.
    let mut footer = vec![0x15, 2, 0x19, 0xfc];
    footer.extend(varint(children.len() as u64));
    for n in children {
        // repetition_type (3): i32 0; name (4): "a"; num_children (5).
        footer.extend([0x35, 0, 0x18, 1, b'a', 0x15]);
        footer.extend(varint(n << 1));
        footer.push(0);
    }
    // num_rows (3): i64 0; row_groups (4): empty list; stop.
    footer.extend([0x16, 0, 0x19, 0x0c, 0]);
    footer
}

fn refused(path: &Path, bytes: &[u8]) -> StoreError {
    std::fs::write(path, bytes).unwrap();
    frugally("forged", || read_points(path, Limits::default())).unwrap_err()
}

/// A decoder that follows such a schema by recursion runs out of stack, which nothing catches.
#[test]
fn endless_schema() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let deep = parquet(&schema((0..9_000).map(|n| u64::from(n < 8_999))));
    let error = refused(&path, &deep);
    assert!(
        error.to_string().contains("malformed footer or schema"),
        "{error}"
    );
    let wide = parquet(&schema([i32::MAX as u64, 0].into_iter()));
    let error = refused(&path, &wide);
    assert!(
        error.to_string().contains("malformed footer or schema"),
        "{error}"
    );
    let long = [b"PAR1".as_slice(), &[0xff, 0xff, 0xff, 0xff], b"PAR1"].concat();
    assert!(matches!(refused(&path, &long), StoreError::TooLarge { .. }));
}

/// A byte pattern that stands once in a file, replaced.
fn replace(bytes: &mut [u8], from: &[u8], to: &[u8]) {
    let at: Vec<usize> = (0..bytes.len() - from.len())
        .filter(|&at| bytes[at..].starts_with(from))
        .collect();
    assert_eq!(at.len(), 1, "the pattern stands {} times", at.len());
    bytes[at[0]..at[0] + to.len()].copy_from_slice(to);
}

fn arrow_points(path: &Path, compression: Option<arrow::ipc::CompressionType>) -> Vec<u8> {
    let batch = made::samples(1, 0, 2_000).to_batch().unwrap();
    let options = arrow::ipc::writer::IpcWriteOptions::default()
        .try_with_compression(compression)
        .unwrap();
    let file = Vec::new();
    let mut writer =
        arrow::ipc::writer::FileWriter::try_new_with_options(file, &batch.schema(), options)
            .unwrap();
    writer.write(&batch).unwrap();
    writer.write(&batch).unwrap();
    let bytes = writer.into_inner().unwrap();
    std::fs::write(path, &bytes).unwrap();
    assert_eq!(read_points(path, Limits::default()).unwrap().len(), 4_000);
    bytes
}

/// Blocks of an Arrow file's footer, as its bytes hold them.
fn blocks(bytes: &[u8]) -> Vec<Block> {
    let tail = bytes.len() - 10;
    let length = i32::from_le_bytes(bytes[tail..tail + 4].try_into().unwrap()) as usize;
    let footer = root_as_footer(&bytes[tail - length..tail]).unwrap();
    footer.recordBatches().unwrap().iter().copied().collect()
}

#[test]
fn blocks_longer_than_the_file_or_over_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let good = arrow_points(&path, None);
    let [first, second] = blocks(&good).try_into().unwrap();
    let long = Block::new(second.offset(), second.metaDataLength(), 1 << 60);
    let negative = Block::new(-8, second.metaDataLength(), second.bodyLength());
    for forged in [long, negative, first] {
        let mut bytes = good.clone();
        replace(&mut bytes, &second.0, &forged.0);
        let error = refused(&path, &bytes);
        assert!(
            error
                .to_string()
                .contains("outside of the file or over another"),
            "{error}"
        );
    }
}

/// Eight bytes that promise a buffer of any size.
#[test]
fn compressed_lengths_that_are_lies() {
    use arrow::ipc::CompressionType;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    for compression in [CompressionType::ZSTD, CompressionType::LZ4_FRAME] {
        let good = arrow_points(&path, Some(compression));
        let block = blocks(&good)[0];
        let body = (block.offset() + i64::from(block.metaDataLength())) as usize;
        let at = (body..good.len() - 8)
            .find(|&at| good[at..at + 8] == 8_000u64.to_le_bytes())
            .expect("a column of 2,000 float32");
        for length in [i64::MAX, 1 << 40, -2] {
            let mut bytes = good.clone();
            bytes[at..at + 8].copy_from_slice(&length.to_le_bytes());
            let error = refused(&path, &bytes);
            assert!(error.to_string().contains("impossible length"), "{error}");
        }
    }
}

/// A small file that is honest about being large when decoded: the limit is named.
#[test]
fn more_than_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let (arrow, parquet) = (
        folder.path().join("a.arrow"),
        folder.path().join("a.parquet"),
    );
    arrow_points(&arrow, Some(arrow::ipc::CompressionType::ZSTD));
    write_part(
        folder.path(),
        0,
        &made::samples(1, 0, 4_000),
        &made::facts(),
    )
    .unwrap();
    std::fs::copy(part_path(folder.path(), 1, 0), &parquet).unwrap();
    for path in [arrow, parquet] {
        let size = std::fs::metadata(&path).unwrap().len();
        let limits = |decoded_bytes| Limits {
            decoded_bytes,
            ..Limits::default()
        };
        // 4,000 rows of 29 columns.
        assert!(read_points(&path, limits(1 << 20)).is_ok());
        for limit in [size - 1, size + 1_000] {
            let error = read_points(&path, limits(limit)).unwrap_err();
            assert!(matches!(error, StoreError::TooLarge { limit: l, .. } if l == limit));
        }
    }
}

/// Queries with a text of a megabyte, which a dictionary repeats in every row.
fn repeated_text(rows: usize) -> arrow::array::RecordBatch {
    let batch = made::samples(1, 0, rows as u64).to_batch().unwrap();
    let mut columns: Vec<(String, arrow::array::ArrayRef)> = Vec::new();
    for (field, array) in batch.schema().fields().iter().zip(batch.columns()) {
        columns.push((field.name().clone(), array.clone()));
    }
    let text = "a".repeat(1 << 20);
    let keys = arrow::array::Int32Array::from(vec![0; rows]);
    let values = arrow::array::StringArray::from(vec![text.as_str()]);
    let texts = arrow::array::DictionaryArray::new(keys, std::sync::Arc::new(values));
    columns.push(("text".into(), std::sync::Arc::new(texts)));
    arrow::array::RecordBatch::try_from_iter(columns).unwrap()
}

/// The same in an Arrow file is small when read, and gigabytes when written out.
#[test]
fn an_arrow_dictionary_that_repeats_a_large_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    for (rows, fits) in [(2_000, true), (20_000, false)] {
        let batch = repeated_text(rows);
        let file = std::fs::File::create(&path).unwrap();
        let mut writer = arrow::ipc::writer::FileWriter::try_new(file, &batch.schema()).unwrap();
        writer.write(&batch).unwrap();
        writer.finish().unwrap();
        let read = frugally("dictionary", || read_points(&path, Limits::default()));
        match read {
            Ok(points) => assert!(fits && points.len() == rows),
            Err(error) => {
                assert!(
                    !fits && matches!(error, StoreError::TooLarge { .. }),
                    "{error}"
                );
            }
        }
    }
}

/// A text of a megabyte that a dictionary repeats in every row: a few kilobytes of file, and
/// gigabytes decoded. Reading stops at the limit, batch by batch.
#[test]
fn a_dictionary_that_repeats_a_large_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let batch = repeated_text(20_000);
    let properties = parquet::file::properties::WriterProperties::builder()
        .set_compression(parquet::basic::Compression::ZSTD(Default::default()))
        .set_dictionary_page_size_limit(4 << 20)
        .build();
    let options = parquet::arrow::arrow_writer::ArrowWriterOptions::new()
        .with_properties(properties)
        .with_skip_arrow_metadata(true);
    let file = std::fs::File::create(&path).unwrap();
    let mut writer =
        parquet::arrow::ArrowWriter::try_new_with_options(file, batch.schema(), options).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    let limits = Limits {
        decoded_bytes: 256 << 20,
        ..Limits::default()
    };
    let error = frugally("dictionary", || read_points(&path, limits)).unwrap_err();
    assert!(matches!(error, StoreError::TooLarge { .. }), "{error}");
}

/// Its decoder allocates by a count that stands within the values.
#[test]
fn delta_byte_array_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let error = refused(&path, &crate::foreign::delta_byte_array());
    assert!(matches!(error, StoreError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("column delta"), "{error}");
}

/// The number of texts within a page of lengths, forged to 2^42: 128, 4 and 16 begin the
/// header of its lengths. Its decoder asks for 16 TiB, which ends the process.
#[test]
fn a_count_within_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let (_, good) = crate::foreign::tables().swap_remove(0);
    let at = (0..good.len()).filter(|&at| good[at..].starts_with(&[0x80, 1, 4, 16]));
    let mut found = false;
    for at in at {
        let mut bytes = good.clone();
        bytes[at + 3..at + 9].copy_from_slice(&[0xff, 0xff, 0xff, 0xff, 0xff, 0x7f]);
        let error = refused(&path, &bytes).to_string();
        found |= error.contains("delta: 4398046511103 texts in a page of 16 values");
    }
    assert!(found);
}

/// A table without columns, or with columns of nulls alone, may claim any number of rows.
#[test]
fn rows_without_values() {
    use arrow::array::{NullArray, RecordBatch, RecordBatchOptions};
    let options = RecordBatchOptions::new().with_row_count(Some(usize::MAX / 2));
    let bare = RecordBatch::try_new_with_options(
        std::sync::Arc::new(arrow::datatypes::Schema::empty()),
        Vec::new(),
        &options,
    );
    let names = rrf_field::columns::NAMES.iter();
    let nulls = names.map(|name| {
        let column: arrow::array::ArrayRef = std::sync::Arc::new(NullArray::new(usize::MAX / 2));
        (*name, column, true)
    });
    let nulls = RecordBatch::try_from_iter_with_nullable(nulls);
    for batch in [bare, nulls] {
        let refused =
            rrf_store::points::points_of(batch.unwrap(), Path::new("p"), Limits::default());
        let refused = refused.unwrap_err();
        let is_said = matches!(
            refused,
            StoreError::Schema { .. } | StoreError::TooLarge { .. }
        );
        assert!(is_said, "{refused}");
    }
}
