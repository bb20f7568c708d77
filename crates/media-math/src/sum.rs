//! Sums that do not lose what the terms hold.

use crate::Real;

/// A running sum with its rounding error carried along (Neumaier's variant of Kahan's).
///
/// For terms of one sign it is exact to about one rounding whatever their number. Terms that cancel keep the error
/// of their own rounding: see [`signed_airlight`](crate::signed_airlight).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CompensatedSum<T> {
    sum: T,
    lost: T,
}

impl<T: Real> CompensatedSum<T> {
    /// An empty sum.
    pub fn new() -> Self {
        Self { sum: T::zero(), lost: T::zero() }
    }

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, term: T) {
        let sum = self.sum + term;
        self.lost = self.lost
            + if self.sum.abs() >= term.abs() { (self.sum - sum) + term } else { (term - sum) + self.sum };
        self.sum = sum;
    }

    /// The sum of what was added.
    pub fn total(&self) -> T {
        self.sum + self.lost
    }
}

impl<T: Real> Extend<T> for CompensatedSum<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, terms: I) {
        terms.into_iter().for_each(|term| self.add(term));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_plain_sum_loses_is_kept() {
        let mut sum = CompensatedSum::<f32>::new();
        sum.add(1e8);
        sum.extend([1.0; 100]);
        sum.add(-1e8);
        assert_eq!(sum.total(), 100.0);
        assert_ne!((0..100).fold(1e8_f32, |s, _| s + 1.0) - 1e8, 100.0);
    }
}
