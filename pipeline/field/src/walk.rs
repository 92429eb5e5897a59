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
    /// Checks the tree and lays it out.
    pub fn new(tree: &Tree) -> Result<Walk, FieldError> {
        tree.check().map_err(|reason| FieldError::Tree { reason })?;
        let mut depth = vec![0u32; tree.axis.len()];
        let mut nodes = Vec::with_capacity(tree.axis.len());
        for id in 0..tree.axis.len() {
            let (axis, left) = (tree.axis[id], tree.left[id]);
            nodes.push(if axis == LEAF {
                Node {
                    axis: 0,
                    threshold: f32::NAN,
                    left: id as u32,
                }
            } else {
                // Children come after their parent, in pairs.
                let below = depth[id] + 1;
                depth[left as usize..left as usize + 2].fill(below);
                Node {
                    axis: axis as u32,
                    threshold: tree.threshold[id],
                    left,
                }
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
