//! A homogeneous medium: how much light is scattered and absorbed per metre.

use crate::{MediumError, Real, Spectrum};

/// Scattering and absorption coefficients of a homogeneous medium, scalar or by channel.
///
/// Extinction is their sum, σ_t = σ_s + σ_a. (WR08) writes κ_s where extinction is meant in its Eqs. 3 and 4,
/// which holds for a medium that does not absorb; here the two are kept apart as in its Eq. 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HomogeneousMedium<T, S = T> {
    sigma_s: S,
    sigma_a: S,
    sigma_t: S,
    _real: core::marker::PhantomData<T>,
}

impl<T: Real, S: Spectrum<T>> HomogeneousMedium<T, S> {
    /// A medium with scattering coefficient `sigma_s` and absorption coefficient `sigma_a`; units: m⁻¹.
    ///
    /// # Errors
    /// [`MediumError::Coefficient`] if a channel is negative or not finite.
    pub fn new(sigma_s: S, sigma_a: S) -> Result<Self, MediumError> {
        check("sigma_s", sigma_s)?;
        check("sigma_a", sigma_a)?;
        let sigma_t = sigma_s.plus(sigma_a);
        check("sigma_t", sigma_t)?;
        Ok(Self { sigma_s, sigma_a, sigma_t, _real: core::marker::PhantomData })
    }

    /// A medium that neither scatters nor absorbs.
    pub fn clear() -> Self {
        let none = S::splat(T::zero());
        Self { sigma_s: none, sigma_a: none, sigma_t: none, _real: core::marker::PhantomData }
    }

    /// A medium given by scattering and extinction, for data that state those two; units: m⁻¹.
    ///
    /// σ_t is kept to the last bit. σ_t < σ_s is allowed, since σ_t → 0 beside a fixed σ_s is the vacuum limit that
    /// formulas are tested in; absorption is then reported as 0.
    ///
    /// # Errors
    /// [`MediumError::Coefficient`] if a channel is negative or not finite.
    pub fn with_extinction(sigma_s: S, sigma_t: S) -> Result<Self, MediumError> {
        check("sigma_s", sigma_s)?;
        check("sigma_t", sigma_t)?;
        let sigma_a = sigma_t.zip(sigma_s, |t, s| (t - s).max(T::zero()));
        Ok(Self { sigma_s, sigma_a, sigma_t, _real: core::marker::PhantomData })
    }

    /// Scattering coefficient σ_s; units: m⁻¹.
    pub fn sigma_s(&self) -> S {
        self.sigma_s
    }

    /// Absorption coefficient σ_a; units: m⁻¹.
    pub fn sigma_a(&self) -> S {
        self.sigma_a
    }

    /// Extinction coefficient σ_t = σ_s + σ_a; units: m⁻¹.
    pub fn sigma_t(&self) -> S {
        self.sigma_t
    }

    /// Beer-Lambert transmittance e^(−σ_t·length) over `length` metres; an infinite length gives 0 unless σ_t is 0.
    pub fn transmittance(&self, length: T) -> S {
        self.sigma_t().map(|sigma_t| transmittance(sigma_t, length))
    }

    /// Whether nothing is scattered, so that there is no airlight to compute.
    pub fn is_clear(&self) -> bool {
        self.sigma_s.all(|sigma_s| sigma_s == T::zero())
    }

    /// Whether every channel is attenuated alike, so that one channel of work serves all.
    pub fn is_achromatic(&self) -> bool {
        self.sigma_t().is_uniform()
    }
}

fn check<T: Real, S: Spectrum<T>>(name: &'static str, spectrum: S) -> Result<(), MediumError> {
    spectrum.fold(Ok(()), |so_far, value: T| {
        so_far.and(if value.is_finite() && value >= T::zero() {
            Ok(())
        } else {
            Err(MediumError::Coefficient { name, value: value.widen() })
        })
    })
}

/// Beer-Lambert transmittance e^(−σ_t·length); `sigma_t` in m⁻¹, `length` in m.
///
/// σ_t = 0 gives 1 for every length, the infinite one included.
#[inline]
pub fn transmittance<T: Real>(sigma_t: T, length: T) -> T {
    if sigma_t == T::zero() { T::one() } else { (-sigma_t * length).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_is_left_after_ln_two() {
        let medium = HomogeneousMedium::<f64>::new(0.2, 0.3).unwrap();
        assert!((medium.transmittance(core::f64::consts::LN_2 / 0.5) - 0.5).abs() < 1e-15);
        assert_eq!(medium.transmittance(f64::INFINITY), 0.0);
        assert_eq!(HomogeneousMedium::<f64>::new(0.0, 0.0).unwrap().transmittance(f64::INFINITY), 1.0);
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        for bad in [-1e-9, f64::NAN, f64::INFINITY] {
            let error = HomogeneousMedium::<f64, [f64; 3]>::new([0.1; 3], [0.0, bad, 0.0]).unwrap_err();
            assert!(matches!(error, MediumError::Coefficient { name: "sigma_a", .. }), "{error}");
        }
    }

    #[test]
    fn colour_is_noticed() {
        let grey = HomogeneousMedium::<f32, [f32; 3]>::new([0.1, 0.2, 0.3], [0.3, 0.2, 0.1]).unwrap();
        assert!(grey.sigma_t()[0] == 0.4 && !grey.is_clear());
        assert!(HomogeneousMedium::<f32, [f32; 3]>::new([0.5; 3], [0.25; 3]).unwrap().is_achromatic());
        assert!(
            !HomogeneousMedium::<f32, [f32; 3]>::new([0.5; 3], [0.25, 0.25, 0.5]).unwrap().is_achromatic()
        );
    }
}
