//! The number type that laws are generic over.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number that may carry derivatives: `f64` or [`crate::Dual`].
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A constant.
    fn lift(value: f64) -> Self;
    /// The value without derivatives.
    fn re(self) -> f64;
    /// Whether all derivatives are zero.
    fn is_constant(self) -> bool;
    /// Square root; its derivative at zero is defined as zero.
    fn sqrt(self) -> Self;
    /// Natural exponential.
    fn exp(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Reciprocal.
    fn recip(self) -> Self;
    /// Function of several numbers by the chain rule: its value, computed in `f64`, and each argument with the partial
    /// derivative by it. For `f64` the derivatives are unused and the compiler removes their computation.
    fn chained<const K: usize>(value: f64, parts: [(Self, f64); K]) -> Self;

    /// [`Real::chained`] with the value zero: only the derivatives.
    #[inline(always)]
    fn slopes<const K: usize>(parts: [(Self, f64); K]) -> Self {
        Self::chained(0.0, parts)
    }
    /// Zero.
    fn zero() -> Self {
        Self::lift(0.0)
    }
    /// Square.
    fn squared(self) -> Self {
        self * self
    }
    /// The larger of two numbers, by value.
    fn max(self, other: Self) -> Self {
        if self.re() >= other.re() { self } else { other }
    }
}

impl Real for f64 {
    #[inline]
    fn lift(value: f64) -> Self {
        value
    }
    #[inline]
    fn re(self) -> f64 {
        self
    }
    #[inline]
    fn is_constant(self) -> bool {
        true
    }
    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    #[inline]
    fn recip(self) -> Self {
        f64::recip(self)
    }
    #[inline(always)]
    fn chained<const K: usize>(value: f64, _: [(Self, f64); K]) -> Self {
        value
    }
}
