//! Phase functions: how scattered light is spread over directions.
//!
//! `cos_theta` is taken between the travel directions before and after scattering, so forward is +1. With ω the
//! direction of the view ray and l the direction from the scattering point to the light, cos θ = ω·l.
//!
//! Airlight of a point light is integrated in the variables of [`foot`](crate::foot), in which
//! cos θ = (h² − R²)/(h² + R²). Each lobe is written in both forms, since neither can be turned into the other
//! without losing digits near forward and backward scattering.

use crate::{MediumError, Real};

/// Most lobes that a [`PhaseFunction`] holds.
pub const MAX_LOBES: usize = 4;

/// One term of a phase function; units: sr⁻¹.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lobe<T> {
    /// p = 1/(4π).
    Isotropic,
    /// p = 3/(16π)·(1 + cos² θ).
    Rayleigh,
    /// p = (1 − g²)/(4π)·(1 + g² − 2g cos θ)^(−3/2), the standard normalisation; g > 0 scatters forward.
    HenyeyGreenstein {
        /// Asymmetry: the mean of cos θ, in (−1, 1).
        g: T,
    },
    /// p = (1 − g)²/(4π)·(1 + g² − 2g cos θ)^(−3/2), the Mie term as Hoffman and Preetham normalise it.
    ///
    /// It integrates to (1 − g)/(1 + g) instead of 1, so it is darker by that factor. It is here to match published
    /// pictures and is never chosen by default.
    HoffmanPreethamMie {
        /// Asymmetry, in (−1, 1).
        g: T,
    },
}

/// Isotropic phase function, 1/(4π).
#[inline(always)]
pub fn isotropic<T: Real>() -> T {
    T::lit(0.25 * core::f64::consts::FRAC_1_PI)
}

/// Rayleigh phase function, 3/(16π)·(1 + cos² θ); units: sr⁻¹.
#[inline]
pub fn rayleigh<T: Real>(cos_theta: T) -> T {
    T::lit(0.1875 * core::f64::consts::FRAC_1_PI) * (T::one() + cos_theta * cos_theta)
}

/// Henyey-Greenstein phase function in its standard normalisation; units: sr⁻¹.
///
/// The denominator is formed as (1 − g)² + 2g(1 − cos θ) for g > 0 and (1 + g)² − 2g(1 + cos θ) for g < 0, both
/// sums of positive terms. The literal 1 + g² − 2g cos θ costs 2·10⁻³ in `f32` as g nears 0.999.
#[inline]
pub fn henyey_greenstein<T: Real>(cos_theta: T, g: T) -> T {
    let one = T::one();
    isotropic::<T>() * (one - g) * (one + g) * hg_kernel(one - cos_theta, one + cos_theta, g)
}

/// [`henyey_greenstein`] for two unit vectors: the way to the light and the way of the view ray.
///
/// 1 − cos θ comes from ½|l − ω|², which keeps its digits where a rounded dot product has none left. `T` is taken by
/// component so that no vector type is needed.
#[inline]
pub fn henyey_greenstein_between<T: Real>(to_light: [T; 3], view: [T; 3], g: T) -> T {
    let half_square = |sign: T| {
        let d = |i: usize| to_light[i] + sign * view[i];
        T::lit(0.5) * (d(0) * d(0) + d(1) * d(1) + d(2) * d(2))
    };
    let one = T::one();
    isotropic::<T>() * (one - g) * (one + g) * hg_kernel(half_square(-one), half_square(one), g)
}

/// (1 + g² − 2g cos θ)^(−3/2) from 1 − cos θ and 1 + cos θ.
#[inline(always)]
fn hg_kernel<T: Real>(one_minus_cos: T, one_plus_cos: T, g: T) -> T {
    let two_g = g + g;
    let denominator = if g > T::zero() {
        (T::one() - g).powi(2) + two_g * one_minus_cos
    } else {
        (T::one() + g).powi(2) - two_g * one_plus_cos
    };
    T::one() / (denominator * denominator.sqrt())
}

impl<T: Real> Lobe<T> {
    /// Phase value for the cosine of the scattering angle; units: sr⁻¹.
    #[inline]
    pub fn value(&self, cos_theta: T) -> T {
        match *self {
            Self::Isotropic => isotropic(),
            Self::Rayleigh => rayleigh(cos_theta),
            Self::HenyeyGreenstein { g } => henyey_greenstein(cos_theta, g),
            Self::HoffmanPreethamMie { g } => {
                let one = T::one();
                isotropic::<T>() * (one - g).powi(2) * hg_kernel(one - cos_theta, one + cos_theta, g)
            }
        }
    }

    /// Phase value for the way to the light and the way of the view ray, both of unit length; units: sr⁻¹.
    ///
    /// Twice ½|l ∓ ω|² replaces 1 ∓ cos θ, which a rounded dot product cannot resolve near forward scattering.
    #[inline]
    pub fn value_between(&self, to_light: [T; 3], view: [T; 3]) -> T {
        match *self {
            Self::Isotropic => isotropic(),
            Self::Rayleigh => rayleigh(to_light[0] * view[0] + to_light[1] * view[1] + to_light[2] * view[2]),
            Self::HenyeyGreenstein { g } => henyey_greenstein_between(to_light, view, g),
            Self::HoffmanPreethamMie { g } => {
                henyey_greenstein_between(to_light, view, g) * (T::one() - g) / (T::one() + g)
            }
        }
    }

    /// Phase value on a view ray at which the path excess is `r` and the light's distance from the ray's line is `h`
    /// (see [`foot`](crate::foot)); both in m, only their ratio matters; units: sr⁻¹.
    ///
    /// Henyey-Greenstein becomes (1 − g²)/(4π)·q^(3/2) with q = (h² + R²)/((1 − g)² h² + (1 + g)² R²): no cosine, no
    /// cancellation.
    #[inline]
    pub fn at(&self, r: T, h: T) -> T {
        let (r2, h2) = (r * r, h * h);
        match *self {
            Self::Isotropic => isotropic(),
            Self::Rayleigh => rayleigh((h2 - r2) / (h2 + r2)),
            Self::HenyeyGreenstein { g } => {
                let one = T::one();
                isotropic::<T>() * (one - g) * (one + g) * hg_ratio(r2, h2, g)
            }
            Self::HoffmanPreethamMie { g } => isotropic::<T>() * (T::one() - g).powi(2) * hg_ratio(r2, h2, g),
        }
    }

    /// Where the lobe changes fastest along a view ray, as a multiple of h in the path excess R.
    ///
    /// A forward lobe of asymmetry g turns at R/h = (1 − g)/(1 + g); everything else at 1 or beyond.
    #[inline]
    pub fn feature_scale(&self) -> T {
        match *self {
            Self::HenyeyGreenstein { g } | Self::HoffmanPreethamMie { g } if g > T::zero() => {
                (T::one() - g) / (T::one() + g)
            }
            _ => T::one(),
        }
    }

    /// Integral over the sphere: 1 except for [`Lobe::HoffmanPreethamMie`].
    pub fn integral(&self) -> T {
        match *self {
            Self::HoffmanPreethamMie { g } => (T::one() - g) / (T::one() + g),
            _ => T::one(),
        }
    }

    fn check(&self) -> Result<(), MediumError> {
        match *self {
            Self::HenyeyGreenstein { g } | Self::HoffmanPreethamMie { g } => {
                if g.abs() < T::one() {
                    Ok(())
                } else {
                    Err(MediumError::Asymmetry { value: g.widen() })
                }
            }
            _ => Ok(()),
        }
    }
}

/// ((h² + R²)/((1 − g)² h² + (1 + g)² R²))^(3/2).
#[inline(always)]
fn hg_ratio<T: Real>(r2: T, h2: T, g: T) -> T {
    let ratio = (h2 + r2) / ((T::one() - g).powi(2) * h2 + (T::one() + g).powi(2) * r2);
    ratio * ratio.sqrt()
}

/// A phase function: a weighted sum of [`Lobe`]s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseFunction<T> {
    lobes: [(T, Lobe<T>); MAX_LOBES],
    count: usize,
}

impl<T: Real> Default for PhaseFunction<T> {
    fn default() -> Self {
        Self::ISOTROPIC
    }
}

impl<T: Real> PhaseFunction<T> {
    /// Equal in every direction.
    pub const ISOTROPIC: Self = Self { lobes: [(T::UNIT, Lobe::Isotropic); MAX_LOBES], count: 1 };

    /// The phase function that is a single lobe.
    ///
    /// # Errors
    /// [`MediumError::Asymmetry`] if g is outside (−1, 1).
    pub fn single(lobe: Lobe<T>) -> Result<Self, MediumError> {
        Self::mixture(&[(T::one(), lobe)])
    }

    /// Henyey-Greenstein with asymmetry `g`; g = 0 is the isotropic phase function and becomes it.
    ///
    /// # Errors
    /// [`MediumError::Asymmetry`] if `g` is outside (−1, 1).
    pub fn henyey_greenstein(g: T) -> Result<Self, MediumError> {
        if g == T::zero() { Ok(Self::ISOTROPIC) } else { Self::single(Lobe::HenyeyGreenstein { g }) }
    }

    /// Rayleigh scattering's share `rayleigh_fraction` of σ_s, and Henyey-Greenstein with `g` for the rest.
    ///
    /// # Errors
    /// [`MediumError::Asymmetry`] or [`MediumError::Weight`] if a parameter is out of range.
    pub fn rayleigh_mie(g: T, rayleigh_fraction: T) -> Result<Self, MediumError> {
        Self::mixture(&[
            (rayleigh_fraction, Lobe::Rayleigh),
            (T::one() - rayleigh_fraction, Lobe::HenyeyGreenstein { g }),
        ])
    }

    /// A mixture of 1 to [`MAX_LOBES`] lobes with weights in [0, 1] that sum to 1.
    ///
    /// # Errors
    /// A [`MediumError`] that names the count, weight or asymmetry at fault.
    pub fn mixture(lobes: &[(T, Lobe<T>)]) -> Result<Self, MediumError> {
        if lobes.is_empty() || lobes.len() > MAX_LOBES {
            return Err(MediumError::LobeCount { count: lobes.len(), max: MAX_LOBES });
        }
        let mut phase = Self { count: lobes.len(), ..Self::ISOTROPIC };
        let mut sum = 0.0;
        for (slot, &(weight, lobe)) in phase.lobes.iter_mut().zip(lobes) {
            lobe.check()?;
            if !(weight >= T::zero() && weight <= T::one()) {
                return Err(MediumError::Weight { value: weight.widen() });
            }
            sum += weight.widen();
            *slot = (weight, lobe);
        }
        if (sum - 1.0).abs() > 1e-5 {
            return Err(MediumError::Weight { value: sum });
        }
        Ok(phase)
    }

    /// The lobes and their weights.
    pub fn lobes(&self) -> &[(T, Lobe<T>)] {
        &self.lobes[..self.count]
    }

    /// Whether every direction is alike, for which the closed forms of airlight hold.
    pub fn is_isotropic(&self) -> bool {
        self.lobes().iter().all(|&(weight, lobe)| weight == T::zero() || lobe == Lobe::Isotropic)
    }

    /// Phase value for the cosine of the scattering angle; units: sr⁻¹.
    #[inline]
    pub fn value(&self, cos_theta: T) -> T {
        self.sum(|lobe| lobe.value(cos_theta))
    }

    /// Phase value for the way to the light and the way of the view ray, both of unit length; units: sr⁻¹.
    #[inline]
    pub fn value_between(&self, to_light: [T; 3], view: [T; 3]) -> T {
        self.sum(|lobe| lobe.value_between(to_light, view))
    }

    /// Phase value at path excess `r` and light offset `h`, see [`Lobe::at`]; units: sr⁻¹.
    #[inline]
    pub fn at(&self, r: T, h: T) -> T {
        self.sum(|lobe| lobe.at(r, h))
    }

    /// The smallest [`Lobe::feature_scale`] of the mixture.
    pub fn feature_scale(&self) -> T {
        self.lobes().iter().fold(T::one(), |least, (_, lobe)| least.min(lobe.feature_scale()))
    }

    #[inline(always)]
    fn sum(&self, mut value: impl FnMut(&Lobe<T>) -> T) -> T {
        self.lobes().iter().fold(T::zero(), |sum, (weight, lobe)| sum + *weight * value(lobe))
    }
}

impl PhaseFunction<f32> {
    /// The same phase function with `f64` parameters.
    pub fn widen(&self) -> PhaseFunction<f64> {
        let mut wide = PhaseFunction::<f64>::ISOTROPIC;
        wide.count = self.count;
        for (to, (weight, lobe)) in wide.lobes.iter_mut().zip(self.lobes) {
            let lobe = match lobe {
                Lobe::Isotropic => Lobe::Isotropic,
                Lobe::Rayleigh => Lobe::Rayleigh,
                Lobe::HenyeyGreenstein { g } => Lobe::HenyeyGreenstein { g: f64::from(g) },
                Lobe::HoffmanPreethamMie { g } => Lobe::HoffmanPreethamMie { g: f64::from(g) },
            };
            *to = (f64::from(weight), lobe);
        }
        wide
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;
    use proptest::prelude::*;

    fn over_sphere(lobe: Lobe<f64>) -> (f64, f64) {
        // the peak of g = 0.98 is 2e-4 wide in cos θ: 8000 panels resolve it
        let (mut norm, mut mean) = (0.0, 0.0);
        for panel in 0..8000 {
            for (x, w) in gauss_legendre::<f64>(12) {
                let c = -1.0 + (f64::from(panel) + 0.5 * (x + 1.0)) / 4000.0;
                let p = core::f64::consts::TAU * lobe.value(c) * w / 8000.0;
                norm += p;
                mean += p * c;
            }
        }
        (norm, mean)
    }

    #[test]
    fn lobes_integrate_to_their_norm_and_mean_cosine() {
        for g in [-0.98, -0.5, 0.01, 0.3, 0.9, 0.98] {
            let (norm, mean) = over_sphere(Lobe::HenyeyGreenstein { g });
            assert!((norm - 1.0).abs() < 1e-10 && (mean - g).abs() < 1e-10, "g {g}: {norm} {mean}");
            let lobe = Lobe::HoffmanPreethamMie { g };
            assert!((over_sphere(lobe).0 - lobe.integral()).abs() < 1e-10 * lobe.integral());
        }
        for lobe in [Lobe::Isotropic, Lobe::Rayleigh] {
            let (norm, mean) = over_sphere(lobe);
            assert!((norm - 1.0).abs() < 1e-11 && mean.abs() < 1e-11);
        }
    }

    #[test]
    fn forward_is_where_g_points() {
        let hg = PhaseFunction::henyey_greenstein(0.7_f64).unwrap();
        assert!(hg.value(1.0) > 50.0 * hg.value(-1.0));
        // towards the light, R → 0: light comes head on and goes on forward
        assert!((hg.at(0.0, 1.0) - hg.value(1.0)).abs() < 1e-14 * hg.value(1.0));
    }

    #[test]
    fn parameters_are_checked() {
        for g in [1.0, -1.0, 1.5, f64::NAN, f64::INFINITY] {
            assert!(matches!(PhaseFunction::henyey_greenstein(g), Err(MediumError::Asymmetry { .. })), "{g}");
        }
        assert!(matches!(PhaseFunction::rayleigh_mie(0.5, 1.5), Err(MediumError::Weight { .. })));
        assert!(matches!(PhaseFunction::<f64>::mixture(&[]), Err(MediumError::LobeCount { .. })));
        let half = [(0.5, Lobe::<f64>::Rayleigh)];
        assert!(matches!(PhaseFunction::mixture(&half), Err(MediumError::Weight { .. })));
        assert!(PhaseFunction::henyey_greenstein(0.0_f32).unwrap().is_isotropic());
    }

    proptest! {
        #[test]
        fn the_three_forms_agree(g in -0.999..0.999_f64, log_ratio in -6.0..6.0_f64) {
            let r = log_ratio.exp();
            let cos = (1.0 - r * r) / (1.0 + r * r);
            let sin = (2.0 * r) / (1.0 + r * r);
            for lobe in [Lobe::Rayleigh, Lobe::HenyeyGreenstein { g }, Lobe::HoffmanPreethamMie { g }] {
                let value = lobe.value(cos);
                prop_assert!((lobe.at(r, 1.0) / value - 1.0).abs() < 1e-9);
                prop_assert!((lobe.value_between([cos, sin, 0.0], [1.0, 0.0, 0.0]) / value - 1.0).abs() < 1e-9);
            }
        }

        #[test]
        fn single_precision_keeps_six_digits(g in -0.999..0.999_f32, cos in -1.0..=1.0_f32) {
            let exact = henyey_greenstein(f64::from(cos), f64::from(g));
            let got = f64::from(henyey_greenstein(cos, g));
            prop_assert!((got / exact - 1.0).abs() < 2e-6, "{} {}", got, exact);
        }
    }
}
