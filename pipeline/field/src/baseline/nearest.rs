//! The nearest rows of those trained on, weighted by inverse squared distance (Shepard 1968), found
//! by a kd-tree.

/// Rows that an answer is made of.
pub const NEIGHBOURS: usize = 8;
/// Rows of a leaf, at the most.
const LEAF: usize = 16;
/// Roundings of a lower bound of a squared distance are below this share of it.
const ROUNDING: f64 = 1e-12;

/// Rows in the order of their tree's leaves.
#[derive(Clone, Debug)]
pub struct Nearest {
    inputs: usize,
    nodes: Vec<Node>,
    /// Scaled inputs, row after row.
    points: Vec<f32>,
    values: Vec<[f32; 3]>,
    /// Places in the list that they came in.
    ids: Vec<u32>,
}

/// Left of the plane lies what is not above it: the next node; at a leaf `right` is 0.
#[derive(Clone, Copy, Debug)]
struct Node {
    axis: usize,
    at: f32,
    right: usize,
    first: usize,
    end: usize,
}

/// The nearest so far, nearest first: squared distance, place in the list, place in leaf order.
struct Found {
    rows: [(f64, u32, usize); NEIGHBOURS],
    count: usize,
}

impl Nearest {
    /// Of `rows` rows' inputs, row after row, and then their outputs.
    pub fn new(inputs: usize, rows: usize, weights: &[f32]) -> Nearest {
        let (points, values) = weights.split_at(inputs * rows);
        let mut order: Vec<u32> = (0..rows as u32).collect();
        let mut nodes = Vec::new();
        let table = Table { inputs, points };
        table.grow(&mut order, 0, &mut nodes);
        let places = || order.iter().map(|&id| id as usize);
        Nearest {
            inputs,
            nodes,
            points: places()
                .flat_map(|id| table.row(id).iter().copied())
                .collect(),
            values: places()
                .map(|id| std::array::from_fn(|c| values[3 * id + c]))
                .collect(),
            ids: order,
        }
    }

    /// Mean of the nearest rows' values; where a row lies on `x`, its value (the mean of those that do).
    pub fn answer(&self, x: &[f32], work: &mut Vec<f64>) -> [f64; 3] {
        let mut found = Found {
            rows: [(f64::INFINITY, u32::MAX, 0); NEIGHBOURS],
            count: 0,
        };
        work.clear();
        work.resize(self.inputs, 0.0);
        self.visit(0, x, work, &mut found);
        let rows = &found.rows[..found.count];
        let on_it = rows.first().is_some_and(|(square, ..)| *square == 0.0);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for &(square, _, place) in rows {
            let weight = match on_it {
                true => f64::from(u8::from(square == 0.0)),
                false => 1.0 / square,
            };
            weights += weight;
            for (sum, value) in sum.iter_mut().zip(self.values[place]) {
                *sum += weight * f64::from(value);
            }
        }
        sum.map(|sum| sum / weights)
    }

    /// Looks below a node; `beyond[axis]` is the squared distance from `x` to the node's box along
    /// that axis (Arya, Mount 1993).
    fn visit(&self, node: usize, x: &[f32], beyond: &mut [f64], found: &mut Found) {
        let Node {
            axis,
            at,
            right,
            first,
            end,
        } = self.nodes[node];
        if right == 0 {
            for place in first..end {
                let point = &self.points[place * self.inputs..][..self.inputs];
                found.offer(square(x, point), self.ids[place], place);
            }
            return;
        }
        let past = f64::from(x[axis]) - f64::from(at);
        let (near, far) = if past < 0.0 {
            (node + 1, right)
        } else {
            (right, node + 1)
        };
        self.visit(near, x, beyond, found);
        let before = std::mem::replace(&mut beyond[axis], past * past);
        let bound: f64 = beyond.iter().sum();
        if bound * (1.0 - ROUNDING) <= found.farthest() {
            self.visit(far, x, beyond, found);
        }
        beyond[axis] = before;
    }
}

fn square(a: &[f32], b: &[f32]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| f64::from(*a) - f64::from(*b));
    differences.map(|d| d * d).sum()
}

impl Found {
    /// Farther rows need not be looked at.
    fn farthest(&self) -> f64 {
        match self.count {
            NEIGHBOURS => self.rows[NEIGHBOURS - 1].0,
            _ => f64::INFINITY,
        }
    }

    /// Takes a row among the nearest; of two as near the one that came first in the list.
    fn offer(&mut self, square: f64, id: u32, place: usize) {
        let row = (square, id, place);
        let nearer = |other: &(f64, u32, usize)| (row.0, row.1) < (other.0, other.1);
        let at = self.rows[..self.count].partition_point(|other| !nearer(other));
        if at == NEIGHBOURS {
            return;
        }
        self.count = (self.count + 1).min(NEIGHBOURS);
        self.rows[at..self.count].rotate_right(1);
        self.rows[at] = row;
    }
}

/// Rows before they are in order.
struct Table<'a> {
    inputs: usize,
    points: &'a [f32],
}

impl Table<'_> {
    fn row(&self, id: usize) -> &[f32] {
        &self.points[id * self.inputs..][..self.inputs]
    }

    /// Puts `ids` in leaf order, the first of them at `first`: halves along the widest axis.
    fn grow(&self, ids: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
        let end = first + ids.len();
        let node = nodes.len();
        nodes.push(Node {
            axis: 0,
            at: 0.0,
            right: 0,
            first,
            end,
        });
        let Some(axis) = self.widest(ids).filter(|_| ids.len() > LEAF) else {
            return;
        };
        let middle = ids.len() / 2;
        let x = |id: u32| self.row(id as usize)[axis];
        ids.select_nth_unstable_by(middle, |&a, &b| x(a).total_cmp(&x(b)).then(a.cmp(&b)));
        let at = x(ids[middle]);
        let (left, right) = ids.split_at_mut(middle);
        self.grow(left, first, nodes);
        nodes[node] = Node {
            axis,
            at,
            right: nodes.len(),
            first,
            end,
        };
        self.grow(right, first + middle, nodes);
    }

    /// The axis along which rows lie farthest apart; none where they lie on one another.
    fn widest(&self, ids: &[u32]) -> Option<usize> {
        let extent = |axis: usize| {
            let values = ids.iter().map(|&id| self.row(id as usize)[axis]);
            let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            f64::from(high) - f64::from(low)
        };
        let axes = (0..self.inputs).map(|axis| (extent(axis), axis));
        let widest = axes.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        widest
            .filter(|(extent, _)| *extent > 0.0)
            .map(|(_, axis)| axis)
    }
}
