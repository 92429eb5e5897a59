//! Levenberg-Marquardt for nonlinear least squares with weight decay.
//!
//! Minimises F(w) = D(w) + α‖w‖², D(w) = Σ s² r(w)², for residuals r of any model. With A = JᵀWJ,
//! W = diag s², and g = JᵀWr + αw a step solves
//!
//! ```text
//!   (A + αI + μS) δ = −g
//! ```
//!
//! and the model promises that F falls by δᵀ(μSδ − g). The ratio of the actual to the promised
//! fall moves the damping μ.
//!
//! - [`Problem`] is what is minimised; [`Dense`] makes one of residuals and their Jacobian.
//! - [`Solver`] takes one step after another, [`minimise`] all of them.
//! - [`LmConfig`] says how to step, [`Scaling`] what S is, [`Termination`] why the steps ended.
//! - [`Cholesky`] is the linear algebra, the only file that knows LAPACK.
//!
//! ```
//! use rrf_lm::{Dense, LmConfig, Residuals, minimise};
//!
//! /// NIST StRD, Misra1a: y = b₁ (1 − exp(−b₂ x)).
//! struct Misra1a;
//!
//! const X: [f64; 14] = [
//!     77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0,
//! ];
//! const Y: [f64; 14] = [
//!     10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78,
//! ];
//!
//! impl Residuals for Misra1a {
//!     fn parameters(&self) -> usize {
//!         2
//!     }
//!
//!     fn residuals(&self) -> usize {
//!         X.len()
//!     }
//!
//!     fn evaluate(&self, b: &[f64], r: &mut [f64]) {
//!         for ((r, x), y) in r.iter_mut().zip(X).zip(Y) {
//!             *r = b[0] * (1.0 - (-b[1] * x).exp()) - y;
//!         }
//!     }
//!
//!     fn jacobian(&self, b: &[f64], j: &mut [f64]) {
//!         for (row, x) in j.chunks_exact_mut(2).zip(X) {
//!             let e = (-b[1] * x).exp();
//!             row.copy_from_slice(&[1.0 - e, b[0] * x * e]);
//!         }
//!     }
//! }
//!
//! let mut b = [500.0, 0.0001];
//! let found = minimise(&mut Dense::new(Misra1a), &mut b, 0.0, LmConfig::exact(), 1000);
//! // certified: 238.94212918, 5.5015643181e-4, sum of squares 0.12455138894
//! assert!((b[0] / 238.94212918 - 1.0).abs() < 1e-9);
//! assert!((b[1] / 5.5015643181e-4 - 1.0).abs() < 1e-9);
//! assert!((found.cost / 0.12455138894 - 1.0).abs() < 1e-9);
//! ```
//!
//! # Sources
//!
//! Levenberg 1944; Marquardt 1963; Moré 1978 (scaling); Hagan, Menhaj 1994 (for nets); Nielsen
//! 1999, *Damping parameter in Marquardt's method*, and Madsen, Nielsen, Tingleff 2004 (damping by
//! the gain ratio); Morales, Nocedal 2000 (preconditioners kept from earlier steps); Transtrum,
//! Sethna 2012 (geodesic acceleration). NIST's certified problems and those of Moré, Garbow,
//! Hillstrom 1981 are its tests.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod blas;
mod config;
mod conjugate;
mod damping;
mod dense;
mod linalg;
mod minimise;
mod problem;
mod solver;
mod termination;
mod vector;

pub use blas::{fix_kernels, linear_algebra, one_thread};
pub use config::{LmConfig, Scaling};
pub use dense::{Dense, Residuals};
pub use linalg::{Cholesky, Indefinite};
pub use minimise::{Minimum, minimise};
pub use problem::{NormalEquations, Problem};
pub use solver::{Solver, Step};
pub use termination::Termination;
