//! The samples dataset: Hive-partitioned Parquet, one folder a cell.
//!
//! A part's bytes depend on its rows, its place and the run's facts only. It is made in memory,
//! staged in `staging/` and renamed, so that `samples/` never holds anything unfinished.

use super::SampleTable;
use super::part_reader::{PartReader, rows};
use crate::atomic::{atomic_write_from, create_folder, io_error};
use crate::content::ContentHash;
use crate::error::StoreError;
use crate::facts::{KEY_CELL, KEY_CONTENT, KEY_PART, KEY_SCENE, KEY_SEED, KEY_TASK};
use crate::formats::Limits;
use crate::formats::parquet_file::CREATED_BY;
use crate::layout;
use crate::manifest::RunFacts;
use crate::schema::{self, KEY_SCHEMA, KEY_VERSION, Table};
use arrow::array::RecordBatch;
use arrow::datatypes::DataType;
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::schema::types::ColumnPath;
use std::path::{Path, PathBuf};

/// Rows a row group: 7.6 MB of values.
const ROW_GROUP: usize = 65_536;

/// A part as written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartInfo {
    /// Where it is.
    pub path: PathBuf,
    /// Rows in it.
    pub rows: usize,
    /// Its size.
    pub bytes: usize,
    /// blake3 of the file, 64 hexadecimal digits.
    pub hash: String,
}

/// A cell's samples, all parts in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellSamples {
    /// The rows.
    pub table: SampleTable,
    /// How many of them hold a value that is not finite.
    pub not_finite_rows: usize,
}

/// Writes one part of a cell, replacing it where it exists.
///
/// # Errors
/// [`StoreError::Columns`] for columns of differing length, [`StoreError::Io`].
pub fn write_part(
    run: &Path,
    part: u32,
    table: &SampleTable,
    facts: &RunFacts,
) -> Result<PartInfo, StoreError> {
    write_part_of(run, part, table, facts, "")
}

/// [`write_part`], with what the part was made from as a hash (see [`part_task`]).
///
/// # Errors
/// As [`write_part`].
pub fn write_part_of(
    run: &Path,
    part: u32,
    table: &SampleTable,
    facts: &RunFacts,
    task: &str,
) -> Result<PartInfo, StoreError> {
    let cell = table.cell_id;
    let bytes = encode_part_of(part, table, facts, task)?;
    let path = layout::part_path(run, cell, part);
    let staging = layout::staging_folder(run);
    create_folder(&staging)?;
    create_folder(&layout::cell_folder(run, cell))?;
    let name = format!("cell={cell:06}-part-{part:05}");
    atomic_write_from(&staging, &name, &path, &bytes)?;
    Ok(PartInfo {
        path,
        rows: table.len(),
        bytes: bytes.len(),
        hash: blake3::hash(&bytes).to_hex().to_string(),
    })
}

/// The bytes that [`write_part`] writes.
///
/// # Errors
/// [`StoreError::Columns`] for columns of differing length.
pub fn encode_part(
    part: u32,
    table: &SampleTable,
    facts: &RunFacts,
) -> Result<Vec<u8>, StoreError> {
    encode_part_of(part, table, facts, "")
}

fn encode_part_of(
    part: u32,
    table: &SampleTable,
    facts: &RunFacts,
    task: &str,
) -> Result<Vec<u8>, StoreError> {
    let batch = table.to_batch()?;
    let schema = schema::table(Table::Samples)?;
    let metadata = [
        (KEY_SCHEMA, schema.table.name().to_string()),
        (KEY_VERSION, schema.version.to_string()),
        (KEY_SCENE, facts.scene_hash.clone()),
        (KEY_SEED, facts.seed.to_string()),
        (KEY_CELL, table.cell_id.to_string()),
        (KEY_PART, part.to_string()),
        (KEY_TASK, task.to_string()),
        (KEY_CONTENT, ContentHash::of(&batch)?.0),
    ]
    .map(|(key, value)| KeyValue::new(key.to_string(), value));
    encode(&batch, metadata.to_vec()).map_err(|e| StoreError::Columns {
        table: "samples",
        reason: e.to_string(),
    })
}

fn encode(batch: &RecordBatch, metadata: Vec<KeyValue>) -> Result<Vec<u8>, ParquetError> {
    let mut properties = WriterProperties::builder()
        .set_created_by(CREATED_BY.into())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_statistics_enabled(EnabledStatistics::Page)
        .set_max_row_group_row_count(Some(ROW_GROUP))
        .set_dictionary_enabled(false)
        .set_key_value_metadata(Some(metadata));
    for field in batch.schema().fields() {
        let encoding = match field.data_type() {
            // Bytes of like weight side by side: noisy floats share their exponents.
            DataType::Float32 => Encoding::BYTE_STREAM_SPLIT,
            _ => Encoding::DELTA_BINARY_PACKED,
        };
        let column = ColumnPath::from(field.name().as_str());
        properties = properties.set_column_encoding(column, encoding);
    }
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties.build()))?;
    writer.write(batch)?;
    writer.close()?;
    Ok(bytes)
}

/// Reads all parts of a cell, in order.
///
/// # Errors
/// [`StoreError::NoSamples`] for a cell without parts, and whatever [`PartReader`] finds.
pub fn read_cell(run: &Path, cell: u32, facts: &RunFacts) -> Result<CellSamples, StoreError> {
    let parts = layout::list_parts(run, cell)?;
    if parts.is_empty() {
        return Err(StoreError::NoSamples {
            path: layout::cell_folder(run, cell),
        });
    }
    let mut table = SampleTable {
        cell_id: cell,
        ..SampleTable::default()
    };
    for part in parts {
        read_part_into(run, cell, part, facts, &mut table)?;
    }
    let not_finite_rows = table.not_finite_rows();
    Ok(CellSamples {
        table,
        not_finite_rows,
    })
}

/// Reads one part of a cell.
///
/// # Errors
/// Whatever [`PartReader`] finds.
pub fn read_part(
    run: &Path,
    cell: u32,
    part: u32,
    facts: &RunFacts,
) -> Result<SampleTable, StoreError> {
    let mut table = SampleTable {
        cell_id: cell,
        ..SampleTable::default()
    };
    read_part_into(run, cell, part, facts, &mut table)?;
    Ok(table)
}

/// Hands on a part's rows, `stretch` at a time, so that no more are in memory. Of a part that ends in an
/// error none is worth anything.
///
/// # Errors
/// As [`read_part`].
pub fn each_stretch(
    run: &Path,
    place: [u32; 2],
    facts: &RunFacts,
    stretch: usize,
    see: &mut dyn FnMut(&SampleTable),
) -> Result<(), StoreError> {
    let limits = Limits {
        batch_rows: stretch,
        ..Limits::default()
    };
    let mut table = SampleTable {
        cell_id: place[0],
        ..SampleTable::default()
    };
    read_by(run, place, facts, limits, &mut table, &mut |table| {
        see(table);
        *table = SampleTable {
            cell_id: table.cell_id,
            ..SampleTable::default()
        };
    })
}

/// What a part was made from: the hash given to [`write_part_of`], empty where none was; `None`
/// without the part.
///
/// # Errors
/// Whatever [`PartReader`] finds when it opens the part.
pub fn part_task(
    run: &Path,
    cell: u32,
    part: u32,
    facts: &RunFacts,
) -> Result<Option<String>, StoreError> {
    let path = layout::part_path(run, cell, part);
    if !path.exists() {
        return Ok(None);
    }
    Ok(Some(PartReader::open(&path, cell, part, facts)?.task()))
}

/// Removes parts that nothing needs any more, and their cell's folder when it is then empty.
///
/// # Errors
/// [`StoreError::Io`]; a part that is gone already is none.
pub fn remove_part(run: &Path, cell: u32, part: u32) -> Result<(), StoreError> {
    let path = layout::part_path(run, cell, part);
    match std::fs::remove_file(&path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            return Err(io_error(&path, "remove", e));
        }
        _ => {}
    }
    // Refused while parts are left, which is what is wanted.
    let _ = std::fs::remove_dir(layout::cell_folder(run, cell));
    Ok(())
}

fn read_part_into(
    run: &Path,
    cell: u32,
    part: u32,
    facts: &RunFacts,
    table: &mut SampleTable,
) -> Result<(), StoreError> {
    let limits = Limits::default();
    read_by(run, [cell, part], facts, limits, table, &mut |_| ())
}

/// Appends a part's rows batch by batch; `after` sees the table after each.
fn read_by(
    run: &Path,
    [cell, part]: [u32; 2],
    facts: &RunFacts,
    limits: Limits,
    table: &mut SampleTable,
    after: &mut dyn FnMut(&mut SampleTable),
) -> Result<(), StoreError> {
    let path = layout::part_path(run, cell, part);
    for batch in PartReader::by(&path, cell, part, facts, limits)? {
        table.read(&rows(&path, &batch?))?;
        after(table);
    }
    Ok(())
}
