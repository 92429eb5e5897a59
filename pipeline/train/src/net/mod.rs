//! A net and its Jacobian over tiles of rows.
//!
//! [`tile`] runs a net over 128 rows at a time, on a vectorised tanh ([`simd`]); [`blocks`] sums
//! JᵀWJ from tiles without ever forming J, on one matrix kernel (`gemm`); `tangent` multiplies
//! with J and Jᵀ, `curvature` tells second derivatives. [`problem`] makes a net and its relative
//! loss a problem of least squares.

pub mod blocks;
mod curvature;
mod factors;
mod gemm;
pub mod problem;
mod products;
pub mod simd;
mod tangent;
pub mod tile;

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;
