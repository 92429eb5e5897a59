//! The arithmetic of formulas.

use std::ops::{Add, Mul, Sub};

/// What formulas compute with: numbers, nodes of a graph, sets of what is read.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f32, Output = Self>
{
    /// Square root.
    fn sqrt(self) -> Self;

    /// 1 / x where x is above 0, otherwise 0.
    fn reciprocal(self) -> Self;
}

impl Number for f32 {
    #[inline(always)]
    fn sqrt(self) -> f32 {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn reciprocal(self) -> f32 {
        if self > 0.0 { 1.0 / self } else { 0.0 }
    }
}

/// [`Number::sqrt`], as formulas write it.
#[inline(always)]
pub(super) fn sqrt<T: Number>(x: T) -> T {
    x.sqrt()
}

/// [`Number::reciprocal`], as formulas write it.
#[inline(always)]
pub(super) fn reciprocal<T: Number>(x: T) -> T {
    x.reciprocal()
}
