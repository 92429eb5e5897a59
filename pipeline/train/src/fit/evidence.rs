//! Weight decay by the evidence (MacKay 1992, *A practical Bayesian framework for
//! backpropagation networks*; Foresee, Hagan 1997 with Levenberg-Marquardt).
//!
//! With residual variance β⁻¹ and weight variance (αβ)⁻¹ the evidence is largest where
//!
//! ```text
//!   γ = n − α tr (JᵀWJ + α I)⁻¹       effective parameters, from the undamped Hessian
//!   α = γ / ‖w‖² · D / (N − γ)        N residuals
//! ```
//!
//! iterated along with the steps. α here multiplies ‖w‖² beside D, so it is MacKay's α / β.
//!
//! Where the channels share their noise, D counts it κ times over (κ up to 3). The likelihood is
//! then exp(−D / 2κσ²) with N σ² / κ worth of independent residuals: α = κ γ / ‖w‖² · D / (N − κγ).

/// α that the evidence asks for at w, of γ effective parameters, D(w) = `data` over `residuals`
/// values, κ = `overcount`.
pub(crate) fn decay(gamma: f64, w: &[f64], data: f64, residuals: f64, overcount: f64) -> f64 {
    let squared: f64 = w.iter().map(|w| w * w).sum();
    let free = (residuals - overcount * gamma).max(1.0);
    overcount * gamma / squared.max(f64::MIN_POSITIVE) * data / free
}
