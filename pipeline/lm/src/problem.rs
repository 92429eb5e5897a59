//! What is minimised.

/// Gauss-Newton normal equations: matrix JᵀWJ (symmetric, full, row-major) and vector JᵀWr.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NormalEquations {
    /// How many parameters.
    pub n: usize,
    /// `n * n` entries.
    pub matrix: Vec<f64>,
    /// `n` entries.
    pub gradient: Vec<f64>,
}

impl NormalEquations {
    /// Zeros for `n` parameters.
    pub fn zeros(n: usize) -> NormalEquations {
        NormalEquations {
            n,
            matrix: vec![0.0; n * n],
            gradient: vec![0.0; n],
        }
    }

    /// An entry of the matrix's diagonal.
    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        self.matrix[i * self.n + i]
    }
}

/// A sum of squares D(w) = Σ s² r(w)², with derivatives.
pub trait Problem {
    /// D(w) under the weights s that the last [`Problem::linearise`] fixed.
    fn cost(&mut self, w: &[f64]) -> f64;

    /// Fixes the weights s at w where they depend on it, fills JᵀWJ and JᵀWr, returns D(w).
    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64;

    /// [`Problem::linearise`] without the matrix: fills JᵀWr alone, returns D(w), and prepares
    /// [`Problem::product`]; none where not supported.
    fn gradient(&mut self, _w: &[f64], _out: &mut [f64]) -> Option<f64> {
        None
    }

    /// JᵀWJ v at the weights of the last [`Problem::gradient`] into `out`; false where not
    /// supported.
    fn product(&mut self, _v: &[f64], _out: &mut [f64]) -> bool {
        false
    }

    /// JᵀW r'' into `out`, r'' the second derivative of r along v; false where not supported.
    fn curvature(&mut self, _w: &[f64], _v: &[f64], _out: &mut [f64]) -> bool {
        false
    }
}
