//! One value or three: the colour channels that a quantity has.

use crate::Real;
use core::fmt::Debug;

/// A scalar or an RGB triple; every airlight function is written once for both.
pub trait Spectrum<T: Real>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The same value in every channel.
    fn splat(value: T) -> Self;
    /// Applies `f` to every channel.
    fn map(self, f: impl FnMut(T) -> T) -> Self;
    /// Applies `f` to the channels of both operands pairwise.
    fn zip(self, other: Self, f: impl FnMut(T, T) -> T) -> Self;
    /// Folds the channels in order.
    fn fold<A>(self, init: A, f: impl FnMut(A, T) -> A) -> A;

    /// Sum by channel.
    #[must_use]
    fn plus(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    /// Product by channel.
    #[must_use]
    fn times(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    /// Product with a scalar.
    #[must_use]
    fn scale(self, factor: T) -> Self {
        self.map(|a| a * factor)
    }
    /// Whether `f` holds for every channel.
    fn all(self, mut f: impl FnMut(T) -> bool) -> bool {
        self.fold(true, |so_far, a| so_far && f(a))
    }
    /// The largest channel.
    fn max_channel(self) -> T {
        self.fold(T::neg_infinity(), T::max)
    }
    /// The smallest channel.
    fn min_channel(self) -> T {
        self.fold(T::infinity(), T::min)
    }
    /// Whether every channel holds the same value.
    fn is_uniform(self) -> bool {
        self.min_channel() == self.max_channel()
    }
}

impl<T: Real> Spectrum<T> for T {
    #[inline(always)]
    fn splat(value: T) -> Self {
        value
    }
    #[inline(always)]
    fn map(self, mut f: impl FnMut(T) -> T) -> Self {
        f(self)
    }
    #[inline(always)]
    fn zip(self, other: Self, mut f: impl FnMut(T, T) -> T) -> Self {
        f(self, other)
    }
    #[inline(always)]
    fn fold<A>(self, init: A, mut f: impl FnMut(A, T) -> A) -> A {
        f(init, self)
    }
}

impl<T: Real> Spectrum<T> for [T; 3] {
    #[inline(always)]
    fn splat(value: T) -> Self {
        [value; 3]
    }
    #[inline(always)]
    fn map(self, f: impl FnMut(T) -> T) -> Self {
        <[T; 3]>::map(self, f)
    }
    #[inline(always)]
    fn zip(self, other: Self, mut f: impl FnMut(T, T) -> T) -> Self {
        [f(self[0], other[0]), f(self[1], other[1]), f(self[2], other[2])]
    }
    #[inline(always)]
    fn fold<A>(self, init: A, f: impl FnMut(A, T) -> A) -> A {
        self.into_iter().fold(init, f)
    }
}
