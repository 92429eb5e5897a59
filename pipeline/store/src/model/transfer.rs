//! The tables of a transfer: `model/transfer.arrow`, `transfer_tree.arrow`, `transfer_cells.arrow`
//! and `transfer_parts.arrow`, row by row.
//!
//! What the rows mean is told in `schemas/`; whether they form a model is for those to check who
//! know the scene.

use super::{of_run, path, read_own, write};
use crate::error::StoreError;
use crate::manifest::RunFacts;
use crate::schema::Table;
use crate::table::TableRow;
use crate::table_row;
use std::path::{Path, PathBuf};

table_row! {
    /// A transfer as a whole, as in `schemas/transfer.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct TransferRow of Transfer {
        /// Points at which a side of a patch is asked.
        pub receiver_points: u32,
        /// Seed that those points follow from.
        pub numbers_seed: u64,
        /// Error above which a cell is not trusted.
        pub trust: f32,
        /// Lights of the ensemble.
        pub lights: u32,
        /// Test rows.
        pub test_rows: u32,
        /// Relative error on them.
        pub relative_error: f64,
        /// Its standard error.
        pub relative_error_se: f64,
        /// Median of their relative errors.
        pub median_error: f64,
        /// 95th percentile of them.
        pub percentile_95: f64,
        /// Share of the squared error in the worst 1 % of them.
        pub worst_share: f64,
        /// Share of them whose answers are trusted.
        pub trusted_share: f64,
        /// Relative error of those.
        pub trusted_error: f64,
        /// Patches asked for.
        pub patch_count: u32,
        /// Directions along each axis of a glossy patch.
        pub patch_directions: u32,
        /// Roughness up to which a patch is glossy.
        pub patch_gloss: f32,
        /// Edge of the cubes in which patches are finer \[m\].
        pub size_edge: f32,
        /// Those cubes, three numbers each.
        pub size_cubes: Vec<i32>,
        /// Quarterings in each of them.
        pub size_levels: Vec<u32>,
        /// Lengths of runs of columns, in turn not asked and asked.
        pub columns_in_use: Vec<u32>,
        /// Hash of the numbers of patches and column tree.
        pub structure: String,
        /// Random combinations of rows.
        pub sketch_rank: u32,
        /// Nodes that they read.
        pub sketch_nodes: Vec<u32>,
        /// Scale of each node's weights \[1/W\].
        pub sketch_scales: Vec<f32>,
        /// Weights of the nodes in them.
        pub sketch_weights: Vec<i8>,
    }
}

table_row! {
    /// A node of the trees over surfaces, as in `schemas/transfer_tree.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct TransferNodeRow of TransferTree {
        /// The row's own number.
        pub node_id: u32,
        /// Object whose tree begins here.
        pub object: Option<u32>,
        /// Material whose tree begins here.
        pub material: Option<u32>,
        /// Side whose tree begins here.
        pub back: Option<bool>,
        /// Coordinate that is compared; -1 at leaves.
        pub axis: i8,
        /// Where it is parted.
        pub threshold: Option<f32>,
        /// Node below.
        pub below: Option<u32>,
        /// Node above.
        pub above: Option<u32>,
        /// Cell of a leaf.
        pub cell_id: Option<u32>,
    }
}

table_row! {
    /// A cell and its read of a light, as in `schemas/transfer_cells.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct TransferCellRow of TransferCells {
        /// The row's own number.
        pub cell_id: u32,
        /// Relative error, where it is known.
        pub error: Option<f32>,
        /// Rows that it was fitted to.
        pub rows: u32,
        /// Rows that the error is taken over.
        pub judged: u32,
        /// Coefficients of a light.
        pub rank: u32,
        /// Nodes that it reads.
        pub nodes: Vec<u32>,
        /// Scale of each node's weights \[1/W\].
        pub weight_scales: Vec<f32>,
        /// Their weights in the coefficients.
        pub weights: Vec<i8>,
        /// Scale of each combination.
        pub sketch_scales: Vec<f32>,
        /// Its rows in the random combinations.
        pub sketch: Vec<i8>,
    }
}

table_row! {
    /// A part of a cell, as in `schemas/transfer_parts.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct TransferPartRow of TransferParts {
        /// The cell.
        pub cell_id: u32,
        /// `base` or `constant`.
        pub part: String,
        /// `net` or `nodes`.
        pub kind: String,
        /// Names of the inputs.
        pub inputs: Vec<String>,
        /// Their means.
        pub input_mean: Vec<f32>,
        /// 1 / their deviations.
        pub input_scale: Vec<f32>,
        /// Least scaled inputs.
        pub input_low: Vec<f32>,
        /// Largest scaled inputs.
        pub input_high: Vec<f32>,
        /// Weights of the hidden units.
        pub hidden: Vec<f32>,
        /// Scale of each row of output weights.
        pub output_scales: Vec<f32>,
        /// Output weights.
        pub output: Vec<i16>,
        /// Metres that turns are worth.
        pub turns: Vec<f32>,
        /// Places of nodes.
        pub places: Vec<f32>,
        /// Normals of nodes.
        pub normals: Vec<f32>,
        /// Scale of each value and slope.
        pub value_scales: Vec<f32>,
        /// Values and slopes of nodes.
        pub values: Vec<i8>,
    }
}

table_row! {
    /// How far a transfer is that is not finished, as in `schemas/transfer_progress.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct TransferProgressRow of TransferProgress {
        /// Batches of surfaces that are done.
        pub batches: u32,
        /// Rows that they traced.
        pub rows: u64,
        /// Their nodes, first of the table's.
        pub nodes: u32,
        /// Their cells, first of the table's.
        pub cells: u32,
        /// Their rows in the random combinations, every column.
        pub sketch: Vec<f32>,
    }
}

/// The tables of a transfer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferTables {
    /// Its only row.
    pub whole: TransferRow,
    /// Nodes of the trees over surfaces.
    pub nodes: Vec<TransferNodeRow>,
    /// Cells.
    pub cells: Vec<TransferCellRow>,
    /// Their parts.
    pub parts: Vec<TransferPartRow>,
}

/// The tables in the order in which they are written.
pub const TRANSFER_TABLES: [Table; 4] = [
    Table::TransferParts,
    Table::TransferCells,
    Table::TransferTree,
    Table::Transfer,
];

/// The path of a table in `model/`.
pub fn model_table_path(run: &Path, table: Table) -> PathBuf {
    path(run, table)
}

/// Writes the tables of a transfer, `transfer.arrow` last: a run that has it has all of them.
///
/// # Errors
/// [`StoreError::Io`].
pub fn write_transfer(
    run: &Path,
    tables: &TransferTables,
    facts: &RunFacts,
) -> Result<(), StoreError> {
    write_own(run, &tables.parts, facts)?;
    write_own(run, &tables.cells, facts)?;
    write_own(run, &tables.nodes, facts)?;
    write_own(run, std::slice::from_ref(&tables.whole), facts)
}

/// Writes how far a transfer is, after the tables of its cells: these only grow, so that a row that tells of
/// fewer is still right.
///
/// # Errors
/// [`StoreError::Io`].
pub fn write_transfer_progress(
    run: &Path,
    tables: &TransferTables,
    progress: &TransferProgressRow,
    facts: &RunFacts,
) -> Result<(), StoreError> {
    write_own(run, &tables.parts, facts)?;
    write_own(run, &tables.cells, facts)?;
    write_own(run, &tables.nodes, facts)?;
    write_own(run, std::slice::from_ref(progress), facts)
}

/// Reads how far a transfer is, and the tables of its cells; none where there is no such table.
///
/// # Errors
/// Those of [`super::read_tree`].
pub fn read_transfer_progress(
    run: &Path,
    facts: &RunFacts,
) -> Result<Option<(TransferTables, TransferProgressRow)>, StoreError> {
    if !path(run, Table::TransferProgress).exists() {
        return Ok(None);
    }
    let mut progress: Vec<TransferProgressRow> = read_own(run, Table::TransferProgress, facts)?;
    let rows = progress.len();
    let (Some(progress), 1) = (progress.pop(), rows) else {
        let reason = format!("it has {rows} rows where a transfer has one");
        let table = Table::TransferProgress;
        return Err(transfer_fault(run, table, "table".into(), reason));
    };
    let tables = TransferTables {
        whole: TransferRow::default(),
        nodes: read_own(run, Table::TransferTree, facts)?,
        cells: read_own(run, Table::TransferCells, facts)?,
        parts: read_own(run, Table::TransferParts, facts)?,
    };
    Ok(Some((tables, progress)))
}

/// Reads the tables of a transfer; [`StoreError::Model`] where `transfer.arrow` has not one row.
///
/// # Errors
/// Those of [`super::read_tree`].
pub fn read_transfer(run: &Path, facts: &RunFacts) -> Result<TransferTables, StoreError> {
    let mut whole: Vec<TransferRow> = read_own(run, Table::Transfer, facts)?;
    let rows = whole.len();
    let (Some(whole), 1) = (whole.pop(), rows) else {
        let reason = format!("it has {rows} rows where a transfer has one");
        return Err(transfer_fault(run, Table::Transfer, "table".into(), reason));
    };
    Ok(TransferTables {
        whole,
        nodes: read_own(run, Table::TransferTree, facts)?,
        cells: read_own(run, Table::TransferCells, facts)?,
        parts: read_own(run, Table::TransferParts, facts)?,
    })
}

/// The error of a table that is well-formed but makes no model: where in it, and what is wrong.
pub fn transfer_fault(run: &Path, table: Table, place: String, reason: String) -> StoreError {
    let path = path(run, table);
    super::source(&path, table).model(place, reason)
}

fn write_own<R: TableRow>(run: &Path, rows: &[R], facts: &RunFacts) -> Result<(), StoreError> {
    let rows: Vec<&R> = rows.iter().collect();
    write(&path(run, R::TABLE), &rows, facts, &of_run::stamp(run)?)
}
