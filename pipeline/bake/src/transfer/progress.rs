//! A transfer's finished cells, kept until all are baked.

use super::read::{cells, place, tree};
use super::tables::{cell_rows, node_rows, part_rows};
use crate::error::BakeError;
use crate::run::json::remove_file;
use rrf_store::StoreError;
use rrf_store::manifest::RunFacts;
use rrf_store::model::{
    TransferProgressRow, TransferRow, TransferTables, model_table_path, read_transfer_progress,
    transfer_fault, write_transfer_progress,
};
use rrf_store::schema::Table;
use rrf_transfer::TransferProgress;
use std::path::Path;

/// The folder of a run that is under way.
pub(super) struct Kept<'a> {
    pub(super) run: &'a Path,
    pub(super) facts: &'a RunFacts,
}

impl Kept<'_> {
    /// Writes the part that is done.
    pub(super) fn write(&self, progress: &TransferProgress) -> Result<(), BakeError> {
        // a run that has the table of the whole counts as finished
        remove_file(&model_table_path(self.run, Table::Transfer))?;
        let nodes = node_rows(&progress.tree);
        let row = TransferProgressRow {
            batches: progress.batches,
            rows: progress.rows,
            nodes: nodes.len() as u32,
            cells: progress.cells.len() as u32,
            sketch: progress.sketch.clone(),
        };
        let tables = TransferTables {
            whole: TransferRow::default(),
            nodes,
            cells: cell_rows(&progress.cells),
            parts: part_rows(&progress.cells),
        };
        Ok(write_transfer_progress(
            self.run, &tables, &row, self.facts,
        )?)
    }

    /// Reads what an earlier bake wrote, over a column tree of so many nodes; none where it is not there,
    /// or damaged.
    pub(super) fn read(&self, nodes: usize) -> Result<Option<TransferProgress>, BakeError> {
        let read = match read_transfer_progress(self.run, self.facts) {
            Err(error) if StoreError::is_damage(&error) => return Ok(None),
            read => read?,
        };
        let fault = |reason: String| {
            let table = Table::TransferProgress;
            transfer_fault(self.run, table, "table".into(), reason)
        };
        let Some((tables, row)) = read else {
            return Ok(None);
        };
        match progress(tables, row, nodes).map_err(fault) {
            Err(error) if StoreError::is_damage(&error) => Ok(None),
            progress => Ok(Some(progress?)),
        }
    }

    /// Removes it, once the model is written.
    pub(super) fn remove(&self) -> Result<(), BakeError> {
        let path = model_table_path(self.run, Table::TransferProgress);
        Ok(remove_file(&path)?)
    }
}

fn progress(
    mut tables: TransferTables,
    row: TransferProgressRow,
    nodes: usize,
) -> Result<TransferProgress, String> {
    tables.nodes.truncate(row.nodes as usize);
    tables.cells.truncate(row.cells as usize);
    if (tables.nodes.len(), tables.cells.len()) != (row.nodes as usize, row.cells as usize) {
        return Err("it counts more nodes or cells than there are".into());
    }
    let sketches = rrf_transfer::SKETCHES as u32;
    let mut cells = cells(tables.cells, nodes, sketches).map_err(|(_, reason)| reason)?;
    let parts = tables.parts.into_iter();
    for part in parts.filter(|part| part.cell_id < row.cells) {
        place(&mut cells, part)?;
    }
    let tree = tree(tables.nodes, cells.len()).map_err(|(_, reason)| reason)?;
    Ok(TransferProgress {
        batches: row.batches,
        rows: row.rows,
        tree,
        cells,
        sketch: row.sketch,
    })
}
