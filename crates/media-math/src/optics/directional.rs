//! Airlight of a directional light: sunlight, and the model of Hoffman and Preetham.
//!
//! The phase function does not vary along a ray, so the integral is closed for each of them:
//!
//! L(x₀, x₁) = σ_s p E ∫ e^(−σ_t x) dx = σ_s p E e^(−σ_t x₀) Δ φ(σ_t Δ),  Δ = x₁ − x₀,  φ(y) = (1 − e^(−y))/y
//!
//! φ goes through `expm1`: the literal difference loses everything on thin segments.

use super::medium::{HomogeneousMedium, transmittance};
use super::phase::{Lobe, rayleigh};
use crate::{CompensatedSum, MediumError, Real, Spectrum};

/// φ(y) = (1 − e^(−y))/y for y of either sign, φ(0) = 1.
#[inline]
pub fn phi<T: Real>(y: T) -> T {
    if y == T::zero() { T::one() } else { -(-y).exp_m1() / y }
}

/// ∫_{x₀}^{x₁} e^(−σ_t x) dx in m; `x1` may be infinite (the result then too, if σ_t is 0).
#[inline]
pub fn transmittance_integral<T: Real>(sigma_t: T, x0: T, x1: T) -> T {
    let length = x1 - x0;
    if !(length > T::zero()) {
        return T::zero();
    }
    if length.is_infinite() {
        return transmittance(sigma_t, x0) / sigma_t;
    }
    transmittance(sigma_t, x0) * length * phi(sigma_t * length)
}

/// Airlight of a directional light over the part of a view ray between `x0` and `x1`; units: W/(m²·sr).
///
/// `phase_value` is the phase function for the fixed scattering angle in sr⁻¹, `irradiance` E in W/m². The light
/// arrives unattenuated; see [`directional_airlight_slab`] for a medium with a boundary.
pub fn directional_airlight<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase_value: T,
    irradiance: S,
    x0: T,
    x1: T,
) -> S {
    let path = medium.sigma_t().map(|sigma_t| transmittance_integral(sigma_t, x0, x1));
    // a channel without a medium has an infinite path to infinity, and still no airlight
    let scattered = medium
        .sigma_s()
        .zip(path, |sigma_s, path| if sigma_s == T::zero() { sigma_s } else { sigma_s * path });
    scattered.times(irradiance).scale(phase_value)
}

/// [`directional_airlight`] with the light attenuated over `light_path_0 + slope·(x − x0)` metres before it reaches x.
///
/// On a piece of a ray on which the light enters the medium through one plane, its way is linear in x; this is then
/// exact. With n the plane's normal towards the light, slope = −(n·ω)/(n·l).
pub fn directional_airlight_slab<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase_value: T,
    irradiance: S,
    x0: T,
    x1: T,
    light_path_0: T,
    slope: T,
) -> S {
    let length = x1 - x0;
    if !(length > T::zero()) {
        return S::splat(T::zero());
    }
    let growth = T::one() + slope;
    // from the end with the shorter way: from the other it is 0 times infinity in a thick medium
    let shorter = light_path_0 + x0 + if growth < T::zero() { growth * length } else { T::zero() };
    let path = medium
        .sigma_t()
        .map(|sigma_t| transmittance(sigma_t, shorter) * length * phi(sigma_t * growth.abs() * length));
    medium.sigma_s().times(irradiance).times(path).scale(phase_value)
}

/// How the Mie term of [`HoffmanPreetham`] is normalised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MieNormalisation {
    /// Henyey-Greenstein's own: integrates to 1.
    #[default]
    Standard,
    /// (1 − g)² in place of 1 − g², as published: darker by (1 − g)/(1 + g).
    HoffmanPreetham,
}

/// Rayleigh and Mie scattering under a directional light, after Hoffman and Preetham 2003.
///
/// L(s) = L₀ e^(−β_ex s) + (β_R(θ) + β_M(θ))/β_ex · E_sun·(1 − e^(−β_ex s)); coefficients in m⁻¹ by channel. β_abs is
/// 0 in the published model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoffmanPreetham<T, S> {
    beta_rayleigh: S,
    beta_mie: S,
    beta_absorption: S,
    mie: Lobe<T>,
}

impl<T: Real, S: Spectrum<T>> HoffmanPreetham<T, S> {
    /// The model for scattering coefficients β_R, β_M and absorption β_abs in m⁻¹ and the Mie asymmetry `g`.
    ///
    /// # Errors
    /// [`MediumError`] if a coefficient is negative or not finite or `g` is outside (−1, 1).
    pub fn new(
        beta_rayleigh: S,
        beta_mie: S,
        beta_absorption: S,
        g: T,
        normalisation: MieNormalisation,
    ) -> Result<Self, MediumError> {
        let parts =
            [("beta_rayleigh", beta_rayleigh), ("beta_mie", beta_mie), ("beta_absorption", beta_absorption)];
        for (name, beta) in parts {
            if !beta.all(|b| b.is_finite() && b >= T::zero()) {
                let value = beta.fold(
                    0.0,
                    |bad: f64, b| {
                        if b.is_finite() && b >= T::zero() { bad } else { b.widen() }
                    },
                );
                return Err(MediumError::Coefficient { name, value });
            }
        }
        if !(g.abs() < T::one()) {
            return Err(MediumError::Asymmetry { value: g.widen() });
        }
        let mie = match normalisation {
            MieNormalisation::Standard => Lobe::HenyeyGreenstein { g },
            MieNormalisation::HoffmanPreetham => Lobe::HoffmanPreethamMie { g },
        };
        Ok(Self { beta_rayleigh, beta_mie, beta_absorption, mie })
    }

    /// β_ex = β_R + β_M + β_abs; units: m⁻¹.
    pub fn extinction(&self) -> S {
        self.beta_rayleigh.plus(self.beta_mie).plus(self.beta_absorption)
    }

    /// β_R(θ) + β_M(θ) for the cosine of the angle between the view ray and the way to the light; units: 1/(m·sr).
    pub fn angular_scattering(&self, cos_theta: T) -> S {
        let (rayleigh, mie) = (rayleigh(cos_theta), self.mie.value(cos_theta));
        self.beta_rayleigh.scale(rayleigh).plus(self.beta_mie.scale(mie))
    }

    /// Extinction factor e^(−β_ex s) over `s` metres.
    pub fn extinction_factor(&self, s: T) -> S {
        self.extinction().map(|beta| transmittance(beta, s))
    }

    /// Inscattered radiance over sorted, disjoint lit intervals of the ray; `e_sun` in W/m²; units: W/(m²·sr).
    pub fn in_scatter(&self, cos_theta: T, e_sun: S, lit: impl Iterator<Item = (T, T)> + Clone) -> S {
        let path = self.extinction().map(|beta| {
            let mut sum = CompensatedSum::new();
            sum.extend(lit.clone().map(|(start, end)| transmittance_integral(beta, start, end)));
            sum.total()
        });
        self.angular_scattering(cos_theta).times(e_sun).times(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // no extinction: the length; all of an infinite ray: 1/σ
        assert_eq!(transmittance_integral(0.0_f64, 2.0, 5.0), 3.0);
        assert!((transmittance_integral(0.5_f64, 0.0, f64::INFINITY) - 2.0).abs() < 1e-15);
        assert_eq!(transmittance_integral(0.5_f32, 3.0, 3.0), 0.0);
        // a thin segment is its length, to all digits
        assert!((transmittance_integral(1e-3_f32, 0.0, 1e-6) / 1e-6 - 1.0).abs() < 1e-6);
        assert_eq!(phi(0.0_f64), 1.0);
        assert!((phi(-1.0_f64) - (core::f64::consts::E - 1.0)).abs() < 1e-15);
    }

    #[test]
    fn a_slab_without_slope_is_a_constant_factor() {
        let medium = HomogeneousMedium::<f64>::new(0.2, 0.1).unwrap();
        let plain = directional_airlight(&medium, 0.08, 5.0, 1.0, 4.0);
        let slab = directional_airlight_slab(&medium, 0.08, 5.0, 1.0, 4.0, 2.0, 0.0);
        assert!((slab / plain - (-0.6_f64).exp()).abs() < 1e-15);
        // light that comes from behind the eye at the same rate as the ray goes on: e^(−σ(x + x))
        let toward = directional_airlight_slab(&medium, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0);
        let exact = 0.2 * (1.0 - (-0.6 * 3.0_f64).exp()) / 0.6;
        assert!((toward / exact - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_published_model_without_absorption() {
        let model = HoffmanPreetham::<f64, [f64; 3]>::new(
            [1e-3, 2e-3, 4e-3],
            [2e-3; 3],
            [0.0; 3],
            0.7,
            MieNormalisation::HoffmanPreetham,
        )
        .unwrap();
        let got = model.in_scatter(0.3, [10.0; 3], core::iter::once((0.0, 500.0)));
        let beta: f64 = 3e-3;
        let phase = 1e-3 * 3.0 / (16.0 * core::f64::consts::PI) * 1.09
            + 2e-3 / (4.0 * core::f64::consts::PI) * 0.09 / (1.0_f64 + 0.49 - 0.42).powf(1.5);
        let exact = phase / beta * 10.0 * (1.0 - (-beta * 500.0).exp());
        assert!((got[0] / exact - 1.0).abs() < 1e-13, "{} {exact}", got[0]);
        assert!(HoffmanPreetham::<f64, f64>::new(0.1, -0.1, 0.0, 0.5, MieNormalisation::Standard).is_err());
        assert!(HoffmanPreetham::<f64, f64>::new(0.1, 0.1, 0.0, 1.0, MieNormalisation::Standard).is_err());
    }

    #[test]
    fn nothing_at_all_is_zero_not_nan() {
        let clear = HoffmanPreetham::<f32, f32>::new(0.0, 0.0, 0.0, 0.5, MieNormalisation::Standard).unwrap();
        assert_eq!(clear.in_scatter(1.0, 10.0, core::iter::once((0.0, 1e6))), 0.0);
        assert_eq!(clear.extinction_factor(1e6), 1.0);
    }

    #[test]
    fn a_way_that_shortens_in_a_thick_medium_is_the_way_back() {
        let medium = HomogeneousMedium::<f64>::new(1000.0, 0.0).unwrap();
        // the way of the light falls by 3 m for each metre of the ray, from 6 m
        let there = directional_airlight_slab(&medium, 1.0, 1.0, 0.0, 2.0, 6.0, -3.0);
        // ∫ e^(−σ (6 − 2 x)) dx up to 2 m
        let exact = 1000.0 * (-2000.0_f64).exp() / 2000.0;
        assert!(there.is_finite() && (there - exact).abs() < 1e-300, "{there} {exact}");
        let thin = HomogeneousMedium::<f64>::new(0.5, 0.0).unwrap();
        let there = directional_airlight_slab(&thin, 1.0, 1.0, 0.0, 2.0, 6.0, -3.0);
        let exact = 0.5 * ((-0.5_f64 * 2.0).exp() - (-0.5_f64 * 6.0).exp());
        assert!((there / exact - 1.0).abs() < 1e-12, "{there} {exact}");
    }
}
