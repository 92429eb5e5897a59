//! What a fit starts from.

use super::logarithm::Logarithms;
use crate::cell::Cell;
use crate::net::problem::{Loss, NetProblem};
use crate::net::tile::Rows;
use rrf_field::net::Shape;
use rrf_lm::Solver;

/// What the first phase starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Initialization {
    /// Random hidden units and the output layer that is best for them; of exponents the mean.
    Mean,
    /// A few steps towards the logarithm, for exponents.
    Logarithm,
    /// The weights of a net that was fitted before.
    Fitted,
}

/// Steps of [`Initialization::Logarithm`].
const STEPS: usize = 10;

/// Random weights: uniform with variance 1 / inputs (LeCun et al. 1998), biases uniform in
/// ±1 so that the units' thresholds spread over the standardised inputs.
pub(crate) fn random_weights(cell: &Cell, shape: &Shape, start: u64) -> Vec<f64> {
    let mut w = Vec::with_capacity(shape.weights());
    for layer in shape.sizes.windows(2) {
        let range = (3.0 / layer[0].max(1) as f64).sqrt();
        for _ in 0..layer[1] {
            for input in 0..=layer[0] {
                let u = 2.0 * cell.stream.f64(start, w.len() as u32) - 1.0;
                w.push(if input == 0 { u } else { range * u });
            }
        }
    }
    w
}

impl Initialization {
    /// Turns random weights into what the first phase starts from; `problem` is on the first `rows`
    /// training rows, α as in its cost.
    pub fn apply(
        self,
        cell: &Cell,
        shape: &Shape,
        problem: &mut NetProblem<impl Rows>,
        rows: usize,
        alpha: f64,
        w: &mut [f64],
    ) {
        if self == Initialization::Fitted {
            return;
        }
        // Where there is no answer the output layer stays at zero: the mean, a valid start.
        w[problem.output_layer()].fill(0.0);
        if self == Initialization::Mean {
            problem.project(w, alpha);
            return;
        }
        let (rows, floor) = (cell.train.first(rows), cell.floor);
        let rows = Logarithms { rows, floor };
        let residuals = problem.residuals() as usize;
        let mut start = NetProblem::new(shape, rows, residuals, Loss::Absolute)
            .precision(cell.config.precision);
        start.project(w, alpha);
        let mut solver = Solver::new(w.len(), cell.config.lm);
        for _ in 0..STEPS {
            if solver.step(&mut start, w, alpha).is_err() {
                break;
            }
        }
    }
}
