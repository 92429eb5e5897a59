//! What a baseline's solution is handed on as.

/// A model and what regularised it.
pub(super) struct Solved {
    pub weights: Vec<f32>,
    /// Layers as the weights table has them.
    pub layers: Vec<usize>,
    /// Share of the mean diagonal of the normal equations that was added to it.
    pub ridge: f64,
}
