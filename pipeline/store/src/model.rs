//! The model's three tables: `model/tree.arrow`, `weights.arrow` and `metrics.arrow`.
//!
//! Uncompressed Arrow IPC files, so that any Arrow reader opens them without this program.
//! Scene hash and seed are in their schema metadata. What is read back is checked as a whole:
//! lengths, ids, finite numbers, a tree that ends, a net for every leaf.

mod fit;
mod lists;
mod metrics;
mod steps;
mod tree;
mod weights;

pub use fit::{Fit, fit_task, read_fit, write_fit};
pub use metrics::{CellMetrics, Seams, Spread, SquareError};
pub use steps::{FitStep, read_steps, write_steps};
pub use tree::{Domain, ModelTree};

use crate::arrow_file;
use crate::atomic::create_folder;
use crate::columns::Source;
use crate::content::ContentHash;
use crate::error::StoreError;
use crate::guard::Limits;
use crate::layout::model_folder;
use crate::manifest::RunFacts;
use crate::parts::{KEY_CONTENT, KEY_SCENE, KEY_SEED};
use crate::schema::{self, Table};
use arrow::array::RecordBatch;
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
    write(&path, Table::Tree, tree.to_batch(&path)?, facts)
}

/// Reads the tree.
///
/// # Errors
/// [`StoreError::Io`], [`StoreError::Corrupt`], [`StoreError::Schema`],
/// [`StoreError::Version`], [`StoreError::Foreign`], [`StoreError::Model`].
pub fn read_tree(run: &Path, facts: &RunFacts) -> Result<ModelTree, StoreError> {
    let path = path(run, Table::Tree);
    ModelTree::from_batch(
        &read(&path, Table::Tree, facts)?,
        source(&path, Table::Tree),
    )
}

/// Writes the nets, sorted by cell id.
///
/// # Errors
/// [`StoreError::Model`] for what could not be read back, [`StoreError::Io`].
pub fn write_weights(run: &Path, cells: &[CellModel], facts: &RunFacts) -> Result<(), StoreError> {
    let path = path(run, Table::Weights);
    write(
        &path,
        Table::Weights,
        weights::to_batch(cells, &path)?,
        facts,
    )
}

/// Reads the nets, by ascending cell id.
///
/// # Errors
/// As [`read_tree`].
pub fn read_weights(run: &Path, facts: &RunFacts) -> Result<Vec<CellModel>, StoreError> {
    let path = path(run, Table::Weights);
    let batch = read(&path, Table::Weights, facts)?;
    weights::from_batch(&batch, source(&path, Table::Weights))
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
    let path = path(run, Table::Metrics);
    write(&path, Table::Metrics, metrics::to_batch(cells)?, facts)
}

/// Reads how the fits went, by ascending cell id.
///
/// # Errors
/// As [`read_tree`].
pub fn read_metrics(run: &Path, facts: &RunFacts) -> Result<Vec<CellMetrics>, StoreError> {
    let path = path(run, Table::Metrics);
    let batch = read(&path, Table::Metrics, facts)?;
    metrics::from_batch(&batch, source(&path, Table::Metrics))
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
    model_folder(run).join(format!("{}.arrow", table.name()))
}

fn source(path: &Path, table: Table) -> Source<'_> {
    Source {
        path,
        table: table.name(),
        remedy: REMEDY,
    }
}

fn write(
    path: &Path,
    table: Table,
    mut batch: RecordBatch,
    facts: &RunFacts,
) -> Result<(), StoreError> {
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    let content = ContentHash::of(&batch)?;
    let metadata = batch.schema_metadata_mut();
    metadata.insert(KEY_SCENE.to_string(), facts.scene_hash.clone());
    metadata.insert(KEY_SEED.to_string(), facts.seed.to_string());
    metadata.insert(KEY_CONTENT.to_string(), content);
    arrow_file::write(path, table.name(), &batch)
}

fn read(path: &Path, table: Table, facts: &RunFacts) -> Result<RecordBatch, StoreError> {
    let batch = arrow_file::read(path, Limits::default(), REMEDY)?;
    let schema = batch.schema();
    schema::table(table)?.check(path, &schema, REMEDY)?;
    let fact = |key: &str| schema.metadata().get(key).cloned().unwrap_or_default();
    let found = RunFacts {
        scene_hash: fact(KEY_SCENE),
        // Any seed but the one expected is refused; so is one that is no number.
        seed: fact(KEY_SEED).parse().unwrap_or(!facts.seed),
    };
    found.expect(path, facts)?;
    let (expected, found) = (fact(KEY_CONTENT), ContentHash::of(&batch)?);
    if expected == found {
        return Ok(batch);
    }
    Err(StoreError::Corrupt {
        path: path.into(),
        format: "Arrow IPC",
        reason: format!("its values hash to {found}, written was {expected}"),
        remedy: REMEDY,
    })
}
