//! Sums over plain vectors, in their order.

/// Σ a b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Σ w².
pub(crate) fn squared(w: &[f64]) -> f64 {
    w.iter().map(|w| w * w).sum()
}

/// Largest absolute value.
pub(crate) fn largest(w: &[f64]) -> f64 {
    w.iter().fold(0.0, |m, w| m.max(w.abs()))
}

/// a ← a + t b.
pub(crate) fn add(a: &mut [f64], t: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += t * b;
    }
}

/// a + b.
pub(crate) fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// −a.
pub(crate) fn negated(a: &[f64]) -> Vec<f64> {
    a.iter().map(|a| -a).collect()
}
