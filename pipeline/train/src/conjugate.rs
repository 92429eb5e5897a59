//! Steps between two matrices: the damped system solved by conjugate gradients.
//!
//! (A + αI + μS) δ = −g at the present weights needs A only in products, each of which costs a
//! fifteenth of a step with the matrix (Hestenes, Stiefel 1952; in nets Martens 2010). The Cholesky
//! factor of the last matrix preconditions, together with the directions p and products Ap met
//! since, as limited-memory BFGS improves a first inverse (Morales, Nocedal 2000). A few iterations do:
//! what they leave, the residual ϱ = −g − (A + αI + μS) δ, is in the promised fall,
//! δᵀ(μSδ − g + ϱ).

use crate::levenberg::{Levenberg, Step, squared};
use crate::linalg::Cholesky;
use crate::lm::Problem;

/// What the last matrix leaves to the steps after it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recycled {
    /// Steps taken with the factor; 0 where there is none to use.
    steps: usize,
    /// What was added to the matrix's diagonal before it was factored.
    pub added: Vec<f64>,
    pairs: Vec<Pair>,
}

/// A direction p, (A + αI + μS) p, and 1 / pᵀ(A + αI + μS) p.
#[derive(Clone, Debug)]
struct Pair {
    p: Vec<f64>,
    product: Vec<f64>,
    inverse: f64,
}

/// Least factor of the damping after a step of this kind: too few iterations damp as well, so their
/// gain says little about what a full solution can do with less.
const FALL: f64 = 0.6;

impl Recycled {
    /// The factor may not be used again.
    pub fn forget(&mut self) {
        self.steps = 0;
    }

    /// There is a new factor, with which a step has been taken.
    pub fn begin(&mut self) {
        self.steps = 1;
        self.pairs.clear();
    }

    /// r ← M⁻¹ r, M near the present matrix.
    fn precondition(&self, factor: &Cholesky, r: &mut [f64]) -> Option<()> {
        let mut shares = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let share = pair.inverse * dot(&pair.p, r);
            add(r, -share, &pair.product);
            shares.push(share);
        }
        factor.solve(r).ok()?;
        for (pair, share) in self.pairs.iter().zip(shares.iter().rev()) {
            add(r, share - pair.inverse * dot(&pair.product, r), &pair.p);
        }
        Some(())
    }
}

impl Levenberg {
    /// A step from `w` without a new matrix; none where one is due, or where the step would not
    /// lower F.
    pub(crate) fn between(
        &mut self,
        problem: &mut impl Problem,
        w: &mut [f64],
        alpha: f64,
    ) -> Option<Step> {
        // Whatever goes wrong below calls for a new matrix.
        let steps = std::mem::take(&mut self.recycled.steps);
        if steps == 0 || steps >= self.config.reuse {
            return None;
        }
        let before = problem.gradient(w, &mut self.normal.gradient)? + alpha * squared(w);
        let g: Vec<f64> = (self.normal.gradient.iter().zip(w.iter()))
            .map(|(g, w)| g + alpha * w)
            .collect();
        let (delta, promised) = self.conjugate(problem, &g, alpha)?;
        let trial: Vec<f64> = w.iter().zip(&delta).map(|(w, d)| w + d).collect();
        let data = problem.cost(&trial);
        let after = data + alpha * squared(&trial);
        let gain = (before - after) / promised;
        if !(after.is_finite() && after < before && gain > 0.0) {
            self.raise();
            return None;
        }
        w.copy_from_slice(&trial);
        self.lower(gain, FALL);
        self.recycled.steps = steps + 1;
        Some(Step {
            before,
            after,
            data,
            gain,
            tries: 1,
        })
    }

    /// δ after a few iterations from 0, and the fall in F that the model promises.
    fn conjugate(
        &mut self,
        problem: &mut impl Problem,
        g: &[f64],
        alpha: f64,
    ) -> Option<(Vec<f64>, f64)> {
        let damping: Vec<f64> = self.scale.iter().map(|s| alpha + self.mu * s).collect();
        let mut residual: Vec<f64> = g.iter().map(|g| -g).collect();
        let mut delta = vec![0.0; g.len()];
        let mut z = residual.clone();
        self.recycled.precondition(&self.factor, &mut z)?;
        let mut p = z.clone();
        let mut size = dot(&residual, &z);
        let mut pairs = Vec::with_capacity(self.config.inner);
        for iteration in 1..=self.config.inner {
            let mut product = vec![0.0; g.len()];
            if !problem.product(&p, &mut product) {
                return None;
            }
            for ((product, p), d) in product.iter_mut().zip(&p).zip(&damping) {
                *product += d * p;
            }
            let inverse = 1.0 / dot(&p, &product);
            let length = size * inverse;
            // Negated: not a number is no length either.
            if !(length > 0.0 && length.is_finite()) {
                break;
            }
            add(&mut delta, length, &p);
            add(&mut residual, -length, &product);
            let last = p.clone();
            if iteration < self.config.inner {
                z.copy_from_slice(&residual);
                self.recycled.precondition(&self.factor, &mut z)?;
                let next = dot(&residual, &z);
                for (p, z) in p.iter_mut().zip(&z) {
                    *p = z + next / size * *p;
                }
                size = next;
            }
            pairs.push(Pair {
                p: last,
                product,
                inverse,
            });
        }
        // Only now: within one solution the preconditioner must not change.
        self.recycled.pairs.append(&mut pairs);
        let promised: f64 = (delta.iter().zip(g).zip(&self.scale).zip(&residual))
            .map(|(((d, g), s), r)| d * (self.mu * s * d - g + r))
            .sum();
        (promised > 0.0 && promised.is_finite()).then_some((delta, promised))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// a ← a + t b.
fn add(a: &mut [f64], t: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += t * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lm::LmConfig;
    use crate::made_up::{self, RandomRows};
    use crate::problem::{Loss, NetProblem};
    use rrf_field::net::Shape;

    /// Costs after each step, and the weights at the end.
    fn descend(reuse: usize, inner: usize, steps: usize, alpha: f64) -> (Vec<f64>, Vec<f64>) {
        let shape = Shape {
            sizes: vec![4, 6, 5, 3],
        };
        let rows = RandomRows { rows: 300, seed: 5 };
        let mut problem = NetProblem::new(&shape, &rows, 900, Loss::Absolute);
        let mut w = made_up::weights(&shape, 3, 0.8);
        let config = LmConfig {
            reuse,
            inner,
            ..LmConfig::default()
        };
        let mut lm = Levenberg::new(w.len(), config);
        let costs = (0..steps)
            .map(|_| lm.step(&mut problem, &mut w, alpha).unwrap().after)
            .collect();
        (costs, w)
    }

    /// Enough iterations leave nothing of the residual.
    #[test]
    fn enough_iterations_make_the_full_step() {
        for alpha in [1.0, 10.0] {
            let ((_, full), (_, between)) = (descend(1, 0, 2, alpha), descend(2, 200, 2, alpha));
            let apart: Vec<f64> = full.iter().zip(&between).map(|(a, b)| a - b).collect();
            assert!(squared(&apart) < 1e-12 * squared(&full));
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

    /// p, Ap and 1 / pᵀAp are met exactly: M⁻¹ A p = p.
    #[test]
    fn pairs_improve_the_preconditioner() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0];
        let mut factor = Cholesky::default();
        factor.factor(&[0.0; 9], &[1.0; 3]).unwrap();
        let p = vec![1.0, -2.0, 0.5];
        let product: Vec<f64> = matrix.chunks(3).map(|row| dot(row, &p)).collect();
        let mut recycled = Recycled::default();
        recycled.pairs.push(Pair {
            inverse: 1.0 / dot(&p, &product),
            product: product.clone(),
            p: p.clone(),
        });
        let mut r = product;
        recycled.precondition(&factor, &mut r).unwrap();
        for (r, p) in r.iter().zip(&p) {
            assert!((r - p).abs() < 1e-12);
        }
    }
}
