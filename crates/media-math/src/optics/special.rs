//! Sun et al.'s special function F(u, v) = ∫₀^v e^(−u tan ξ) dξ.                        (SRNN05, WR08 §2)

use super::airlight::isotropic_integral;
use super::exponential_integral::tail_over_h;
use super::foot::Span;
use crate::Real;
use crate::quadrature::gauss_legendre;

/// F(u, v) for u ≥ 0 and v in [0, π/2]; relative accuracy 10⁻¹³ in `f64`.
///
/// Small v: Gauss-Legendre in ξ, since the closed form from v = 0 cancels there. Otherwise
/// F = G(−iu) − e^(−u tan v) G(u tan v − iu). An argument outside the range gives NaN.
pub fn sun_f<T: Real>(u: T, v: T) -> T {
    let zero = T::zero();
    if !(u >= zero && v >= zero && v <= T::FRAC_PI_2() * (T::one() + T::epsilon())) {
        return T::nan();
    }
    if v == zero || u == zero {
        return v;
    }
    let tan = v.tan();
    // rounding may carry v past π/2, where the tangent changes sign
    let tan = if tan < zero { T::infinity() } else { tan };
    if u * tan <= T::one() && v <= T::lit(0.8) {
        let half = T::lit(0.5) * v;
        return gauss_legendre::<T>(16)
            .fold(zero, |sum, (x, w)| sum + w * (-u * (half * (T::one() + x)).tan()).exp())
            * half;
    }
    tail_over_h(u, zero, T::one()) - (-u * tan).exp() * tail_over_h(u, tan, T::one())
}

/// F(u, v₁) − F(u, v₀) without the cancellation of the two values; relative accuracy 10⁻¹² in `f64`.
///
/// Empty for v₁ ≤ v₀: gives 0. Results below the range of the type give 0 or a subnormal number.
pub fn sun_f_difference<T: Real>(u: T, v0: T, v1: T) -> T {
    let Some(span) = Span::of_angles(v0, v1) else {
        return T::zero();
    };
    let half = span.half_transmittance(u);
    // the airlight integral with h = 1 is this one times 1/(2π)
    T::TAU() * half * (isotropic_integral(&span, u) * half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;
    use proptest::prelude::*;

    #[test]
    fn ends() {
        assert_eq!(sun_f(3.0_f64, 0.0), 0.0);
        assert_eq!(sun_f(0.0_f64, 0.7), 0.7);
        assert!(sun_f(-1.0_f64, 0.5).is_nan() && sun_f(1.0_f64, 1.7).is_nan());
        // ∫₀^{π/2} e^(−tan ξ) dξ = Ci(1) sin 1 + (π/2 − Si(1)) cos 1
        assert!((sun_f(1.0_f64, core::f64::consts::FRAC_PI_2) - 0.6214496242358134).abs() < 1e-15);
        assert!((sun_f(1.0_f32, core::f32::consts::FRAC_PI_2) - 0.62144965).abs() < 1e-6);
        assert_eq!(sun_f_difference(1.0_f64, 0.5, 0.5), 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn equals_the_integral(log_u in -6.0..3.0_f64, v in 0.0..1.57_f64, at in 0.0..1.0_f64) {
            let u = 10.0_f64.powf(log_u);
            let mut f = |xi: f64| (-u * xi.tan()).exp();
            let whole = adaptive(&mut f, 0.0, v, 1e-14, 30);
            prop_assert!((sun_f(u, v) - whole).abs() <= 1e-13 * whole, "{} {}", sun_f(u, v), whole);
            let part = adaptive(&mut f, at * v, v, 1e-14, 30);
            prop_assume!(part > 1e-290);
            let got = sun_f_difference(u, at * v, v);
            prop_assert!((got - part).abs() <= 1e-12 * part, "{} {}", got, part);
        }
    }
}
