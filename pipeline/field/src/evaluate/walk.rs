//! Rows, and lights, taken down the kd-tree together: what remains at a leaf is a cell's.
//!
//! The rows at a node are bits, 64 rows a word: a split compares 64 neighbours of a column at
//! once, and rows that go the same way, as neighbouring pixels do, are never touched one by one.

use crate::columns::{self, Columns};
use crate::error::FieldError;
use crate::tree::{LEAF, Tree};
use multiversion::multiversion;
use std::ops::Range;

/// Rows of a word.
const WORD: usize = 64;

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
    depth: usize,
}

/// One cell's places in the lists of [`Groups`].
#[derive(Clone, Debug)]
struct Group {
    cell: u32,
    rows: Range<usize>,
    lights: Range<usize>,
}

/// The rows and lights of each cell that any row reaches; its memory is used again.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    list: Vec<Group>,
    rows: Vec<u32>,
    lights: Vec<u32>,
    light_ids: Vec<u32>,
    stack: Vec<Visit>,
    words: Vec<u64>,
}

impl Groups {
    /// Each cell, its rows, ascending, and its lights, in the order that the tree left them in
    /// (none where rows bring their own).
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u32], &[u32])> {
        self.list.iter().map(|group| {
            let (rows, lights) = (group.rows.clone(), group.lights.clone());
            (group.cell, &self.rows[rows], &self.lights[lights])
        })
    }
}

/// A node still to be visited with what reaches it.
#[derive(Clone, Debug)]
struct Visit {
    node: u32,
    /// First of its words in [`Groups::words`].
    words: usize,
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
        // children come after their parent
        let mut depths = vec![1; tree.axis.len()];
        for id in 0..tree.axis.len() {
            if tree.axis[id] != LEAF {
                let left = tree.left[id] as usize;
                depths[left] = depths[id] + 1;
                depths[left + 1] = depths[id] + 1;
            }
        }
        Ok(Walk {
            nodes: (0..tree.axis.len()).map(node).collect(),
            depth: depths.into_iter().max().unwrap_or(1),
        })
    }

    /// The cells that a light at `position` can be seen from, whatever the row.
    pub fn cells_under(&self, position: [f32; 3], cells: &mut Vec<u32>) {
        cells.clear();
        let mut stack = vec![0u32];
        while let Some(id) = stack.pop() {
            let node = self.nodes[id as usize];
            match light_axis(node.axis) {
                _ if node.axis == LEAF => cells.push(node.left),
                Some(axis) => stack.push(node.left + u32::from(position[axis] >= node.threshold)),
                None => stack.extend([node.left, node.left + 1]),
            }
        }
    }

    /// Finds the rows of each cell, as [`Tree::find`] would send them one by one. With `lights`,
    /// positions of all the lights, a split of a light column parts the lights instead of the
    /// rows, and a row belongs to as many cells as its lights do.
    pub fn groups(&self, rows: &Columns, lights: Option<&[[f32; 3]]>, groups: &mut Groups) {
        let count = rows.len();
        let span = count.div_ceil(WORD);
        groups.begin(count, lights.map_or(0, <[_]>::len), span, self.depth);
        while let Some(visit) = groups.stack.pop() {
            if lights.is_some() && visit.lights.is_empty() {
                continue;
            }
            let node = self.nodes[visit.node as usize];
            if node.axis == LEAF {
                groups.leaf(node.left, &visit, span);
                continue;
            }
            match (lights, light_axis(node.axis)) {
                (Some(lights), Some(axis)) => {
                    let above = |id: u32| lights[id as usize][axis] >= node.threshold;
                    groups.part_lights(&visit, node, span, above);
                }
                _ => groups.part_rows(&visit, node, span, &rows.columns[node.axis as usize]),
            }
        }
    }
}

/// Which coordinate of the light a split's axis is, if it is one.
fn light_axis(axis: i8) -> Option<usize> {
    let axis = usize::try_from(axis).ok()?.checked_sub(columns::L)?;
    (axis < 3).then_some(axis)
}

impl Groups {
    /// All rows and lights at the root.
    fn begin(&mut self, rows: usize, lights: usize, span: usize, depth: usize) {
        self.list.clear();
        self.rows.clear();
        self.lights.clear();
        self.light_ids.clear();
        self.light_ids.extend(0..lights as u32);
        self.stack.clear();
        self.words.clear();
        if rows == 0 {
            return;
        }
        self.words.resize(span, u64::MAX);
        if let Some(last) = self.words.last_mut().filter(|_| !rows.is_multiple_of(WORD)) {
            *last = (1 << (rows % WORD)) - 1;
        }
        // one more for the right child while the left one waits
        self.words.resize(span * (depth + 1), 0);
        self.stack.push(Visit {
            node: 0,
            words: 0,
            lights: 0..lights,
        });
    }

    /// Notes what has reached a cell.
    fn leaf(&mut self, cell: u32, visit: &Visit, span: usize) {
        let start = self.rows.len();
        let words = &self.words[visit.words..][..span];
        for (first, &word) in (0u32..).step_by(WORD).zip(words) {
            if word == u64::MAX {
                self.rows.extend(first..first + WORD as u32);
                continue;
            }
            let mut left = word;
            while left != 0 {
                self.rows.push(first + left.trailing_zeros());
                left &= left - 1;
            }
        }
        let first_light = self.lights.len();
        self.lights
            .extend_from_slice(&self.light_ids[visit.lights.clone()]);
        self.list.push(Group {
            cell,
            rows: start..self.rows.len(),
            lights: first_light..self.lights.len(),
        });
    }

    /// Sends the lights left and right; the rows go with both.
    fn part_lights(&mut self, visit: &Visit, node: Node, span: usize, above: impl Fn(u32) -> bool) {
        let ids = &mut self.light_ids[visit.lights.clone()];
        ids.sort_by_key(|&id| above(id));
        let middle = visit.lights.start + ids.partition_point(|&id| !above(id));
        let (below, above) = (visit.lights.start..middle, middle..visit.lights.end);
        let right = if below.is_empty() {
            visit.words
        } else {
            let (from, to) = (visit.words, visit.words + span);
            self.words.copy_within(from..from + span, to);
            to
        };
        self.push(node.left, visit.words, below);
        self.push(node.left + 1, right, above);
    }

    /// Sends the rows left and right; the lights go with both.
    fn part_rows(&mut self, visit: &Visit, node: Node, span: usize, column: &[f32]) {
        let (left, right) = self.words[visit.words..][..2 * span].split_at_mut(span);
        let [some_left, some_right] = part(column, node.threshold, left, right);
        if some_left {
            self.push(node.left, visit.words, visit.lights.clone());
        }
        if some_right {
            self.push(node.left + 1, visit.words + span, visit.lights.clone());
        }
    }

    fn push(&mut self, node: u32, words: usize, lights: Range<usize>) {
        self.stack.push(Visit {
            node,
            words,
            lights,
        });
    }
}

/// Leaves in `left` the rows whose value is not at or above the threshold, moves the others to
/// `right`; whether either has any.
#[multiversion(targets(
    "x86_64+avx+avx2+fma+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx+avx2+fma"
))]
fn part(column: &[f32], threshold: f32, left: &mut [u64], right: &mut [u64]) -> [bool; 2] {
    let (mut any_left, mut any_right) = (0, 0);
    let (whole, rest) = column.as_chunks::<WORD>();
    let mut padded = [f32::NEG_INFINITY; WORD];
    for (padded, x) in padded.iter_mut().zip(rest) {
        *padded = *x;
    }
    let values = whole.iter().chain(std::iter::once(&padded));
    for ((left, right), values) in left.iter_mut().zip(right).zip(values) {
        if *left == 0 {
            *right = 0;
            continue;
        }
        let goes = *left & above(values, threshold);
        *right = goes;
        *left ^= goes;
        any_left |= *left;
        any_right |= goes;
    }
    [any_left != 0, any_right != 0]
}

/// Bit i tells whether value i is at or above the threshold.
#[inline(always)]
fn above(values: &[f32; WORD], threshold: f32) -> u64 {
    // eight lanes, so that whole registers are compared; one reduction at the end
    let mut lanes = [0u64; 8];
    for (k, values) in values.as_chunks::<8>().0.iter().enumerate() {
        for j in 0..8 {
            lanes[j] |= u64::from(values[j] >= threshold) << (8 * k + j);
        }
    }
    lanes.iter().fold(0, |bits, lane| bits | lane)
}
