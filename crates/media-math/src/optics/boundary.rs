//! Shadowed rays: airlight over lit intervals, and as a signed sum over shadow boundaries.

use super::airlight::airlight;
use super::foot::Foot;
use super::medium::HomogeneousMedium;
use super::phase::PhaseFunction;
use crate::{CompensatedSum, Real, Spectrum};

/// How a view ray crosses the surface of the lit volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crossing {
    /// From light into shadow: the airlight up to here counts, s = +1.
    LeavesLight,
    /// From shadow into light: the airlight up to here does not count, s = −1.
    EntersLight,
}

/// A crossing of the lit volume's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boundary<T> {
    /// Distance from the eye along the ray; units: m.
    pub distance: T,
    /// Which way the ray crosses.
    pub crossing: Crossing,
}

impl<T: Real> Boundary<T> {
    /// The two boundaries of a lit interval: the one where light begins and the one where it ends.
    pub fn of_interval(start: T, end: T) -> [Self; 2] {
        [
            Self { distance: start, crossing: Crossing::EntersLight },
            Self { distance: end, crossing: Crossing::LeavesLight },
        ]
    }

    /// s = +1 or −1.                                                                  (BSA10 Eq. 3)
    pub fn sign(&self) -> T {
        match self.crossing {
            Crossing::LeavesLight => T::one(),
            Crossing::EntersLight => -T::one(),
        }
    }
}

/// Airlight over sorted, disjoint lit intervals: a sum of positive terms, as accurate as one of them.
///
/// The form to use wherever boundaries come in pairs. Other arguments as for [`airlight`].
pub fn airlight_over<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase: &PhaseFunction<T>,
    intensity: S,
    foot: &Foot<T>,
    lit: impl IntoIterator<Item = (T, T)>,
) -> S {
    lit.into_iter().fold(S::splat(T::zero()), |sum, (start, end)| {
        sum.plus(airlight(medium, phase, intensity, foot, start, end))
    })
}

/// Airlight as Σ s_n L(0, x_n) over boundaries in any order.                              (BSA10 Eq. 3)
///
/// The boundaries must be complete: a ray that ends lit has a [`Crossing::LeavesLight`] at its end, so that the signs
/// sum to 1 where the eye is lit and to 0 where it is not.
///
/// Every term is rounded before it is added, so the result errs by about 10⁻⁵ of the *unshadowed* airlight in `f32`,
/// however it is summed; it can come out slightly negative. Use [`airlight_over`] where boundaries can be paired.
pub fn signed_airlight<T: Real>(
    medium: &HomogeneousMedium<T>,
    phase: &PhaseFunction<T>,
    intensity: T,
    foot: &Foot<T>,
    boundaries: impl IntoIterator<Item = Boundary<T>>,
) -> T {
    let mut sum = CompensatedSum::new();
    sum.extend(boundaries.into_iter().map(|boundary| {
        boundary.sign() * airlight(medium, phase, intensity, foot, T::zero(), boundary.distance)
    }));
    sum.total()
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_sums_agree_and_order_does_not_matter(
            mut ends in proptest::collection::vec(0.0..30.0_f64, 2..40), x_foot in -5.0..20.0_f64, h in 0.01..5.0_f64,
            turn in 0..40_usize,
        ) {
            ends.sort_by(f64::total_cmp);
            ends.truncate(ends.len() / 2 * 2);
            let (medium, foot) = (HomogeneousMedium::<f64>::new(0.1, 0.02).unwrap(), Foot { x_foot, h });
            let phase = PhaseFunction::ISOTROPIC;
            let lit: Vec<(f64, f64)> = ends.chunks(2).map(|pair| (pair[0], pair[1])).collect();
            let paired = airlight_over(&medium, &phase, 3.0, &foot, lit.iter().copied());
            let mut boundaries: Vec<_> = lit.iter().flat_map(|&(a, b)| Boundary::of_interval(a, b)).collect();
            let turn = turn % boundaries.len();
            boundaries.rotate_left(turn);
            prop_assert_eq!(boundaries.iter().map(Boundary::sign).sum::<f64>(), 0.0);
            let signed = signed_airlight(&medium, &phase, 3.0, &foot, boundaries);
            let unshadowed = airlight(&medium, &phase, 3.0, &foot, 0.0, 30.0);
            prop_assert!((paired - signed).abs() < 1e-13 * unshadowed);
        }
    }
}
