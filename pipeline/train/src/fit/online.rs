//! Training that sees its rows once, batch after batch.
//!
//! *Online* steps on each batch's own cost, as Ren et al. 2013 describe it: nothing holds what
//! earlier batches taught. *Recursive* keeps their accumulated JᵀWJ: with w₀ the weights where
//! the last batch left them and M = Σ JᵀWJ of all batches so far, each batch minimises
//!
//! ```text
//!   F(w) = D_batch(w) + (w − w₀)ᵀ M (w − w₀)
//! ```
//!
//! the batch's cost and the quadratic that the past costs look like from w₀ (the iterated
//! extended Kalman filter: Bell, Cathey 1993; for nets Puskorius, Feldkamp 1994).

use super::evaluator::Evaluator;
use super::initialization::random_weights;
use crate::cell::Cell;
use crate::config::{Batches, Schedule};
use crate::net::problem::NetProblem;
use crate::report::{Course, HistoryRow, Net};
use rrf_field::net::Shape;
use rrf_lm::{NormalEquations, Problem, Solver, Termination};

/// A problem with a quadratic penalty on leaving a point.
struct Remembered<P> {
    /// The batch's own cost.
    batch: P,
    /// M, and the point w₀ that it is about.
    memory: Vec<f64>,
    /// w₀.
    origin: Vec<f64>,
}

impl<P> Remembered<P> {
    /// M (w − w₀) and (w − w₀)ᵀ M (w − w₀).
    fn pull(&self, w: &[f64]) -> (Vec<f64>, f64) {
        let moved: Vec<f64> = w.iter().zip(&self.origin).map(|(w, o)| w - o).collect();
        let force: Vec<f64> = (self.memory.chunks_exact(w.len().max(1)))
            .map(|row| row.iter().zip(&moved).map(|(m, d)| m * d).sum())
            .collect();
        let cost = force.iter().zip(&moved).map(|(f, d)| f * d).sum();
        (force, cost)
    }
}

impl<P: Problem> Problem for Remembered<P> {
    fn cost(&mut self, w: &[f64]) -> f64 {
        self.batch.cost(w) + self.pull(w).1
    }

    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64 {
        let cost = self.batch.linearise(w, normal);
        let (force, pull) = self.pull(w);
        for (a, m) in normal.matrix.iter_mut().zip(&self.memory) {
            *a += m;
        }
        for (g, f) in normal.gradient.iter_mut().zip(&force) {
            *g += f;
        }
        cost + pull
    }
}

/// Goes through the batches.
pub(crate) fn train(cell: &Cell, shape: Shape, batches: Batches) -> (Net, Course) {
    let remembers = matches!(cell.config.mode, Schedule::Recursive(_));
    let mut w = random_weights(cell, &shape, 0);
    let n = w.len();
    // The output layer starts at zero, the mean: an answer should no batch give a better one.
    let output = shape.offsets().last().copied().unwrap_or(0);
    w[output..].fill(0.0);
    let mut evaluator = Evaluator::choosing(cell, &shape, 1.0);
    let mut solver = Solver::new(n, cell.config.lm);
    let mut memory = vec![0.0; n * n];
    let mut best = (f64::INFINITY, w.clone());
    let (mut history, mut share) = (Vec::new(), 1.0);
    let rows = cell.train.len();
    for first in (0..rows).step_by(batches.rows) {
        if cell.is_halted() {
            break;
        }
        let part = cell.train.part(first..first + batches.rows);
        let residuals = part.residuals().max(1);
        let alpha = cell.config.decay.start() * residuals as f64;
        let mut problem = Remembered {
            batch: NetProblem::new(&shape, part, residuals, cell.loss)
                .exponential(cell.config.exponential),
            memory,
            origin: w.clone(),
        };
        problem.batch.set_target_share(share);
        let mut last = None;
        for _ in 0..batches.steps {
            match solver.step(&mut problem, &mut w, alpha) {
                Ok(step) => last = Some(step),
                Err(_) => break,
            }
        }
        share = problem.batch.target_share();
        memory = problem.memory;
        if remembers {
            // The matrix of the last linearisation holds M + JᵀWJ of this batch.
            memory.clone_from(&solver.normal_equations().matrix);
        }
        solver.settle();
        evaluator.renew(&w, share);
        let error = evaluator.error(&w).square;
        if error < best.0 {
            best = (error, w.clone());
        }
        history.push(HistoryRow {
            residuals,
            cost: last.map_or(f64::NAN, |step| step.data / residuals as f64),
            validation: error,
            damping: solver.damping(),
            gain: last.map_or(f64::NAN, |step| step.gain),
        });
    }
    let net = Net {
        shape,
        weights: best.1,
        error: best.0,
        alpha: cell.config.decay.start(),
    };
    let course = Course {
        end: Termination::Iterations.into(),
        damping: solver.damping(),
        alpha: net.alpha,
        effective_parameters: n as f64,
        history,
    };
    (net, course)
}
