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

use super::initialization::Initialization;
use super::optimizer::{OptimizerRun, Phase};
use crate::cell::Cell;
use crate::net::problem::NetProblem;
use crate::report::Net;
use rrf_field::net::Shape;
use rrf_lm::{Cholesky, LmConfig, NormalEquations, Problem};

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
}

/// The net without the columns and without the units behind them.
fn remove(columns: &[Column], shape: &Shape, w: &[f64]) -> (Shape, Vec<f64>) {
    let mut gone = vec![false; w.len()];
    let mut smaller = shape.clone();
    for column in columns {
        for place in column.places(shape) {
            gone[place] = true;
        }
        if let Some(below) = column.layer.checked_sub(1) {
            let width = shape.sizes[below] + 1;
            let start = shape.offsets()[below] + column.from * width;
            gone[start..start + width].fill(true);
        }
        smaller.sizes[column.layer] -= 1;
    }
    let kept = w.iter().zip(&gone).filter(|(_, gone)| !**gone);
    (smaller, kept.map(|(w, _)| *w).collect())
}

/// Share of what the squared error may still rise by that columns going at once are predicted to cost. The
/// prediction holds near the minimum; after the steps that follow the rise is several times that.
const PREDICTED: f64 = 0.3;
/// Single columns tried before pruning ends.
const TRIES: usize = 3;

/// Steps after each removal.
const RETRAIN: Phase = Phase {
    share: 1.0,
    steps: 8,
    patience: 4,
};

/// First damping of these steps: the minimum is near.
const NEAR: f64 = 1e-5;

/// Removes inputs and units for as long as the squared error stays below `limit`: several at once,
/// half as many whenever that was too much.
pub(crate) fn prune(cell: &mut Cell, mut net: Net, limit: f64) -> Net {
    let Some(mut order) = cheapest(cell, &net) else {
        return net;
    };
    let (mut most, mut tries) = (usize::MAX, 0);
    while tries < TRIES && !cell.is_halted() {
        let room = PREDICTED * (limit - net.error);
        let Some((columns, weights)) = order.without(&net, tries, most, room) else {
            break;
        };
        match retrained(cell, &net, &columns, &weights, limit) {
            Some(smaller) => {
                net = smaller;
                tries = 0;
                match cheapest(cell, &net) {
                    Some(found) => order = found,
                    None => break,
                }
            }
            None if columns.len() > 1 => most = columns.len() / 2,
            None => tries += 1,
        }
    }
    net
}

/// The net without the columns after a few steps, if its error is within the limit.
fn retrained(
    cell: &mut Cell,
    net: &Net,
    columns: &[Column],
    weights: &[f64],
    limit: f64,
) -> Option<Net> {
    let (shape, weights) = remove(columns, &net.shape, weights);
    let inputs = cell.units.inputs.clone();
    let gone = |input: usize| {
        columns.contains(&Column {
            layer: 0,
            from: input,
        })
    };
    let (dropped, kept): (Vec<usize>, Vec<usize>) = (0..inputs.len()).partition(|&at| gone(at));
    if !dropped.is_empty() {
        cell.set_inputs(kept.iter().map(|&at| inputs[at].clone()).collect());
    }
    // exponents have no best output layer to start with
    let how = match cell.config.exponential {
        true => Initialization::Fitted,
        false => Initialization::Mean,
    };
    let lm = LmConfig {
        tau: NEAR,
        ..cell.config.lm
    };
    let mut run = OptimizerRun::new(cell, shape, weights, how, lm);
    run.alpha = net.alpha;
    run.run(RETRAIN);
    let (smaller, _) = run.finish();
    if smaller.error <= limit {
        let dropped = dropped.iter().map(|&at| inputs[at].id);
        cell.dropped_inputs.extend(dropped);
        return Some(smaller);
    }
    if !dropped.is_empty() {
        cell.set_inputs(inputs);
    }
    None
}

/// All columns whose removal leaves a net, the cheapest first.
struct Order {
    /// Each with its predicted cost, ΔF a residual.
    columns: Vec<(f64, Column)>,
    /// H⁻¹.
    inverse: Vec<f64>,
}

impl Order {
    /// At most `most` columns from the `skip`-th on that cost no more than `room` together, no more than half
    /// of a layer, and the weights moved for their going.
    fn without(
        &self,
        net: &Net,
        skip: usize,
        most: usize,
        room: f64,
    ) -> Option<(Vec<Column>, Vec<f64>)> {
        let mut left: Vec<usize> = net.shape.sizes.iter().map(|size| size / 2).collect();
        let mut predicted = 0.0;
        let order = self.columns.iter().skip(skip);
        let within = order.take_while(|(cost, _)| {
            predicted += cost;
            predicted <= room
        });
        let of_half = within.filter(|(_, column)| {
            let left = &mut left[column.layer];
            let some = *left > 0;
            *left -= usize::from(some);
            some
        });
        let columns: Vec<Column> = of_half.map(|(_, column)| *column).take(most).collect();
        if columns.is_empty() {
            return None;
        }
        let places: Vec<usize> = (columns.iter())
            .flat_map(|column| column.places(&net.shape))
            .collect();
        let (_, moved) = without(&self.inverse, &net.weights, &places)?;
        Some((columns, moved))
    }
}

/// The predicted cost of each column; none where the normal equations cannot be solved.
fn cheapest(cell: &Cell, net: &Net) -> Option<Order> {
    let rows = cell.train.first(usize::MAX);
    let residuals = rows.residuals().max(1);
    let mut normal = NormalEquations::zeros(net.weights.len());
    let n = normal.n;
    NetProblem::new(&net.shape, rows, residuals, cell.loss)
        .exponential(cell.config.exponential)
        .precision(cell.config.precision)
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
    let mut columns: Vec<(f64, Column)> = columns
        .filter_map(|column| {
            let (cost, _) = without(&inverse, &net.weights, &column.places(&net.shape))?;
            Some((cost / residuals as f64, column))
        })
        .collect();
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(Order { columns, inverse })
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
        let (smaller, kept) = remove(&[Column { layer: 1, from: 1 }], &shape, &w);
        assert_eq!(smaller.sizes, [2, 2, 3]);
        assert_eq!(
            kept,
            [
                0., 1., 2., 6., 7., 8., 9., 10., 12., 13., 14., 16., 17., 18., 20.
            ]
        );
        let (smaller, kept) = remove(&[Column { layer: 0, from: 0 }], &shape, &w);
        assert_eq!(smaller.sizes, [1, 3, 3]);
        assert_eq!(kept[..6], [0., 2., 3., 5., 6., 8.]);
        // an input and a unit that reads it
        let both = [Column { layer: 1, from: 1 }, Column { layer: 0, from: 0 }];
        let (smaller, kept) = remove(&both, &shape, &w);
        assert_eq!(smaller.sizes, [1, 2, 3]);
        assert_eq!(
            kept,
            [0., 2., 6., 8., 9., 10., 12., 13., 14., 16., 17., 18., 20.]
        );
    }
}
