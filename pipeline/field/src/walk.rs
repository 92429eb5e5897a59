//! The kd-tree checked and laid out for descent.

use crate::columns::{self, Columns};
use crate::error::FieldError;
use crate::tree::{LEAF, Tree};

/// A node in 12 bytes. A leaf is its own left child behind a threshold of NaN,
/// which no value reaches, so that descent needs no test for leaves.
#[derive(Clone, Copy, Debug)]
struct Node {
    axis: u32,
    threshold: f32,
    left: u32,
}

/// A valid tree: nodes, cells, depth.
#[derive(Clone, Debug)]
pub struct Walk {
    nodes: Vec<Node>,
    cell: Vec<u32>,
    depth: u32,
}

impl Walk {
    /// Checks that the tree's columns form one binary tree whose leaves are the cells
    /// 0..count, each once.
    pub fn new(tree: &Tree) -> Result<Walk, FieldError> {
        let count = tree.axis.len();
        let lengths = [tree.threshold.len(), tree.left.len(), tree.cell.len()];
        if count == 0 || lengths.iter().any(|&n| n != count) {
            return Err(bad(0, "columns are empty or differ in length"));
        }
        let cells = tree.cells();
        let mut seen = vec![false; cells];
        let mut depth = vec![u32::MAX; count];
        depth[0] = 0;
        let mut nodes = Vec::with_capacity(count);
        for id in 0..count {
            if depth[id] == u32::MAX {
                return Err(bad(id, "no node before it is its parent"));
            }
            nodes.push(if tree.axis[id] == LEAF {
                let cell = tree.cell[id] as usize;
                match seen.get_mut(cell) {
                    Some(seen) if !*seen => *seen = true,
                    _ => return Err(bad(id, "its cell id is repeated or out of range")),
                }
                Node {
                    axis: 0,
                    threshold: f32::NAN,
                    left: id as u32,
                }
            } else {
                split_node(tree, id, &mut depth)?
            });
        }
        Ok(Walk {
            nodes,
            cell: tree.cell.clone(),
            depth: depth.into_iter().max().unwrap_or(0),
        })
    }

    /// The cell of every row, as [`Tree::find`] gives it.
    pub fn cells(&self, rows: &Columns, out: &mut Vec<u32>) {
        let columns: [&[f32]; columns::COUNT] = std::array::from_fn(|c| rows.columns[c].as_slice());
        out.clear();
        out.extend((0..rows.len()).map(|row| {
            let mut node = 0u32;
            for _ in 0..self.depth {
                let n = self.nodes[node as usize];
                let right = columns[n.axis as usize][row] >= n.threshold;
                node = n.left + u32::from(right);
            }
            self.cell[node as usize]
        }));
    }

    /// Whether node `id` is a leaf, and of which cell.
    pub fn leaf(&self, id: u32) -> Option<u32> {
        let cell = self.cell[id as usize];
        self.nodes[id as usize].threshold.is_nan().then_some(cell)
    }

    /// Axis, threshold and left child of an inner node.
    pub fn split(&self, id: u32) -> (usize, f32, u32) {
        let n = self.nodes[id as usize];
        (n.axis as usize, n.threshold, n.left)
    }
}

/// An inner node; its children must come after it and have no other parent.
fn split_node(tree: &Tree, id: usize, depth: &mut [u32]) -> Result<Node, FieldError> {
    let axis = usize::try_from(tree.axis[id]).unwrap_or(usize::MAX);
    if axis >= columns::COUNT {
        return Err(bad(id, "it splits a column that does not exist"));
    }
    if tree.threshold[id].is_nan() {
        return Err(bad(id, "its threshold is not a number"));
    }
    let left = tree.left[id] as usize;
    if left <= id || left + 1 >= depth.len() {
        return Err(bad(id, "its children are out of range"));
    }
    for child in [left, left + 1] {
        if depth[child] != u32::MAX {
            return Err(bad(child, "it has two parents"));
        }
        depth[child] = depth[id] + 1;
    }
    Ok(Node {
        axis: axis as u32,
        threshold: tree.threshold[id],
        left: left as u32,
    })
}

fn bad(node: usize, reason: &'static str) -> FieldError {
    FieldError::Tree { node, reason }
}
