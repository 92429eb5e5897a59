//! The first kd-tree: cells that are small and flat, before anything is known of the light.
//!
//! Greedy splits of the leaf, axis and place that remove most of the within-cell scatter of
//! (p, n, l), each scaled so that a turned normal weighs more than a distance: walls and
//! objects come apart first, then walls are cut and the light box is cut.

use rrf_field::columns::{self, Columns};
use rrf_field::tree::Tree;

/// Weights of a unit of each column group in the scatter.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Weights {
    /// A scene diagonal in the surface point.
    pub point: f32,
    /// A unit of the normal.
    pub normal: f32,
    /// A scene diagonal in the light position.
    pub light: f32,
}

impl Default for Weights {
    fn default() -> Weights {
        Weights {
            point: 1.0,
            normal: 2.0,
            light: 1.0,
        }
    }
}

const AXES: usize = 9;
const COLUMN: [usize; AXES] = [
    columns::P,
    columns::P + 1,
    columns::P + 2,
    columns::N,
    columns::N + 1,
    columns::N + 2,
    columns::L,
    columns::L + 1,
    columns::L + 2,
];

struct Leaf {
    node: usize,
    rows: Vec<u32>,
    split: Option<Split>,
}

#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    threshold: f32,
    gain: f64,
}

/// Grows a tree of at most `cells` cells; no cell gets fewer than `fewest` of `rows`.
/// `diagonal` is the length that a unit of [`Weights::point`] and `light` means.
pub fn grow(rows: &Columns, diagonal: f32, weights: Weights, cells: u32, fewest: usize) -> Tree {
    let features = features(rows, diagonal, weights);
    let mut tree = Tree::single();
    let all: Vec<u32> = (0..rows.len() as u32).collect();
    let split = best_split(&features, rows, &all, fewest);
    let mut leaves = vec![Leaf {
        node: 0,
        rows: all,
        split,
    }];
    for cell in 1..cells {
        let Some((place, split)) = best_leaf(&leaves) else {
            break;
        };
        let leaf = leaves.swap_remove(place);
        let column = &rows.columns[COLUMN[split.axis]];
        let (right, left): (Vec<u32>, Vec<u32>) = leaf
            .rows
            .iter()
            .partition(|&&r| column[r as usize] >= split.threshold);
        let nodes = tree.split(leaf.node, COLUMN[split.axis], split.threshold, cell);
        for (node, rows_of) in nodes.into_iter().zip([left, right]) {
            let split = best_split(&features, rows, &rows_of, fewest);
            leaves.push(Leaf {
                node,
                rows: rows_of,
                split,
            });
        }
    }
    tree
}

/// The leaf whose split gains most; ties go to the lower node id.
fn best_leaf(leaves: &[Leaf]) -> Option<(usize, Split)> {
    let mut best: Option<(usize, Split)> = None;
    for (place, leaf) in leaves.iter().enumerate() {
        let Some(split) = leaf.split else { continue };
        let better = best.is_none_or(|(p, b)| {
            split.gain > b.gain || (split.gain == b.gain && leaf.node < leaves[p].node)
        });
        if better {
            best = Some((place, split));
        }
    }
    best
}

fn features(rows: &Columns, diagonal: f32, weights: Weights) -> [Vec<f32>; AXES] {
    std::array::from_fn(|a| {
        let scale = match a / 3 {
            0 => weights.point / diagonal,
            1 => weights.normal,
            _ => weights.light / diagonal,
        };
        rows.columns[COLUMN[a]].iter().map(|x| x * scale).collect()
    })
}

/// The split of `of` that removes most scatter, or none where no split keeps `fewest` rows.
fn best_split(
    features: &[Vec<f32>; AXES],
    rows: &Columns,
    of: &[u32],
    fewest: usize,
) -> Option<Split> {
    let fewest = fewest.max(1);
    if of.len() < 2 * fewest {
        return None;
    }
    let mut best: Option<Split> = None;
    for (axis, &at) in COLUMN.iter().enumerate() {
        let column = &rows.columns[at];
        let mut order = of.to_vec();
        order.sort_by(|&a, &b| {
            column[a as usize]
                .total_cmp(&column[b as usize])
                .then(a.cmp(&b))
        });
        if let Some(split) = best_place(features, column, &order, axis, fewest)
            && best.is_none_or(|b| split.gain > b.gain)
        {
            best = Some(split);
        }
    }
    best
}

/// Scatter removed by cutting after place i: n_l n_r / n |mean_l - mean_r|^2, summed over axes.
fn best_place(
    features: &[Vec<f32>; AXES],
    column: &[f32],
    order: &[u32],
    axis: usize,
    fewest: usize,
) -> Option<Split> {
    let total: [f64; AXES] = std::array::from_fn(|a| {
        order
            .iter()
            .map(|&r| f64::from(features[a][r as usize]))
            .sum()
    });
    let mut left = [0.0f64; AXES];
    let n = order.len() as f64;
    let mut best: Option<Split> = None;
    for i in 1..order.len() {
        let (before, here) = (order[i - 1] as usize, order[i] as usize);
        for a in 0..AXES {
            left[a] += f64::from(features[a][before]);
        }
        let (low, high) = (column[before], column[here]);
        let threshold = low + (high - low) * 0.5;
        if i < fewest || order.len() - i < fewest || threshold <= low {
            continue;
        }
        let (nl, nr) = (i as f64, n - i as f64);
        let gap: f64 = (0..AXES)
            .map(|a| (left[a] / nl - (total[a] - left[a]) / nr).powi(2))
            .sum();
        let gain = nl * nr / n * gap;
        // below this the columns differ by rounding alone
        if gain > 1e-9 * n && best.is_none_or(|b| gain > b.gain) {
            best = Some(Split {
                axis,
                threshold,
                gain,
            });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(n: usize, row: impl Fn(usize) -> [f32; columns::COUNT]) -> Columns {
        let mut rows = Columns::default();
        (0..n).for_each(|i| rows.push(row(i)));
        rows
    }

    /// Two walls back to back (same place, opposite normals) come apart before anything else.
    #[test]
    fn the_two_sides_of_a_wall_come_apart_first() {
        let rows = rows(400, |i| {
            let mut r = [0.0; columns::COUNT];
            r[columns::P] = (i / 2) as f32 / 200.0;
            r[columns::N + 1] = if i % 2 == 0 { 1.0 } else { -1.0 };
            r
        });
        let tree = grow(&rows, 2.0, Weights::default(), 2, 10);
        assert_eq!(tree.axis[0], columns::N as i8 + 1);
        assert_eq!(tree.cells(), 2);
    }

    /// No cell falls below the fewest rows, equal rows are never parted, and the tree stops.
    #[test]
    fn degenerate_rows_stop_the_growth() {
        let same = rows(100, |_| [0.5; columns::COUNT]);
        assert_eq!(grow(&same, 1.0, Weights::default(), 8, 1).cells(), 1);
        assert_eq!(
            grow(&Columns::default(), 1.0, Weights::default(), 8, 1).cells(),
            1
        );
        let line = rows(100, |i| {
            let mut r = [0.0; columns::COUNT];
            r[columns::L] = i as f32;
            r
        });
        let tree = grow(&line, 100.0, Weights::default(), 64, 12);
        let mut count = vec![0; tree.cells()];
        tree.find_all(&line)
            .iter()
            .for_each(|&c| count[c as usize] += 1);
        assert!(count.iter().all(|&c| c >= 12), "{count:?}");
        assert!(count.len() >= 4);
    }
}
