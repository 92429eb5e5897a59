//! Any residuals with a dense Jacobian as a [`Problem`].

use crate::problem::{NormalEquations, Problem};
use crate::vector::{add, dot};

/// m residuals of n parameters.
pub trait Residuals {
    /// n.
    fn parameters(&self) -> usize;
    /// m.
    fn residuals(&self) -> usize;
    /// r(w), m values.
    fn evaluate(&self, w: &[f64], r: &mut [f64]);
    /// ∂r/∂w, row-major `[m, n]`.
    fn jacobian(&self, w: &[f64], j: &mut [f64]);
}

/// [`Residuals`] as a sum of squares with unit weights.
pub struct Dense<R> {
    residuals: R,
    r: Vec<f64>,
    j: Vec<f64>,
}

impl<R: Residuals> Dense<R> {
    /// Room for the residuals and their Jacobian.
    pub fn new(residuals: R) -> Dense<R> {
        let (m, n) = (residuals.residuals(), residuals.parameters());
        Dense {
            r: vec![0.0; m],
            j: vec![0.0; m * n],
            residuals,
        }
    }

    /// The Jacobian and the residuals at `w`; Jᵀr into `gradient`, the cost returned.
    fn fill(&mut self, w: &[f64], gradient: &mut [f64]) -> f64 {
        self.residuals.jacobian(w, &mut self.j);
        let cost = self.cost(w);
        gradient.fill(0.0);
        for (row, r) in self.j.chunks_exact(w.len().max(1)).zip(&self.r) {
            add(gradient, *r, row);
        }
        cost
    }
}

/// Step of the difference that the second derivative is taken from, as a share of v; Transtrum
/// and Sethna 2012 use 0.1.
const CURVATURE_STEP: f64 = 0.1;

impl<R: Residuals> Problem for Dense<R> {
    fn cost(&mut self, w: &[f64]) -> f64 {
        self.residuals.evaluate(w, &mut self.r);
        self.r.iter().map(|r| r * r).sum()
    }

    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64 {
        let n = w.len();
        let cost = self.fill(w, &mut normal.gradient);
        normal.matrix.fill(0.0);
        for row in self.j.chunks_exact(n.max(1)) {
            for (x, to) in row.iter().zip(normal.matrix.chunks_exact_mut(n.max(1))) {
                add(to, *x, row);
            }
        }
        cost
    }

    fn gradient(&mut self, w: &[f64], out: &mut [f64]) -> Option<f64> {
        Some(self.fill(w, out))
    }

    fn product(&mut self, v: &[f64], out: &mut [f64]) -> bool {
        out.fill(0.0);
        for row in self.j.chunks_exact(v.len().max(1)) {
            add(out, dot(row, v), row);
        }
        true
    }

    /// r'' ≈ 2/h ((r(w + h v) − r(w)) / h − J v), J as last linearised.
    fn curvature(&mut self, w: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        let h = CURVATURE_STEP;
        let moved: Vec<f64> = w.iter().zip(v).map(|(w, v)| w + h * v).collect();
        let mut ahead = vec![0.0; self.r.len()];
        self.residuals.evaluate(&moved, &mut ahead);
        self.residuals.evaluate(w, &mut self.r);
        out.fill(0.0);
        let rows = self.j.chunks_exact(v.len().max(1));
        for ((row, ahead), r) in rows.zip(&ahead).zip(&self.r) {
            let second = 2.0 / h * ((ahead - r) / h - dot(row, v));
            add(out, second, row);
        }
        out.iter().all(|o| o.is_finite())
    }
}
