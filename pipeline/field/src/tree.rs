//! The kd-tree over raw columns: which cell a row belongs to.

use crate::columns::{self, Columns};
use std::ops::Range;

/// Marks a leaf in [`Tree::axis`].
pub const LEAF: i8 = -1;

/// A binary tree in flat columns, root at 0. A row goes left where
/// `row[axis] < threshold`, otherwise right.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
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

/// A box in the space of raw columns, in each column's unit: a cell's of the tree, or what some rows
/// span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Lower bound an axis, inclusive.
    pub minimum: [f32; columns::COUNT],
    /// Upper bound an axis; exclusive of a cell, inclusive where rows span it.
    pub maximum: [f32; columns::COUNT],
}

impl Domain {
    /// Everything.
    pub const ALL: Domain = Domain {
        minimum: [f32::NEG_INFINITY; columns::COUNT],
        maximum: [f32::INFINITY; columns::COUNT],
    };
    /// Nothing.
    pub const EMPTY: Domain = Domain {
        minimum: [f32::INFINITY; columns::COUNT],
        maximum: [f32::NEG_INFINITY; columns::COUNT],
    };

    /// Whether a whole row lies in the box.
    pub fn contains(&self, row: &[f32; columns::COUNT]) -> bool {
        self.contains_in(0..columns::COUNT, row)
    }

    /// Whether some of a row's columns lie in the box.
    pub fn contains_in(&self, some: Range<usize>, row: &[f32; columns::COUNT]) -> bool {
        let mut some = some;
        some.all(|i| self.minimum[i] <= row[i] && row[i] < self.maximum[i])
    }

    /// Widens the box to hold a row.
    pub fn include(&mut self, row: &[f32; columns::COUNT]) {
        for (i, &x) in row.iter().enumerate() {
            self.minimum[i] = self.minimum[i].min(x);
            self.maximum[i] = self.maximum[i].max(x);
        }
    }

    /// Whether a query is like the rows that span the box: it lies within, give or take a hundredth of
    /// the extent, as the outermost training rows stand a little inside the cell's border. The
    /// normal is not looked at: it only turns within a cell, so its box says nothing.
    pub fn holds(&self, row: &[f32; columns::COUNT]) -> bool {
        (0..columns::COUNT)
            .filter(|c| !(columns::N..columns::V).contains(c))
            .all(|c| {
                let (low, high) = (self.minimum[c], self.maximum[c]);
                let margin = 0.01 * (high - low) + 1e-5 * high.abs().max(1e-3);
                low - margin <= row[c] && row[c] <= high + margin
            })
    }

    /// Whether a row lies within what rows span, widened by a twentieth of it and rounding.
    pub fn nearly_holds(&self, row: &[f32; columns::COUNT]) -> bool {
        (0..columns::COUNT).all(|c| {
            let [low, high, x] = [self.minimum[c], self.maximum[c], row[c]].map(f64::from);
            let slack = 0.05 * (high - low) + 1e-4 * (high + low).abs();
            low - slack <= x && x <= high + slack
        })
    }
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

    /// Whether the columns make one tree: equal lengths, axes that exist, children after their
    /// parent and each reached once, finite thresholds, cells numbered 0 to n - 1 and leaves alone.
    pub fn check(&self) -> Result<(), String> {
        let n = self.axis.len();
        if n == 0 || [self.threshold.len(), self.left.len(), self.cell.len()] != [n; 3] {
            return Err("columns of no or of different length".into());
        }
        let mut reached = vec![false; n];
        reached[0] = true;
        let mut cells = Vec::new();
        for node in 0..n {
            let (axis, left) = (self.axis[node], self.left[node] as usize);
            if !reached[node] {
                return Err(format!("node {node} is no earlier node's child"));
            }
            if axis == LEAF {
                cells.push(self.cell[node]);
                continue;
            }
            if axis < 0 || axis as usize >= columns::COUNT || !self.threshold[node].is_finite() {
                return Err(format!(
                    "node {node}: axis {axis}, threshold {}",
                    self.threshold[node]
                ));
            }
            if self.cell[node] != u32::MAX {
                return Err(format!(
                    "node {node} is split, but cell {}",
                    self.cell[node]
                ));
            }
            if left <= node || left + 1 >= n || reached[left] || reached[left + 1] {
                return Err(format!("node {node}: left child {left} of {n} nodes"));
            }
            (reached[left], reached[left + 1]) = (true, true);
        }
        cells.sort_unstable();
        match (0u32..)
            .zip(&cells)
            .find(|(expected, cell)| expected != *cell)
        {
            Some((expected, _)) => Err(format!("no leaf is cell {expected}")),
            None => Ok(()),
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

    /// The box of every node in raw columns, root first; see [`Tree::domains`].
    pub fn node_domains(&self) -> Vec<Domain> {
        let mut domains = vec![Domain::ALL; self.axis.len()];
        for node in 0..self.axis.len() {
            if self.axis[node] == LEAF {
                continue;
            }
            let (axis, at) = (self.axis[node] as usize, self.threshold[node]);
            let left = self.left[node] as usize;
            domains[left] = domains[node];
            domains[left].maximum[axis] = domains[node].maximum[axis].min(at);
            domains[left + 1] = domains[node];
            domains[left + 1].minimum[axis] = domains[node].minimum[axis].max(at);
        }
        domains
    }

    /// The box of each cell in raw columns, `[minimum, maximum)` an axis, infinite where
    /// no split bounds it. Indexed by cell id; an id that no leaf has keeps an empty box.
    pub fn domains(&self) -> Vec<Domain> {
        let ids = self.cell.iter().filter(|&&c| c != u32::MAX);
        let count = ids.max().map_or(0, |&c| c as usize + 1);
        let mut domains = vec![Domain::EMPTY; count];
        for (node, domain) in self.node_domains().into_iter().enumerate() {
            if self.axis[node] == LEAF {
                domains[self.cell[node] as usize] = domain;
            }
        }
        domains
    }

    /// The node id of each cell's leaf, indexed by cell id.
    pub fn leaves(&self) -> Vec<usize> {
        let mut leaves = vec![0; self.domains().len()];
        for (node, &cell) in self.cell.iter().enumerate() {
            if cell != u32::MAX {
                leaves[cell as usize] = node;
            }
        }
        leaves
    }

    /// The cut that made each cell: column and position; none where the root is the cell.
    pub fn last_cuts(&self) -> Vec<Option<(usize, f32)>> {
        let mut cuts = vec![None; self.cells()];
        for node in 0..self.axis.len() {
            let Ok(axis) = usize::try_from(self.axis[node]) else {
                continue;
            };
            for child in [0, 1].map(|side| self.left[node] as usize + side) {
                let cell = self.cell.get(child).map(|&cell| cell as usize);
                if let Some(cut) = cell.and_then(|cell| cuts.get_mut(cell)) {
                    *cut = Some((axis, self.threshold[node]));
                }
            }
        }
        cuts
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

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    #[test]
    fn each_cell_knows_the_cut_that_made_it() {
        let mut tree = Tree::single();
        assert_eq!(tree.last_cuts(), [None]);
        let [left, _] = tree.split(0, 3, 0.5, 1);
        assert_eq!(tree.last_cuts(), [Some((3, 0.5)); 2]);
        tree.split(left, 9, 0.25, 2);
        assert_eq!(
            tree.last_cuts(),
            [Some((9, 0.25)), Some((3, 0.5)), Some((9, 0.25))]
        );
    }

    /// A random tree: every row lies in the box of the cell that the walk finds, and in no other.
    #[test]
    fn a_row_lies_in_its_cells_box_only() {
        let mut random = Stream::new(7, Stage::Test, 0).dimensions(0);
        let mut tree = Tree::single();
        for cell in 1..40 {
            let leaves = tree.leaves();
            let leaf = leaves[random.next_u32() as usize % leaves.len()];
            let axis = random.next_u32() as usize % columns::COUNT;
            tree.split(leaf, axis, random.next_f32(), cell);
        }
        let domains = tree.domains();
        assert_eq!((tree.cells(), domains.len()), (40, 40));
        for _ in 0..2000 {
            let row: [f32; columns::COUNT] = std::array::from_fn(|_| random.next_f32());
            let inside: Vec<usize> = (0..40).filter(|&c| domains[c].contains(&row)).collect();
            assert_eq!(inside, [tree.find(&row) as usize]);
        }
    }
}
