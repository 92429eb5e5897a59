//! The part of a bake that is done.

use crate::model::{SKETCHES, SurfaceCells, TransferCell};

/// The part of a bake that is done: surfaces are baked a batch at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferProgress {
    /// Batches that are done.
    pub batches: u32,
    /// Rows that they traced.
    pub rows: u64,
    /// Trees of their surfaces.
    pub tree: SurfaceCells,
    /// Their cells.
    pub cells: Vec<TransferCell>,
    /// Their rows in the random combinations, shape [sketches, columns].
    pub sketch: Vec<f32>,
}

impl TransferProgress {
    /// Nothing is done yet.
    pub(crate) fn new(columns: usize) -> TransferProgress {
        TransferProgress {
            sketch: vec![0.0; SKETCHES * columns],
            ..TransferProgress::default()
        }
    }

    /// Whether it may be of a bake over so many columns.
    pub(crate) fn fits(&self, columns: usize) -> bool {
        self.sketch.len() == SKETCHES * columns
    }

    /// Appends the cells of a surface whose key is larger than all so far.
    pub(crate) fn append(&mut self, tree: &SurfaceCells, cells: Vec<TransferCell>) {
        self.tree.append(tree, self.cells.len() as u32);
        self.cells.extend(cells);
    }
}
