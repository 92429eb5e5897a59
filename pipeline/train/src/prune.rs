//! Taking out inputs and units that a trained net can do without: Optimal Brain Surgeon
//! (Hassibi, Stork 1993) for groups of weights.
//!
//! With H = JᵀWJ + α I at a minimum, forcing the weights of group G to zero costs at least
//!
//! ```text
//!   ΔF = w_Gᵀ (H⁻¹_GG)⁻¹ w_G     with the others moved by  δ = −H⁻¹_·G (H⁻¹_GG)⁻¹ w_G
//! ```
//!
//! (F without the ½ of the paper). An input's group is the weights that read it, a unit's the
//! weights that read the unit. Single weights are left alone: a dense layer would store them as
//! zeros.

use crate::blocks::Normal;
use crate::cell::Cell;
use crate::descent::{Descent, Leg};
use crate::linalg::Cholesky;
use crate::lm::Problem;
use crate::problem::NetProblem;
use rrf_field::net::Shape;

/// A net to be pruned.
pub(crate) struct Net {
    pub shape: Shape,
    pub weights: Vec<f64>,
    /// Squared relative error on the choosing rows.
    pub error: f64,
    /// Weight decay a residual.
    pub alpha: f64,
}

/// A column of a layer's weights: unit (or input) `from` as layer `layer` reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Column {
    layer: usize,
    from: usize,
}

impl Column {
    /// Places of its weights.
    fn places(self, shape: &Shape) -> Vec<usize> {
        let (start, width) = (shape.offsets()[self.layer], shape.sizes[self.layer] + 1);
        (0..shape.sizes[self.layer + 1])
            .map(|unit| start + unit * width + 1 + self.from)
            .collect()
    }

    /// The net without the column and without the unit behind it.
    fn remove(self, shape: &Shape, w: &[f64]) -> (Shape, Vec<f64>) {
        let mut gone = vec![false; w.len()];
        for place in self.places(shape) {
            gone[place] = true;
        }
        if let Some(below) = self.layer.checked_sub(1) {
            let width = shape.sizes[below] + 1;
            let start = shape.offsets()[below] + self.from * width;
            gone[start..start + width].fill(true);
        }
        let mut shape = shape.clone();
        shape.sizes[self.layer] -= 1;
        let kept = w.iter().zip(&gone).filter(|(_, gone)| !**gone);
        (shape, kept.map(|(w, _)| *w).collect())
    }
}

/// Columns tried at each round before pruning ends.
const TRIES: usize = 4;

/// Steps after each removal.
const MEND: Leg = Leg {
    share: 1.0,
    steps: 8,
    patience: 4,
};

/// Removes inputs and units for as long as the squared error stays below `limit`.
pub(crate) fn prune(cell: &mut Cell, mut net: Net, limit: f64) -> Net {
    while let Some(smaller) = round(cell, &net, limit) {
        net = smaller;
    }
    net
}

/// One removal, or none that the limit allows.
fn round(cell: &mut Cell, net: &Net, limit: f64) -> Option<Net> {
    for (column, weights) in cheapest(cell, net)?.into_iter().take(TRIES) {
        let (shape, weights) = column.remove(&net.shape, &weights);
        let taken = (column.layer == 0).then(|| cell.take_input(column.from));
        // exponents have no best output layer to begin with
        let mut mended = match cell.config.exponential {
            true => Descent::going_on(cell, shape, weights),
            false => Descent::from_weights(cell, shape, 0, weights),
        };
        mended.alpha = net.alpha;
        mended.run(MEND);
        let smaller = Net {
            error: mended.error,
            alpha: mended.alpha,
            shape: mended.shape,
            weights: mended.best,
        };
        if smaller.error <= limit {
            if let Some(taken) = taken {
                cell.report.dropped_inputs.push(taken.id());
            }
            return Some(smaller);
        }
        if let Some(taken) = taken {
            cell.put_input(column.from, taken);
        }
    }
    None
}

/// All columns whose removal leaves a net, the cheapest first, with the weights moved for it.
fn cheapest(cell: &Cell, net: &Net) -> Option<Vec<(Column, Vec<f64>)>> {
    let rows = cell.train.first(usize::MAX);
    let residuals = rows.residuals().max(1);
    let mut normal = Normal::zeros(net.weights.len());
    let n = normal.n;
    NetProblem::new(&net.shape, rows, residuals, cell.loss)
        .exponential(cell.config.exponential)
        .linearise(&net.weights, &mut normal);
    let mut factor = Cholesky::default();
    let decay = net.alpha * residuals as f64;
    let top = (0..n).map(|i| normal.matrix[i * n + i]).fold(0.0, f64::max);
    factor
        .factor(&normal.matrix, &vec![decay + 1e-12 * top; n])
        .ok()?;
    let inverse = factor.inverse().ok()?.to_vec();
    let columns = (0..net.shape.sizes.len() - 1).flat_map(|layer| {
        let from = if net.shape.sizes[layer] > 1 {
            0..net.shape.sizes[layer]
        } else {
            0..0
        };
        from.map(move |from| Column { layer, from })
    });
    let mut costs: Vec<(f64, Column, Vec<f64>)> = columns
        .filter_map(|column| {
            let (cost, moved) = without(&inverse, &net.weights, &column.places(&net.shape))?;
            Some((cost, column, moved))
        })
        .collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(costs.into_iter().map(|(_, c, w)| (c, w)).collect())
}

/// ΔF of forcing the weights at `group` to zero, and all weights moved for it.
pub(crate) fn without(inverse: &[f64], w: &[f64], group: &[usize]) -> Option<(f64, Vec<f64>)> {
    let (n, m) = (w.len(), group.len());
    let mut block = vec![0.0; m * m];
    for (i, a) in group.iter().enumerate() {
        for (j, b) in group.iter().enumerate() {
            block[i * m + j] = inverse[a * n + b];
        }
    }
    let mut force: Vec<f64> = group.iter().map(|g| w[*g]).collect();
    let mut factor = Cholesky::default();
    factor.factor(&block, &vec![0.0; m]).ok()?;
    factor.solve(&mut force).ok()?;
    let cost = force.iter().zip(group).map(|(f, g)| f * w[*g]).sum();
    let mut moved: Vec<f64> = (0..n)
        .map(|i| {
            let pull: f64 = group
                .iter()
                .zip(&force)
                .map(|(g, f)| inverse[i * n + g] * f)
                .sum();
            w[i] - pull
        })
        .collect();
    group.iter().for_each(|g| moved[*g] = 0.0);
    Some((cost, moved))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a quadratic the formula is exact: the cost is that of the constrained minimum, found
    /// here by solving for the weights left.
    #[test]
    fn exact_on_a_quadratic() {
        let n = 5;
        let m: Vec<f64> = (0..n * n)
            .map(|i| ((i * 29 + 7) % 17) as f64 / 5.0)
            .collect();
        let mut h = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                h[i * n + j] = (0..n).map(|k| m[i * n + k] * m[j * n + k]).sum();
            }
            h[i * n + i] += 1.0;
        }
        let w = [0.7, -1.1, 0.4, 2.0, -0.3];
        let cost_at = |x: &[f64]| -> f64 {
            let d: Vec<f64> = x.iter().zip(&w).map(|(x, w)| x - w).collect();
            (0..n)
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .map(|(i, j)| d[i] * h[i * n + j] * d[j])
                .sum()
        };
        let mut factor = Cholesky::default();
        factor.factor(&h, &vec![0.0; n]).unwrap();
        let inverse = factor.inverse().unwrap().to_vec();
        let (cost, moved) = without(&inverse, &w, &[1, 3]).unwrap();
        assert_eq!((moved[1], moved[3]), (0.0, 0.0));
        assert!((cost_at(&moved) - cost).abs() < 1e-10 * cost);
        // Nearby points of the constrained plane are no better.
        for free in [0, 2, 4] {
            for step in [-1e-3, 1e-3] {
                let mut other = moved.clone();
                other[free] += step;
                assert!(cost_at(&other) > cost_at(&moved));
            }
        }
    }

    #[test]
    fn removing_a_column_removes_its_unit() {
        let shape = Shape {
            sizes: vec![2, 3, 3],
        };
        let w: Vec<f64> = (0..shape.weights()).map(|i| i as f64).collect();
        let (smaller, kept) = Column { layer: 1, from: 1 }.remove(&shape, &w);
        assert_eq!(smaller.sizes, [2, 2, 3]);
        assert_eq!(
            kept,
            [
                0., 1., 2., 6., 7., 8., 9., 10., 12., 13., 14., 16., 17., 18., 20.
            ]
        );
        let (smaller, kept) = Column { layer: 0, from: 0 }.remove(&shape, &w);
        assert_eq!(smaller.sizes, [1, 3, 3]);
        assert_eq!(kept[..6], [0., 2., 3., 5., 6., 8.]);
    }
}
