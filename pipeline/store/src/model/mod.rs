//! The model's three tables: `model/tree.arrow`, `weights.arrow` and `metrics.arrow`; the four of a
//! transfer in their place.
//!
//! Arrow IPC files, so that any Arrow reader opens them without this program; those of a transfer are compressed by
//! zstd.
//! Scene hash, seed and the hash of the run are in their schema metadata. What is read back is checked as a whole:
//! lengths, ids, finite numbers, a tree that ends, a net for every leaf.

mod copies;
mod fit;
mod metrics;
mod of_run;
mod steps;
mod transfer;
mod tree;
mod weights;

pub use copies::{write_parquet_copies, write_transfer_copies};
pub use fit::{Fit, fit_task, read_fit, write_fit};
pub use metrics::{CellMetrics, Seams, Spread};
pub use steps::{FitStep, read_steps, write_steps};
pub use transfer::{
    TRANSFER_TABLES, TransferCellRow, TransferNodeRow, TransferPartRow, TransferProgressRow,
    TransferRow, TransferTables, model_table_path, read_transfer, read_transfer_progress,
    transfer_fault, write_transfer, write_transfer_progress,
};
pub use tree::ModelTree;

use crate::atomic::create_folder;
use crate::content::ContentHash;
use crate::error::StoreError;
use crate::facts::{self, KEY_CONTENT, fact};
use crate::formats::Limits;
use crate::formats::arrow_file;
use crate::layout::model_folder;
use crate::manifest::RunFacts;
use crate::schema::{self, Table};
use crate::table::{Source, TableRow, TableRows};
use arrow::array::RecordBatch;
use arrow::ipc::CompressionType;
use rrf_field::model::CellModel;
use std::path::{Path, PathBuf};

const REMEDY: &str = "Delete the folder that it lies in and go on by `rrf bake --resume`";

/// A tree and the net of each of its leaves, by ascending cell id.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Which cell a query belongs to, and what the cell has seen.
    pub tree: ModelTree,
    /// One net a leaf, by ascending cell id.
    pub cells: Vec<CellModel>,
}

/// Writes the tree.
///
/// # Errors
/// [`StoreError::Model`] for what could not be read back, [`StoreError::Io`].
pub fn write_tree(run: &Path, tree: &ModelTree, facts: &RunFacts) -> Result<(), StoreError> {
    let path = path(run, Table::Tree);
    let nodes = tree.to_rows(source(&path, Table::Tree))?;
    let nodes: Vec<_> = nodes.iter().collect();
    write(&path, &nodes, facts, &of_run::stamp(run)?)
}

/// Reads the tree.
///
/// # Errors
/// [`StoreError::Io`], [`StoreError::Corrupt`], [`StoreError::Schema`],
/// [`StoreError::Version`], [`StoreError::Foreign`], [`StoreError::Model`].
pub fn read_tree(run: &Path, facts: &RunFacts) -> Result<ModelTree, StoreError> {
    let path = path(run, Table::Tree);
    ModelTree::from_rows(
        read_own(run, Table::Tree, facts)?,
        source(&path, Table::Tree),
    )
}

/// Writes the nets, sorted by cell id.
///
/// # Errors
/// [`StoreError::Model`] for what could not be read back, [`StoreError::Io`].
pub fn write_weights(run: &Path, cells: &[CellModel], facts: &RunFacts) -> Result<(), StoreError> {
    write_models(
        &path(run, Table::Weights),
        cells,
        facts,
        &of_run::stamp(run)?,
    )
}

/// Reads the nets, by ascending cell id.
///
/// # Errors
/// As [`read_tree`].
pub fn read_weights(run: &Path, facts: &RunFacts) -> Result<Vec<CellModel>, StoreError> {
    let path = path(run, Table::Weights);
    weights::from_rows(
        read_own(run, Table::Weights, facts)?,
        source(&path, Table::Weights),
    )
}

/// Writes how the fits went, sorted by cell id.
///
/// # Errors
/// [`StoreError::Io`].
pub fn write_metrics(
    run: &Path,
    cells: &[CellMetrics],
    facts: &RunFacts,
) -> Result<(), StoreError> {
    let mut cells: Vec<&CellMetrics> = cells.iter().collect();
    cells.sort_by_key(|cell| cell.cell_id);
    write(
        &path(run, Table::Metrics),
        &cells,
        facts,
        &of_run::stamp(run)?,
    )
}

/// Reads how the fits went, by ascending cell id.
///
/// # Errors
/// As [`read_tree`].
pub fn read_metrics(run: &Path, facts: &RunFacts) -> Result<Vec<CellMetrics>, StoreError> {
    read_own(run, Table::Metrics, facts)
}

/// Reads tree and nets; every leaf must have its net, and every net its leaf.
///
/// # Errors
/// As [`read_tree`].
pub fn read_model(run: &Path, facts: &RunFacts) -> Result<Model, StoreError> {
    let tree = read_tree(run, facts)?;
    let cells = read_weights(run, facts)?;
    let mut leaves: Vec<u32> = tree.leaves().map(|(_, cell)| cell).collect();
    leaves.sort_unstable();
    let nets: Vec<u32> = cells.iter().map(|cell| cell.cell).collect();
    if leaves == nets {
        return Ok(Model { tree, cells });
    }
    let odd = leaves.iter().find(|cell| nets.binary_search(cell).is_err());
    let (table, cell, reason) = match odd {
        Some(cell) => (
            Table::Weights,
            Some(cell),
            "no net, but a leaf in tree.arrow",
        ),
        None => (
            Table::Tree,
            nets.iter().find(|cell| leaves.binary_search(cell).is_err()),
            "no leaf, but a net in weights.arrow",
        ),
    };
    let cell = cell.copied().unwrap_or(u32::MAX);
    let path = path(run, table);
    Err(source(&path, table).model(format!("cell {cell}"), reason))
}

fn path(run: &Path, table: Table) -> PathBuf {
    path_in(&model_folder(run), table)
}

fn path_in(folder: &Path, table: Table) -> PathBuf {
    folder.join(format!("{}.arrow", table.name()))
}

fn source(path: &Path, table: Table) -> Source<'_> {
    Source {
        path,
        table: table.name(),
        remedy: REMEDY,
    }
}

/// Writes models, sorted by cell id, with `more` metadata.
fn write_models(
    path: &Path,
    cells: &[CellModel],
    facts: &RunFacts,
    more: &[(&str, String)],
) -> Result<(), StoreError> {
    let rows = weights::to_rows(cells, source(path, Table::Weights))?;
    write(path, &rows.iter().collect::<Vec<_>>(), facts, more)
}

/// Writes rows with the run's facts, their content hash and `more` as metadata.
fn write<R: TableRow>(
    path: &Path,
    rows: &[&R],
    facts: &RunFacts,
    more: &[(&str, String)],
) -> Result<(), StoreError> {
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    let mut batch = R::batch(rows)?;
    let content = ContentHash::of(&batch)?;
    facts::stamp(&mut batch, facts);
    let metadata = batch.schema_metadata_mut();
    metadata.insert(KEY_CONTENT.to_string(), content.0);
    metadata.extend(
        more.iter()
            .map(|(key, value)| (key.to_string(), value.clone())),
    );
    arrow_file::write(path, R::TABLE.name(), &batch, compression(R::TABLE))
}

/// How a table is compressed: the 8-bit numbers and sorted nodes of a transfer lose a quarter.
fn compression(table: Table) -> Option<CompressionType> {
    let is_packed = TRANSFER_TABLES.contains(&table) || table == Table::TransferProgress;
    is_packed.then_some(CompressionType::ZSTD)
}

/// Reads rows of a table in `model/`, which only the run itself may have written.
fn read_own<R: TableRow>(run: &Path, table: Table, facts: &RunFacts) -> Result<Vec<R>, StoreError> {
    let path = path(run, table);
    let batch = read_batch(&path, table, facts)?;
    of_run::expect(run, &path, batch.schema_ref(), REMEDY)?;
    rows(&batch, &path)
}

/// Reads rows; see [`read_batch`].
fn read<R: TableRow>(path: &Path, facts: &RunFacts) -> Result<Vec<R>, StoreError> {
    rows(&read_batch(path, R::TABLE, facts)?, path)
}

fn rows<R: TableRow>(batch: &RecordBatch, path: &Path) -> Result<Vec<R>, StoreError> {
    let source = source(path, R::TABLE);
    R::read(&TableRows { batch, source })
}

/// Reads a table whose schema, run and content hash are those expected.
fn read_batch(path: &Path, table: Table, facts: &RunFacts) -> Result<RecordBatch, StoreError> {
    let batch = arrow_file::read(path, Limits::default(), REMEDY)?;
    let schema = batch.schema();
    schema::table(table)?.check(path, &schema, REMEDY)?;
    facts::expect(path, &schema, facts)?;
    ContentHash::of(&batch)?.expect(&fact(&schema, KEY_CONTENT), path, "Arrow IPC", REMEDY)?;
    Ok(batch)
}
