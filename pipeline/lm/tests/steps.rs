//! Damping at its end, and steps that share a matrix.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rrf_lm::{Dense, LmConfig, NormalEquations, Problem, Residuals, Solver, Termination};

/// A problem whose cost rises whichever way one steps: its gradient lies.
struct Lying;

impl Problem for Lying {
    fn cost(&mut self, w: &[f64]) -> f64 {
        1.0 + w[0].abs()
    }

    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64 {
        normal.matrix[0] = 1.0;
        normal.gradient[0] = 1.0;
        1.0 + w[0].abs()
    }
}

/// The damping is raised to its maximum, then the fit says so and leaves the weights alone.
#[test]
fn damping_at_its_maximum() {
    let config = LmConfig {
        step: 0.0,
        ..LmConfig::default()
    };
    let mut w = [0.0];
    let mut lm = Solver::new(1, config);
    assert_eq!(lm.step(&mut Lying, &mut w, 0.0), Err(Termination::Damping));
    assert!(lm.damping() > config.damping_max && lm.damping().is_finite());
    assert_eq!(w, [0.0]);
}

/// Σ_k c_k tanh(a_k + b_k x) on 60 points, against a function that it cannot follow exactly.
struct Waves;

const UNITS: usize = 4;
const POINTS: usize = 60;

fn point(i: usize) -> f64 {
    4.0 * i as f64 / POINTS as f64 - 2.0
}

impl Residuals for Waves {
    fn parameters(&self) -> usize {
        3 * UNITS
    }

    fn residuals(&self) -> usize {
        POINTS
    }

    fn evaluate(&self, w: &[f64], r: &mut [f64]) {
        for (i, r) in r.iter_mut().enumerate() {
            let x = point(i);
            let units = w.chunks_exact(3).map(|w| w[2] * (w[0] + w[1] * x).tanh());
            *r = units.sum::<f64>() - (3.0 * x).sin() - 0.3 * (7.0 * x).cos();
        }
    }

    fn jacobian(&self, w: &[f64], j: &mut [f64]) {
        for (i, row) in j.chunks_exact_mut(3 * UNITS).enumerate() {
            let x = point(i);
            for (w, row) in w.chunks_exact(3).zip(row.chunks_exact_mut(3)) {
                let h = (w[0] + w[1] * x).tanh();
                let slope = w[2] * (1.0 - h * h);
                row.copy_from_slice(&[slope, slope * x, h]);
            }
        }
    }
}

/// F after each step, and the parameters at the end.
fn descend(reuse: usize, inner: usize, steps: usize, alpha: f64) -> (Vec<f64>, Vec<f64>) {
    let mut w: Vec<f64> = (0..3 * UNITS).map(|i| (1.7 * i as f64).sin()).collect();
    let config = LmConfig {
        reuse,
        inner,
        ..LmConfig::default()
    };
    let (mut problem, mut solver) = (Dense::new(Waves), Solver::new(w.len(), config));
    let costs = (0..steps)
        .map(|_| solver.step(&mut problem, &mut w, alpha).unwrap().after)
        .collect();
    (costs, w)
}

/// Enough iterations leave nothing of the residual.
#[test]
fn enough_iterations_make_the_full_step() {
    for alpha in [1.0, 10.0] {
        let ((_, full), (_, between)) = (descend(1, 0, 2, alpha), descend(2, 200, 2, alpha));
        let squared = |w: &mut dyn Iterator<Item = f64>| w.map(|w| w * w).sum::<f64>();
        let apart = squared(&mut full.iter().zip(&between).map(|(a, b)| a - b));
        assert!(apart < 1e-12 * squared(&mut full.iter().copied()));
    }
}

/// Each step lowers F, and the same bits come out again.
#[test]
fn few_iterations_lower_the_cost() {
    let (costs, w) = descend(6, 3, 40, 1e-3);
    assert!(costs.is_sorted_by(|a, b| a > b));
    let (plain, _) = descend(1, 0, 40, 1e-3);
    assert!(costs[39] < 1.05 * plain[39], "{} {}", costs[39], plain[39]);
    assert_eq!(descend(6, 3, 40, 1e-3).1, w);
}
