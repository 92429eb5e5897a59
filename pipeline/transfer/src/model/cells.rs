//! Which cell a surface point belongs to.

use crate::query::{SurfaceKey, TransferQuery};

/// Coordinate that a branch compares: position x y z, geometric normal x y z, or nothing: it is a leaf.
pub const LEAF_AXIS: u8 = u8::MAX;

/// A node of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellNode {
    /// 0 to 2 position, 3 to 5 geometric normal, or [`LEAF_AXIS`].
    pub axis: u8,
    /// Points with a smaller coordinate go below, the rest above.
    pub at: f32,
    /// Node below; a leaf's cell.
    pub below: u32,
    /// Node above.
    pub above: u32,
}

/// A tree for each surface, cut by position and normal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceCells {
    /// First node of each surface; keys grow.
    pub roots: Vec<(SurfaceKey, u32)>,
    /// The nodes of all trees.
    pub nodes: Vec<CellNode>,
}

/// Coordinates that cells are cut by.
pub(crate) const AXES: usize = 6;

/// A coordinate that cells are cut by.
#[inline]
pub(crate) fn coordinate(query: &TransferQuery, axis: u8) -> f32 {
    if axis < 3 {
        query.position[axis as usize]
    } else {
        query.geometric[axis as usize - 3]
    }
}

impl SurfaceCells {
    /// The cell of a point; none where no row was of its surface.
    #[inline]
    pub fn find(&self, query: &TransferQuery) -> Option<u32> {
        let key = query.surface;
        let at = self.roots.binary_search_by(|root| root.0.cmp(&key)).ok()?;
        let mut node = self.nodes.get(self.roots[at].1 as usize)?;
        // children stand after their parents, so that this ends
        while node.axis < AXES as u8 {
            let below = coordinate(query, node.axis) < node.at;
            let next = if below { node.below } else { node.above };
            node = self.nodes.get(next as usize)?;
        }
        Some(node.below)
    }

    /// Appends the tree of a surface whose key is larger than all so far; its cells are numbered on
    /// from `first_cell`.
    pub(crate) fn append(&mut self, other: &SurfaceCells, first_cell: u32) {
        let first_node = self.nodes.len() as u32;
        let roots = other.roots.iter();
        self.roots
            .extend(roots.map(|&(key, root)| (key, root + first_node)));
        self.nodes
            .extend(other.nodes.iter().map(|node| match node.axis {
                LEAF_AXIS => CellNode {
                    below: node.below + first_cell,
                    ..*node
                },
                _ => CellNode {
                    below: node.below + first_node,
                    above: node.above + first_node,
                    ..*node
                },
            }));
    }
}
