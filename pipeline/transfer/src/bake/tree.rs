//! Cuts surfaces into cells.

use crate::model::{AXES, CellNode, LEAF_AXIS, SurfaceCells, coordinate};
use crate::query::TransferQuery;
use crate::regression::RowTable;

/// Shortest gap that a cut may go through, metres or sines.
const GAP: f32 = 1e-5;

/// Gap in a coordinate of the normals that is an edge between two faces.
const EDGE: f32 = 0.5;

/// Deviation of the logarithm of what rows get from which on a cell is cut whatever its size.
const UNEVEN: f64 = 0.5;
/// Rows of a cell that is cut off.
const LEAST_ROWS: usize = 32;

/// Cells of at most `most` rows, cut where rows differ most in relative terms: makes the tree of one
/// surface and returns the rows of each cell.
pub(crate) fn cut(
    tree: &mut SurfaceCells,
    table: &RowTable,
    weights: &[f32],
    rows: Vec<u32>,
    most: usize,
) -> Vec<Vec<u32>> {
    let Some(&first) = rows.first() else {
        return Vec::new();
    };
    let mut cutter = Cutter {
        table,
        weights,
        most: most.max(2),
        nodes: &mut tree.nodes,
        cells: Vec::new(),
    };
    let root = cutter.grow(rows);
    let cells = cutter.cells;
    let key = table.queries[first as usize].surface;
    tree.roots.push((key, root));
    cells
}

struct Cutter<'a> {
    table: &'a RowTable,
    weights: &'a [f32],
    most: usize,
    nodes: &'a mut Vec<CellNode>,
    cells: Vec<Vec<u32>>,
}

/// Features of a row: the logarithm of what it gets, and what groups of lights make of that.
const FEATURES: usize = 7;

impl Cutter<'_> {
    fn grow(&mut self, rows: Vec<u32>) -> u32 {
        let node = self.nodes.len();
        self.nodes.push(CellNode {
            axis: LEAF_AXIS,
            at: 0.0,
            below: self.cells.len() as u32,
            above: 0,
        });
        let is_large = rows.len() > self.most || self.is_uneven(&rows);
        let cut = self
            .between_faces(&rows)
            .or_else(|| is_large.then(|| self.best(&rows)).flatten());
        let Some((axis, at)) = cut else {
            self.cells.push(rows);
            return node as u32;
        };
        let is_below = |&row: &u32| coordinate(self.query(row), axis) < at;
        let (below, above): (Vec<u32>, Vec<u32>) = rows.into_iter().partition(is_below);
        let below = self.grow(below);
        let above = self.grow(above);
        self.nodes[node] = CellNode {
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
        let mut features = [0.0; FEATURES];
        features[0] = -1.5 * f64::from(weight.ln());
        let query = self.query(row);
        let lights = self.table.lights.max(1);
        let part = self.table.part(row as usize, 0);
        // a few groups of lights: near ones and far ones differ in them
        for (l, &lit) in part.iter().enumerate() {
            let colour = query.base_color[l / lights] * weight;
            let group = 1 + (l % lights) * (FEATURES - 1) / lights;
            features[group] +=
                f64::from(lit * colour) / (3 * lights / (FEATURES - 1)).max(1) as f64;
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

    /// Whether what rows get differs by factors, as it does at contacts.
    fn is_uneven(&self, rows: &[u32]) -> bool {
        if rows.len() < 4 * LEAST_ROWS {
            return false;
        }
        let logarithms = rows
            .iter()
            .map(|&row| f64::from(self.weights[row as usize]).ln());
        let (mut sum, mut squares) = (0.0, 0.0);
        for logarithm in logarithms {
            sum += logarithm;
            squares += logarithm * logarithm;
        }
        let count = rows.len() as f64;
        squares / count - (sum / count).powi(2) > UNEVEN * UNEVEN
    }

    /// The cut that removes most scatter.
    fn best(&self, rows: &[u32]) -> Option<(u8, f32)> {
        let features: Vec<_> = rows.iter().map(|&row| self.features(row)).collect();
        let mut total = [0.0; FEATURES];
        features.iter().for_each(|f| add(&mut total, f));
        let least = (rows.len() / 6).max(LEAST_ROWS).min(rows.len() / 2);
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
