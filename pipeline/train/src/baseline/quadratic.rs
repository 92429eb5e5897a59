//! Quadratic regression: the normal equations of each channel, solved by Cholesky.

use super::solved::Solved;
use super::weighing::{Row, Weighing};
use crate::cell::Cell;
use crate::net::tile::CHANNELS;
use rrf_field::quadratic::{count, terms};
use rrf_lm::Cholesky;

/// Strengths tried, as shares of the mean diagonal of the normal equations: from what makes them
/// solvable in f64 to what cells of few rows need.
const RIDGES: [f64; 4] = [1e-10, 1e-6, 1e-4, 1e-2];
/// Solutions after which the rows are weighed anew.
const PASSES: usize = 4;

/// One candidate a ridge; those that cannot be solved are left out.
pub(super) fn solve(cell: &Cell) -> Vec<Solved> {
    let inputs = cell.units.inputs.len();
    RIDGES
        .into_iter()
        .filter_map(|ridge| {
            let weights = solve_with(cell, ridge)?;
            Some(Solved {
                weights: weights.iter().flatten().map(|&w| w as f32).collect(),
                layers: vec![inputs, CHANNELS],
                ridge,
            })
        })
        .collect()
}

type Coefficients = [Vec<f64>; CHANNELS];

fn solve_with(cell: &Cell, ridge: f64) -> Option<Coefficients> {
    let terms = count(cell.units.inputs.len())?;
    let mut weighing = Weighing::new(cell);
    let mut found = step(&weighing, terms, ridge)?;
    for _ in 1..PASSES {
        weighing.reweigh(|row| outputs(&found, row));
        found = step(&weighing, terms, ridge)?;
    }
    Some(found)
}

fn outputs(coefficients: &Coefficients, row: &Row) -> [f64; CHANNELS] {
    let mut values = Vec::new();
    terms(row.x.iter().copied(), &mut values);
    let sum = |c: usize| {
        coefficients[c]
            .iter()
            .zip(&values)
            .map(|(w, x)| w * x)
            .sum()
    };
    std::array::from_fn(sum)
}

/// The least squares under the weights as they are.
fn step(weighing: &Weighing, count: usize, ridge: f64) -> Option<Coefficients> {
    let mut equations = [(); CHANNELS].map(|()| Equations::new(count));
    let mut values = Vec::new();
    weighing.each(|row| {
        terms(row.x.iter().copied(), &mut values);
        for (c, equations) in equations.iter_mut().enumerate() {
            equations.add(&values, row.weight[c] * row.weight[c], row.target[c]);
        }
    });
    let [a, b, c] = equations.map(|equations| equations.solve(ridge));
    Some([a?, b?, c?])
}

/// A = Σ w φ φᵀ (its upper triangle) and b = Σ w y φ.
struct Equations {
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl Equations {
    fn new(count: usize) -> Equations {
        Equations {
            matrix: vec![0.0; count * count],
            right: vec![0.0; count],
        }
    }

    fn add(&mut self, values: &[f64], weight: f64, target: f64) {
        if weight == 0.0 {
            return;
        }
        let rows = self.matrix.chunks_exact_mut(values.len());
        for (i, (row, right)) in rows.zip(&mut self.right).enumerate() {
            let scaled = weight * values[i];
            *right += scaled * target;
            for (sum, x) in row[i..].iter_mut().zip(&values[i..]) {
                *sum += scaled * x;
            }
        }
    }

    /// The solution of (A + ridge mean(diag A)) x = b; 0 where no row counts, none where it is not
    /// definite.
    fn solve(mut self, ridge: f64) -> Option<Vec<f64>> {
        let n = self.right.len();
        let mean = (0..n).map(|i| self.matrix[i * n + i]).sum::<f64>() / n as f64;
        if mean == 0.0 {
            return Some(self.right);
        }
        let mut factor = Cholesky::default();
        factor.factor(&self.matrix, &vec![ridge * mean; n]).ok()?;
        factor.solve(&mut self.right).ok()?;
        Some(self.right)
    }
}
