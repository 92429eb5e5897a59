//! The damped system at a point whose matrix is not formed, by conjugate gradients.
//!
//! (A + αI + μS) δ = −g needs A only in products (Hestenes, Stiefel 1952; in nets Martens 2010).
//! The Cholesky factor of an earlier matrix preconditions, together with the directions p and
//! products Ap met since, as limited-memory BFGS improves a first inverse (Morales, Nocedal 2000).

use crate::linalg::Cholesky;
use crate::problem::Problem;
use crate::vector::{add, dot, negated};

/// M⁻¹ for an M near the present matrix.
#[derive(Clone, Debug, Default)]
pub(crate) struct Preconditioner {
    /// Factor of an earlier matrix.
    pub factor: Cholesky,
    pairs: Vec<Pair>,
}

/// A direction p, (A + αI + μS) p, and 1 / pᵀ(A + αI + μS) p.
#[derive(Clone, Debug)]
struct Pair {
    p: Vec<f64>,
    product: Vec<f64>,
    inverse: f64,
}

/// An approximate solution.
pub(crate) struct Solution {
    /// δ.
    pub delta: Vec<f64>,
    /// What is left: −g − (A + αI + μS) δ.
    pub residual: Vec<f64>,
}

impl Preconditioner {
    /// Forgets the directions: the factor is a new one.
    pub fn renew(&mut self) {
        self.pairs.clear();
    }

    /// r ← M⁻¹ r.
    fn apply(&self, r: &mut [f64]) -> Option<()> {
        let mut shares = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let share = pair.inverse * dot(&pair.p, r);
            add(r, -share, &pair.product);
            shares.push(share);
        }
        self.factor.solve(r).ok()?;
        for (pair, share) in self.pairs.iter().zip(shares.iter().rev()) {
            add(r, share - pair.inverse * dot(&pair.product, r), &pair.p);
        }
        Some(())
    }

    /// δ after `iterations` from 0, `added` being the diagonal αI + μS; none where the problem
    /// has no products.
    pub fn solve(
        &mut self,
        problem: &mut impl Problem,
        g: &[f64],
        added: &[f64],
        iterations: usize,
    ) -> Option<Solution> {
        let mut residual = negated(g);
        let mut delta = vec![0.0; g.len()];
        let mut z = residual.clone();
        self.apply(&mut z)?;
        let mut p = z.clone();
        let mut size = dot(&residual, &z);
        let mut pairs = Vec::with_capacity(iterations);
        for iteration in 1..=iterations {
            let mut product = vec![0.0; g.len()];
            if !problem.product(&p, &mut product) {
                return None;
            }
            for ((product, p), d) in product.iter_mut().zip(&p).zip(added) {
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
            if iteration < iterations {
                z.copy_from_slice(&residual);
                self.apply(&mut z)?;
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
        self.pairs.append(&mut pairs);
        Some(Solution { delta, residual })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// p, Ap and 1 / pᵀAp are met exactly: M⁻¹ A p = p.
    #[test]
    fn pairs_improve_the_preconditioner() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0];
        let p = vec![1.0, -2.0, 0.5];
        let product: Vec<f64> = matrix.chunks(3).map(|row| dot(row, &p)).collect();
        let mut preconditioner = Preconditioner::default();
        preconditioner.factor.factor(&[0.0; 9], &[1.0; 3]).unwrap();
        preconditioner.pairs.push(Pair {
            inverse: 1.0 / dot(&p, &product),
            product: product.clone(),
            p: p.clone(),
        });
        let mut r = product;
        preconditioner.apply(&mut r).unwrap();
        for (r, p) in r.iter().zip(&p) {
            assert!((r - p).abs() < 1e-12);
        }
    }
}
