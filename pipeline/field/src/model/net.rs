//! Fully connected nets with tanh hidden layers and a linear output layer.

/// Shape of a net: inputs, hidden layers, 3 outputs; for example `[12, 20, 10, 3]`.
///
/// Weights are one flat row, layer by layer; within a layer one output unit after another,
/// each its bias first and then one weight an input:
/// `w[layer][j] = [w_j0, w_j1, ..., w_jn]` (Ren et al. 2013, eq. 5).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Units a layer, the inputs first.
    pub sizes: Vec<usize>,
}

impl Shape {
    /// How many weights, biases included.
    pub fn weights(&self) -> usize {
        self.sizes.windows(2).map(|w| (w[0] + 1) * w[1]).sum()
    }

    /// Offset of each layer's first weight.
    pub fn offsets(&self) -> Vec<usize> {
        let mut at = 0;
        self.sizes
            .windows(2)
            .map(|w| {
                let start = at;
                at += (w[0] + 1) * w[1];
                start
            })
            .collect()
    }
}

/// The net at one scaled input, in f64 with the standard `tanh`: what others are tested against.
pub fn evaluate(shape: &Shape, weights: &[f64], input: &[f64]) -> Vec<f64> {
    let layers = shape.sizes.len() - 1;
    let mut x = input.to_vec();
    for (layer, start) in shape.offsets().into_iter().enumerate() {
        let (n_in, n_out) = (shape.sizes[layer], shape.sizes[layer + 1]);
        x = (0..n_out)
            .map(|j| {
                let w = &weights[start + j * (n_in + 1)..][..n_in + 1];
                let z = w[0] + w[1..].iter().zip(&x).map(|(w, x)| w * x).sum::<f64>();
                if layer + 1 < layers { z.tanh() } else { z }
            })
            .collect();
    }
    x
}
