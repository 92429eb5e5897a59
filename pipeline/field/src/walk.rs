//! Rows, and lights, taken down the kd-tree together: what remains at a leaf is a cell's.

use crate::columns::{self, Columns};
use crate::error::FieldError;
use crate::tree::{LEAF, Tree};
use std::ops::Range;

/// A node's split; a leaf holds its cell in `left`.
#[derive(Clone, Copy, Debug)]
struct Node {
    axis: i8,
    threshold: f32,
    left: u32,
}

/// A valid tree, laid out for descent.
#[derive(Clone, Debug)]
pub struct Walk {
    nodes: Vec<Node>,
}

/// The rows and lights of one cell.
pub struct Group<'a> {
    /// The cell.
    pub cell: u32,
    /// Its rows, ascending.
    pub rows: &'a [u32],
    /// Its lights, ascending; empty where rows bring their own.
    pub lights: &'a [u32],
}

/// A node still to be visited with what reaches it.
struct Visit {
    node: u32,
    rows: Range<usize>,
    lights: Range<usize>,
}

impl Walk {
    /// Checks the tree and lays it out.
    pub fn new(tree: &Tree) -> Result<Walk, FieldError> {
        tree.check().map_err(|reason| FieldError::Tree { reason })?;
        let node = |id: usize| Node {
            axis: tree.axis[id],
            threshold: tree.threshold[id],
            left: if tree.axis[id] == LEAF {
                tree.cell[id]
            } else {
                tree.left[id]
            },
        };
        Ok(Walk {
            nodes: (0..tree.axis.len()).map(node).collect(),
        })
    }

    /// Calls `work` once for each cell that any row reaches, as [`Tree::find`] would send them
    /// one by one. With `lights`, positions of all the lights, a split of a light column
    /// parts the lights instead of the rows, and a row belongs to as many cells as its lights do.
    pub fn groups(&self, rows: &Columns, lights: Option<&[[f32; 3]]>, mut work: impl FnMut(Group)) {
        let mut row_ids: Vec<u32> = (0..rows.len() as u32).collect();
        let mut light_ids: Vec<u32> = (0..lights.map_or(0, <[_]>::len) as u32).collect();
        let mut spare = vec![0; row_ids.len().max(light_ids.len())];
        let mut stack = vec![Visit {
            node: 0,
            rows: 0..row_ids.len(),
            lights: 0..light_ids.len(),
        }];
        while let Some(Visit {
            node,
            rows: r,
            lights: l,
        }) = stack.pop()
        {
            if r.is_empty() || (lights.is_some() && l.is_empty()) {
                continue;
            }
            let Node {
                axis,
                threshold,
                left,
            } = self.nodes[node as usize];
            if axis == LEAF {
                work(Group {
                    cell: left,
                    rows: &row_ids[r],
                    lights: &light_ids[l],
                });
                continue;
            }
            let axis = axis as usize;
            let visit = |node, rows, lights| Visit { node, rows, lights };
            stack.extend(match lights {
                Some(lights) if (columns::L..columns::L + 3).contains(&axis) => {
                    let above = |id: u32| lights[id as usize][axis - columns::L] >= threshold;
                    let middle = l.start + part(&mut light_ids[l.clone()], &mut spare, above);
                    [
                        visit(left, r.clone(), l.start..middle),
                        visit(left + 1, r, middle..l.end),
                    ]
                }
                _ => {
                    let column = &rows.columns[axis];
                    let below = part_rows(&mut row_ids[r.clone()], &mut spare, column, threshold);
                    let middle = r.start + below;
                    [
                        visit(left, r.start..middle, l.clone()),
                        visit(left + 1, middle..r.end, l),
                    ]
                }
            });
        }
    }
}

/// Parts the rows `ids` by a column. A run of neighbouring rows on one side, the common case
/// in a picture, is found without touching the ids.
fn part_rows(ids: &mut [u32], spare: &mut [u32], column: &[f32], threshold: f32) -> usize {
    let (first, last) = (ids[0] as usize, ids[ids.len() - 1] as usize);
    if last - first + 1 == ids.len() {
        let above = column[first..=last]
            .iter()
            .map(|&x| usize::from(x >= threshold));
        let above: usize = above.sum();
        if above == 0 || above == ids.len() {
            return ids.len() - above;
        }
    }
    part(ids, spare, |id| column[id as usize] >= threshold)
}

/// Moves the ids that are `above` behind the others, both in their old order; how many are not.
fn part(ids: &mut [u32], spare: &mut [u32], above: impl Fn(u32) -> bool) -> usize {
    let (mut below, mut moved) = (0, 0);
    for at in 0..ids.len() {
        // Written to both sides, kept on one: no branch to mispredict.
        let id = ids[at];
        let goes = usize::from(above(id));
        ids[below] = id;
        spare[moved] = id;
        below += 1 - goes;
        moved += goes;
    }
    ids[below..].copy_from_slice(&spare[..moved]);
    below
}
