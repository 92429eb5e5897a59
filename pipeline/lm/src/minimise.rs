//! From a start to a minimum.

use crate::config::LmConfig;
use crate::linalg::Cholesky;
use crate::problem::{NormalEquations, Problem};
use crate::solver::Solver;
use crate::termination::Termination;
use crate::vector::{dot, negated, squared, sum};

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum {
    /// Why.
    pub termination: Termination,
    /// Accepted steps.
    pub iterations: usize,
    /// F at the end.
    pub cost: f64,
}

/// Steps from `w` until a stop, at most `most`, then polishes: as near to a minimum of F as
/// f64 allows.
pub fn minimise(
    problem: &mut impl Problem,
    w: &mut [f64],
    alpha: f64,
    config: LmConfig,
    most: usize,
) -> Minimum {
    let mut solver = Solver::new(w.len(), config);
    let (mut termination, mut iterations) = (Termination::Iterations, 0);
    while iterations < most {
        match solver.step(problem, w, alpha) {
            Ok(step) => {
                iterations += 1;
                if step.before - step.after <= config.cost * step.before {
                    termination = Termination::Cost;
                    break;
                }
            }
            Err(reason) => {
                termination = reason;
                break;
            }
        }
    }
    iterations += polish(problem, w, alpha);
    Minimum {
        termination,
        iterations,
        cost: problem.cost(w) + alpha * squared(w),
    }
}

/// Most Gauss-Newton steps of a polish.
const POLISH: usize = 30;

/// Gauss-Newton steps for as long as the fall that the model promises, δᵀA δ, gets smaller.
///
/// Near a minimum F is flat: differences below 1e-16 F cannot be seen, although they stand
/// for relative changes of 1e-8 in w. The gradient still shows them. Returns the steps kept.
fn polish(problem: &mut impl Problem, w: &mut [f64], alpha: f64) -> usize {
    let n = w.len();
    let (mut normal, mut factor) = (NormalEquations::zeros(n), Cholesky::default());
    let mut promised = f64::INFINITY;
    for kept in 0..POLISH {
        let cost = problem.linearise(w, &mut normal) + alpha * squared(w);
        let g: Vec<f64> = (normal.gradient.iter().zip(w.iter()))
            .map(|(g, w)| g + alpha * w)
            .collect();
        let mut delta = negated(&g);
        // As little damping as keeps a singular matrix positive definite.
        let added: Vec<f64> = (0..n)
            .map(|i| alpha + 4.0 * f64::EPSILON * normal.diagonal(i))
            .collect();
        let solved =
            (factor.factor(&normal.matrix, &added)).and_then(|()| factor.solve(&mut delta));
        let fall = -dot(&delta, &g);
        let trial = sum(w, &delta);
        let flat = problem.cost(&trial) + alpha * squared(&trial) <= cost * (1.0 + 1e-9);
        if solved.is_err() || !flat || fall.is_nan() || fall >= 0.5 * promised {
            return kept;
        }
        w.copy_from_slice(&trial);
        promised = fall;
    }
    POLISH
}
