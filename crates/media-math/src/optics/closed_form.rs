//! Airlight as the plain difference of the closed form's two ends, for comparison.
//!
//! L(x₀, x₁) = (σ_s I₀/2πh)·[e^(−σ_t(x₀+d₀)) G(R₀) − e^(−σ_t(x₁+d₁)) G(R₁)], G(z) = Im[e^z E₁(z)]
//!
//! Exact for every interval on paper. In numbers it loses what the two ends have in common: everything on a short
//! interval. [`airlight`](crate::airlight) uses it only where the loss is at most a factor of two.

use super::airlight::{airlight_with, tail_difference};
use super::foot::Foot;
use super::medium::HomogeneousMedium;
use crate::{Real, Spectrum};

/// Airlight of an isotropic medium by the difference of two exponential integrals; units as for
/// [`airlight`](crate::airlight).
pub fn airlight_closed_form<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
) -> S {
    airlight_with(medium, intensity, foot, x0, x1, tail_difference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airlight_isotropic;

    #[test]
    fn agrees_on_long_intervals_and_fails_on_short_ones() {
        let medium = HomogeneousMedium::<f32>::new(0.05, 0.0).unwrap();
        let foot = Foot { x_foot: 3.0, h: 2.0 };
        let (exact, plain) = (
            airlight_isotropic(&medium, 1.0, &foot, 0.0, 40.0),
            airlight_closed_form(&medium, 1.0, &foot, 0.0, 40.0),
        );
        assert!((plain / exact - 1.0).abs() < 1e-5);
        let worst = (0..20).fold(0.0_f32, |worst, i| {
            let x0 = 20.0 + 0.37 * i as f32;
            let exact = airlight_isotropic(&medium, 1.0, &foot, x0, x0 + 1e-3);
            let plain = airlight_closed_form(&medium, 1.0, &foot, x0, x0 + 1e-3);
            worst.max((plain / exact - 1.0).abs())
        });
        assert!(worst > 1e-4, "the loss that the interval form avoids is gone");
    }
}
