//! The kd-tree over raw columns: which cell a row belongs to.

use crate::columns::{self, Columns};

/// Marks a leaf in [`Tree::axis`].
pub const LEAF: i8 = -1;

/// A binary tree in flat columns, root at 0. A row goes left where
/// `row[axis] < threshold`, otherwise right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Raw column that the node splits, or [`LEAF`].
    pub axis: Vec<i8>,
    /// Split position in that column's unit; 0 at a leaf.
    pub threshold: Vec<f32>,
    /// Left child's node id; its right sibling is the next id. 0 at a leaf.
    pub left: Vec<u32>,
    /// Cell id at a leaf, `u32::MAX` at inner nodes.
    pub cell: Vec<u32>,
}

impl Tree {
    /// A tree of one leaf, cell 0.
    pub fn single() -> Tree {
        Tree {
            axis: vec![LEAF],
            threshold: vec![0.0],
            left: vec![0],
            cell: vec![0],
        }
    }

    /// How many cells (leaves).
    pub fn cells(&self) -> usize {
        self.axis.iter().filter(|&&a| a == LEAF).count()
    }

    /// The cell of one row.
    pub fn find(&self, row: &[f32; columns::COUNT]) -> u32 {
        let mut node = 0usize;
        while self.axis[node] != LEAF {
            let right = row[self.axis[node] as usize] >= self.threshold[node];
            node = self.left[node] as usize + usize::from(right);
        }
        self.cell[node]
    }

    /// The cell of every row.
    pub fn find_all(&self, rows: &Columns) -> Vec<u32> {
        (0..rows.len()).map(|r| self.find(&rows.row(r))).collect()
    }

    /// Turns the leaf `node` into a split and returns its children's node ids.
    /// The left child keeps the leaf's cell id, the right one gets `new_cell`.
    pub fn split(&mut self, node: usize, axis: usize, threshold: f32, new_cell: u32) -> [usize; 2] {
        let left = self.axis.len();
        let cell = self.cell[node];
        self.axis.extend([LEAF, LEAF]);
        self.threshold.extend([0.0, 0.0]);
        self.left.extend([0, 0]);
        self.cell.extend([cell, new_cell]);
        self.axis[node] = axis as i8;
        self.threshold[node] = threshold;
        self.left[node] = left as u32;
        self.cell[node] = u32::MAX;
        [left, left + 1]
    }
}
