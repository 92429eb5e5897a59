//! Polynomials of the second degree.

/// How many terms there are of so many inputs; none where too many to be counted.
pub fn count(inputs: usize) -> Option<usize> {
    let products = inputs.checked_mul(inputs.checked_add(1)?)? / 2;
    products.checked_add(inputs)?.checked_add(1)
}

/// The terms of a row: 1, x_i, and x_i x_j for i ≤ j, i slowest.
pub fn terms(x: impl Iterator<Item = f64> + Clone, terms: &mut Vec<f64>) {
    terms.clear();
    terms.push(1.0);
    terms.extend(x.clone());
    for (i, first) in x.clone().enumerate() {
        terms.extend(x.clone().skip(i).map(|second| first * second));
    }
}

/// The coefficients of three of them.
#[derive(Clone, Debug)]
pub struct Quadratic {
    weights: Vec<f64>,
}

impl Quadratic {
    /// Channel after channel.
    pub fn new(weights: &[f32]) -> Quadratic {
        Quadratic {
            weights: weights.iter().map(|&w| f64::from(w)).collect(),
        }
    }

    /// Their values at `x`.
    pub fn answer(&self, x: &[f32], work: &mut Vec<f64>) -> [f64; 3] {
        terms(x.iter().map(|&x| f64::from(x)), work);
        let mut channels = self.weights.chunks(work.len());
        std::array::from_fn(|_| {
            let weights = channels.next().unwrap_or_default();
            weights.iter().zip(&*work).map(|(w, x)| w * x).sum()
        })
    }
}
