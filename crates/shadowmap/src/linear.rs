//! Linear functions of the distance along a view ray, and where they change sign.

use std::ops::{Add, Mul, Sub};

use scene::Interval;

/// f(x) = `offset` + `slope`·x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Linear {
    pub(crate) offset: f64,
    pub(crate) slope: f64,
}

impl Linear {
    pub(crate) const fn new(offset: f64, slope: f64) -> Self {
        Self { offset, slope }
    }

    /// A function without slope.
    pub(crate) const fn constant(offset: f64) -> Self {
        Self::new(offset, 0.0)
    }

    /// Value at `x`, which may be infinite.
    #[inline]
    pub(crate) fn at(self, x: f64) -> f64 {
        if self.slope == 0.0 { self.offset } else { self.offset + self.slope * x }
    }

    /// Where the sign changes. f and −f have the very same root, so that regions on both sides of a plane meet.
    #[inline]
    pub(crate) fn root(self) -> f64 {
        -self.offset / self.slope
    }

    /// The part of `span` where f ≥ 0.
    #[inline]
    pub(crate) fn nonnegative(self, span: Interval) -> Interval {
        if self.slope > 0.0 {
            Interval::new(span.start.max(self.root()), span.end)
        } else if self.slope < 0.0 {
            Interval::new(span.start, span.end.min(self.root()))
        } else if self.offset >= 0.0 {
            span
        } else {
            Interval::new(span.start, span.start)
        }
    }

    /// Splits `span` at the root: where, and whether f ≥ 0 before and after it.
    #[inline]
    pub(crate) fn split(self, span: Interval) -> (f64, bool, bool) {
        if self.slope == 0.0 {
            let side = self.offset >= 0.0;
            return (span.end, side, side);
        }
        let root = self.root();
        // not `clamp`, which refuses NaN bounds by a panic
        (root.max(span.start).min(span.end), self.slope < 0.0, self.slope > 0.0)
    }
}

impl Add for Linear {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self::new(self.offset + o.offset, self.slope + o.slope)
    }
}

impl Sub for Linear {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self::new(self.offset - o.offset, self.slope - o.slope)
    }
}

impl Mul<f64> for Linear {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.offset * factor, self.slope * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_by_hand() {
        let all = Interval::new(0.0, f64::INFINITY);
        assert_eq!(Linear::new(-2.0, 1.0).nonnegative(all), Interval::new(2.0, f64::INFINITY));
        assert_eq!(Linear::new(2.0, -1.0).nonnegative(all), Interval::new(0.0, 2.0));
        assert_eq!(Linear::constant(0.0).nonnegative(all), all);
        assert!(Linear::constant(-1.0).nonnegative(all).is_empty());
        assert_eq!(Linear::new(-2.0, 1.0).split(all), (2.0, false, true));
        assert_eq!(Linear::new(-2.0, -1.0).split(all), (0.0, true, false));
        assert_eq!(Linear::constant(1.0).split(all), (f64::INFINITY, true, true));
        assert_eq!(Linear::constant(3.0).at(f64::INFINITY), 3.0);
    }
}
