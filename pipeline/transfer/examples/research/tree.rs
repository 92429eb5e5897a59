//! Cells: rows that one small net is to follow.

use crate::table::Row;

/// A node: a cut, or a cell.
enum Node {
    Cut {
        axis: usize,
        at: f32,
        below: usize,
        above: usize,
    },
    Cell(usize),
}

/// A tree over positions, normals and objects, cut where light differs most in relative terms.
pub struct Tree {
    nodes: Vec<Node>,
    pub cells: Vec<Vec<usize>>,
    /// Place of each object in an order by what it gets: neighbours in it are alike.
    order: Vec<f32>,
}

const AXES: usize = 8;

impl Tree {
    /// Cells of at most `most` rows; `features` are what rows get, one list a row.
    pub fn new(rows: &[Row], features: &[Vec<f32>], most: usize) -> Tree {
        let objects = rows
            .iter()
            .map(|r| r.object as usize + 1)
            .max()
            .unwrap_or(1);
        let mut sums = vec![(0.0f32, 0.0f32); objects];
        for (row, f) in rows.iter().zip(features) {
            sums[row.object as usize].0 += f[0];
            sums[row.object as usize].1 += 1.0;
        }
        let mut by: Vec<usize> = (0..objects).collect();
        let mean = |o: usize| sums[o].0 / sums[o].1.max(1.0);
        by.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)).then(a.cmp(&b)));
        let mut order = vec![0.0; objects];
        by.iter()
            .enumerate()
            .for_each(|(i, &o)| order[o] = i as f32);
        let mut tree = Tree {
            nodes: Vec::new(),
            cells: Vec::new(),
            order,
        };
        let (metal, other): (Vec<usize>, Vec<usize>) =
            (0..rows.len()).partition(|&i| rows[i].metal);
        if metal.is_empty() || other.is_empty() {
            tree.grow(rows, features, (0..rows.len()).collect(), most);
            return tree;
        }
        tree.nodes.push(Node::Cell(0));
        let below = tree.grow(rows, features, other, most);
        let above = tree.grow(rows, features, metal, most);
        tree.nodes[0] = Node::Cut {
            axis: AXES - 1,
            at: 0.5,
            below,
            above,
        };
        tree
    }

    fn coordinate(&self, row: &Row, axis: usize) -> f32 {
        match axis {
            0..3 => row.position[axis],
            3..6 => row.geometric[axis - 3],
            6 => self.order[row.object as usize],
            _ => f32::from(u8::from(row.metal)),
        }
    }

    fn grow(&mut self, rows: &[Row], features: &[Vec<f32>], of: Vec<usize>, most: usize) -> usize {
        let node = self.nodes.len();
        self.nodes.push(Node::Cell(self.cells.len()));
        let least = (most / 6).max(24);
        let cut = if of.len() > most {
            self.best(rows, features, &of, least)
        } else {
            None
        };
        let Some((axis, at)) = cut else {
            self.cells.push(of);
            return node;
        };
        let (above, below): (Vec<usize>, Vec<usize>) = of
            .iter()
            .partition(|&&i| self.coordinate(&rows[i], axis) >= at);
        let below = self.grow(rows, features, below, most);
        let above = self.grow(rows, features, above, most);
        self.nodes[node] = Node::Cut {
            axis,
            at,
            below,
            above,
        };
        node
    }

    /// The cut that removes most scatter.
    fn best(
        &self,
        rows: &[Row],
        features: &[Vec<f32>],
        of: &[usize],
        least: usize,
    ) -> Option<(usize, f32)> {
        let width = features[of[0]].len();
        let mut total = vec![0.0f64; width];
        of.iter().for_each(|&i| add(&mut total, &features[i], 1.0));
        let mut best: Option<(f64, usize, f32)> = None;
        for axis in 0..AXES {
            let mut sorted: Vec<(f32, usize)> = of
                .iter()
                .map(|&i| (self.coordinate(&rows[i], axis), i))
                .collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut left = vec![0.0f64; width];
            for k in 1..sorted.len() {
                add(&mut left, &features[sorted[k - 1].1], 1.0);
                let (low, high) = (sorted[k - 1].0, sorted[k].0);
                if k < least || sorted.len() - k < least || high - low <= 1e-5 {
                    continue;
                }
                let (nl, nr) = (k as f64, (sorted.len() - k) as f64);
                let gap: f64 = left
                    .iter()
                    .zip(&total)
                    .map(|(l, t)| (l / nl - (t - l) / nr).powi(2))
                    .sum();
                let gain = nl * nr * gap;
                if best.is_none_or(|b| gain > b.0) {
                    best = Some((gain, axis, 0.5 * (low + high)));
                }
            }
        }
        best.map(|(_, axis, at)| (axis, at))
    }

    /// The cell of a row.
    pub fn find(&self, row: &Row) -> usize {
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Cell(cell) => return cell,
                Node::Cut {
                    axis,
                    at,
                    below,
                    above,
                } => {
                    node = if self.coordinate(row, axis) >= at {
                        above
                    } else {
                        below
                    }
                }
            }
        }
    }
}

fn add(sum: &mut [f64], of: &[f32], by: f64) {
    sum.iter_mut()
        .zip(of)
        .for_each(|(s, &x)| *s += by * f64::from(x));
}
