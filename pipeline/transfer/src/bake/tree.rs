//! Cuts surfaces into cells.

use crate::model::{AXES, CellNode, LEAF_AXIS, SurfaceCells, coordinate};
use crate::query::{SurfaceKey, TransferQuery};
use crate::regression::RowTable;
use std::collections::BTreeMap;

/// Shortest gap that a cut may go through, metres or sines.
const GAP: f32 = 1e-5;

/// Gap in a coordinate of the normals that is an edge between two faces.
const EDGE: f32 = 0.5;

/// Cells of at most `most` rows of one surface each, cut where rows differ most in relative terms; the
/// rows of each.
pub(crate) fn cut(
    table: &RowTable,
    weights: &[f32],
    of: &[u32],
    most: usize,
) -> (SurfaceCells, Vec<Vec<u32>>) {
    let mut surfaces: BTreeMap<SurfaceKey, Vec<u32>> = BTreeMap::new();
    for &row in of {
        let key = table.queries[row as usize].surface;
        surfaces.entry(key).or_default().push(row);
    }
    let mut cutter = Cutter {
        table,
        weights,
        most: most.max(2),
        tree: SurfaceCells::default(),
        cells: Vec::new(),
    };
    for (key, rows) in surfaces {
        let root = cutter.grow(rows);
        cutter.tree.roots.push((key, root));
    }
    (cutter.tree, cutter.cells)
}

struct Cutter<'a> {
    table: &'a RowTable,
    weights: &'a [f32],
    most: usize,
    tree: SurfaceCells,
    cells: Vec<Vec<u32>>,
}

/// Features of a row: the logarithm of what it gets, and its first coefficients over that.
const FEATURES: usize = 7;

impl Cutter<'_> {
    fn grow(&mut self, rows: Vec<u32>) -> u32 {
        let node = self.tree.nodes.len();
        self.tree.nodes.push(CellNode {
            axis: LEAF_AXIS,
            at: 0.0,
            below: self.cells.len() as u32,
            above: 0,
        });
        let cut = self
            .between_faces(&rows)
            .or_else(|| (rows.len() > self.most).then(|| self.best(&rows)).flatten());
        let Some((axis, at)) = cut else {
            self.cells.push(rows);
            return node as u32;
        };
        let is_below = |&row: &u32| coordinate(self.query(row), axis) < at;
        let (below, above): (Vec<u32>, Vec<u32>) = rows.into_iter().partition(is_below);
        let below = self.grow(below);
        let above = self.grow(above);
        self.tree.nodes[node] = CellNode {
            axis,
            at,
            below,
            above,
        };
        node as u32
    }

    fn query(&self, row: u32) -> &TransferQuery {
        &self.table.queries[row as usize]
    }

    fn features(&self, row: u32) -> [f64; FEATURES] {
        let weight = self.weights[row as usize];
        let halves = [0, 1].map(|half| self.table.part(row as usize, half, 0));
        let mut features = [0.0; FEATURES];
        features[0] = -1.5 * f64::from(weight.ln());
        let colour = self.query(row).base_color.element_sum() / 3.0;
        for (k, feature) in features[1..].iter_mut().enumerate() {
            let sum: f32 = halves
                .iter()
                .flat_map(|h| h.get(3 * k..3 * k + 3))
                .flatten()
                .sum();
            *feature = f64::from(sum / 6.0 * colour * weight);
        }
        features
    }

    /// A cut between faces that are turned away from each other: no fit goes around an edge.
    fn between_faces(&self, rows: &[u32]) -> Option<(u8, f32)> {
        (3..AXES as u8).find_map(|axis| {
            let coordinates = rows.iter().map(|&row| coordinate(self.query(row), axis));
            let mut sorted: Vec<f32> = coordinates.collect();
            sorted.sort_by(f32::total_cmp);
            let gap = sorted.windows(2).find(|pair| pair[1] - pair[0] > EDGE)?;
            Some((axis, 0.5 * (gap[0] + gap[1])))
        })
    }

    /// The cut that removes most scatter.
    fn best(&self, rows: &[u32]) -> Option<(u8, f32)> {
        let features: Vec<_> = rows.iter().map(|&row| self.features(row)).collect();
        let mut total = [0.0; FEATURES];
        features.iter().for_each(|f| add(&mut total, f));
        let least = (self.most / 6).clamp(1, rows.len() / 2);
        let mut best: Option<(f64, u8, f32)> = None;
        for axis in 0..AXES as u8 {
            let mut sorted: Vec<(f32, usize)> = (rows.iter().enumerate())
                .map(|(i, &row)| (coordinate(self.query(row), axis), i))
                .collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut left = [0.0; FEATURES];
            for k in 1..sorted.len() {
                add(&mut left, &features[sorted[k - 1].1]);
                let (low, high) = (sorted[k - 1].0, sorted[k].0);
                if k < least || sorted.len() - k < least || high - low <= GAP {
                    continue;
                }
                let (nl, nr) = (k as f64, (sorted.len() - k) as f64);
                let gaps = left.iter().zip(&total);
                let gap: f64 = gaps.map(|(l, t)| (l / nl - (t - l) / nr).powi(2)).sum();
                let gain = nl * nr * gap;
                if best.is_none_or(|b| gain > b.0) {
                    best = Some((gain, axis, 0.5 * (low + high)));
                }
            }
        }
        best.map(|(_, axis, at)| (axis, at))
    }
}

fn add(sum: &mut [f64; FEATURES], of: &[f64; FEATURES]) {
    sum.iter_mut().zip(of).for_each(|(s, x)| *s += x);
}
