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

use crate::blocks::Normal;
use crate::linalg::{Cholesky, Indefinite};

/// A new α and the effective parameters behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Weight decay.
    pub alpha: f64,
    /// γ, between 0 and the number of weights.
    pub gamma: f64,
}

/// One update from the normal equations at w, D(w) = `data` over `residuals` values, κ = `overcount`. The trace
/// fails where JᵀWJ + α I is not positive definite: α then stays.
pub fn update(
    factor: &mut Cholesky,
    normal: &Normal,
    alpha: f64,
    w: &[f64],
    data: f64,
    residuals: f64,
    overcount: f64,
) -> Result<Evidence, Indefinite> {
    let n = normal.n;
    factor.factor(&normal.matrix, &vec![alpha; n])?;
    let inverse = factor.inverse()?;
    let trace: f64 = (0..n).map(|i| inverse[i * n + i]).sum();
    let gamma = (n as f64 - alpha * trace).clamp(0.0, n as f64);
    let squared: f64 = w.iter().map(|w| w * w).sum();
    let free = (residuals - overcount * gamma).max(1.0);
    let alpha = overcount * gamma / squared.max(f64::MIN_POSITIVE) * data / free;
    Ok(Evidence { alpha, gamma })
}
