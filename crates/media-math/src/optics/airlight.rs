//! Airlight of a point light over an interval of a view ray, in the form that is used by default.
//!
//! L(x₀, x₁) = ∫_{x₀}^{x₁} σ_s p I₀/d² e^(−σ_t(d + x)) dx                       (WR08 Eq. 1, BSA10 Eq. 1)
//!
//! The papers evaluate it as the difference of an antiderivative, which loses everything on short, thin, far or
//! grazing intervals, however fine the table. Here an interval is integrated as such:
//!
//! - *short*: Gauss-Legendre in tan(ξ − ξ₀), whose range comes from the interval's length without a difference;
//!   no trigonometry, no division by h;
//! - *long*: difference of the two tails G, anchored at the near end; "long" is chosen such that the
//!   difference at most doubles the rounding error.
//!
//! Other phase functions go through [`composite`](crate::composite).
//!
//! Deviation: (WR08) prints κ_s in A₀ and A₁, which holds only without absorption; the exponents here are σ_t.

use super::composite;
use super::exponential_integral::tail_over_h;
use super::foot::{Foot, Span};
use super::medium::HomogeneousMedium;
use super::phase::PhaseFunction;
use crate::quadrature::gauss_legendre;
use crate::{Real, Spectrum};

/// Airlight that reaches the eye from the part of a view ray between `x0` and `x1`; units: W/(m²·sr).
///
/// `intensity` is the light's radiant intensity I₀ in W/sr, `foot` the light relative to the ray, `x0` ≤ `x1` metres
/// from the eye, where `x1` may be infinite. An empty interval gives exactly 0; a light on the segment itself, where
/// the integral diverges, gives a large finite value.
///
/// Accuracy, held by this crate's tests and by the public reference cases: relative 10⁻⁵·max(1, τ/60) in `f32` and
/// 10⁻¹² in `f64`, with τ = σ_t(x₀ + d₀), wherever the result is a normal number.
#[inline]
pub fn airlight<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase: &PhaseFunction<T>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
) -> S {
    airlight_with(medium, intensity, foot, x0, x1, |span, sigma_t| {
        if phase.is_isotropic() {
            isotropic_integral(span, sigma_t)
        } else {
            composite::integral(span, sigma_t, phase)
        }
    })
}

/// [`airlight`] of an isotropic phase function.
#[inline]
pub fn airlight_isotropic<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
) -> S {
    airlight_with(medium, intensity, foot, x0, x1, isotropic_integral)
}

/// What every form has in common: the interval's geometry once, then one integral a channel, or a single one where
/// all channels are attenuated alike.
#[inline]
pub(crate) fn airlight_with<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
    mut integral: impl FnMut(&Span<T>, T) -> T,
) -> S {
    let Some(span) = Span::new(foot, x0, x1) else {
        return S::splat(T::zero());
    };
    let sigma_t = medium.sigma_t().scale(span.unit);
    let half = |sigma_t| span.half_transmittance(sigma_t);
    let (integral, half) = if sigma_t.is_uniform() {
        let sigma_t = sigma_t.max_channel();
        (S::splat(integral(&span, sigma_t)), S::splat(half(sigma_t)))
    } else {
        (sigma_t.map(|sigma_t| integral(&span, sigma_t)), sigma_t.map(half))
    };
    // in this order the product of a tiny piece and a thick medium does not pass through a subnormal number
    let arriving = medium.sigma_s().times(intensity).times(half);
    arriving.times(integral.scale(T::one() / span.unit)).times(half)
}

/// ∫ p e^(−σ_t(R − R₀))/d² dx for p = 1/(4π), in the span's unit of length.
#[inline]
pub(crate) fn isotropic_integral<T: Real>(span: &Span<T>, sigma_t: T) -> T {
    let short =
        sigma_t * span.dr <= T::one() && span.q * span.r0 <= T::lit(0.5) && span.q * span.h <= T::one();
    if short { short_integral(span, sigma_t) } else { tail_difference(span, sigma_t) }
}

#[inline]
fn short_integral<T: Real>(span: &Span<T>, sigma_t: T) -> T {
    let mut sum = T::zero();
    for_each_short_node(span, |delta, weight| sum = sum + weight * (-sigma_t * delta).exp());
    T::lit(0.5 * core::f64::consts::FRAC_1_PI) * sum
}

/// Gauss-Legendre in s = tan(ξ − ξ₀)/h, through the half-angle so that the nodes need no trigonometry: visits R − R₀
/// and the weight of dR/(h² + R²).
#[inline]
pub(crate) fn for_each_short_node<T: Real>(span: &Span<T>, mut visit: impl FnMut(T, T)) {
    let (one, h, r0) = (T::one(), span.h, span.r0);
    let hq = h * span.q;
    let p = span.q / (one + (one + hq * hq).sqrt());
    let m = h * h + r0 * r0;
    let hp2 = h * h * p * p;
    for (y, w) in gauss_legendre::<T>(T::SHORT_NODES) {
        let s = p * (one + y) / (one - hp2 * y);
        visit(m * s / (one - r0 * s), p * w / (one + hp2 * y * y));
    }
}

/// [G(R₀) − e^(−σ_t ΔR) G(R₁)]/(2πh): exact for every interval, accurate for long ones.
#[inline]
pub(crate) fn tail_difference<T: Real>(span: &Span<T>, sigma_t: T) -> T {
    let (h, r0) = (span.h, span.r0);
    let scale = T::lit(0.5 * core::f64::consts::FRAC_1_PI);
    // σ_t = 0, or so small that σ_t·R is no longer a number: light that is never attenuated
    if !(sigma_t * r0.max(h) > T::min_positive_value()) {
        return scale * T::lit(0.5) * span.angle.0.atan2(span.angle.1) / h;
    }
    let far = if span.dr.is_infinite() {
        T::zero()
    } else {
        (-sigma_t * span.dr).exp() * tail_over_h(sigma_t, r0 + span.dr, h)
    };
    scale * (tail_over_h(sigma_t, r0, h) - far)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;
    use proptest::prelude::*;

    /// The defining integral over θ, at the precision of f64.
    fn by_definition(sigma_s: f64, sigma_t: f64, intensity: f64, foot: &Foot<f64>, x0: f64, x1: f64) -> f64 {
        let h = foot.h;
        let (t0, t1) = (((x0 - foot.x_foot) / h).atan(), ((x1 - foot.x_foot) / h).atan());
        let mut f = |theta: f64| {
            let x = foot.x_foot + h * theta.tan();
            let d = h / theta.cos();
            (-sigma_t * (d + x)).exp()
        };
        sigma_s * intensity / (4.0 * core::f64::consts::PI * h) * adaptive(&mut f, t0, t1, 1e-13, 40)
    }

    fn grey(sigma_s: f64, sigma_a: f64) -> HomogeneousMedium<f64> {
        HomogeneousMedium::new(sigma_s, sigma_a).unwrap()
    }

    #[test]
    fn the_example_of_the_papers_correction() {
        // σ_s = 0.07, σ_a = 0.05, d_l = 6, γ = 0.9, d_s = 11: κ_s in place of κ_t would be 59 % too bright
        let foot = Foot::from_angle(6.0, 0.9);
        let got = airlight_isotropic(&grey(0.07, 0.05), 1.0, &foot, 0.0, 11.0);
        let exact = by_definition(0.07, 0.12, 1.0, &foot, 0.0, 11.0);
        assert!((got / exact - 1.0).abs() < 1e-13, "{got} {exact}");
        assert!(by_definition(0.07, 0.07, 1.0, &foot, 0.0, 11.0) / exact > 1.5);
    }

    #[test]
    fn nothing_is_exactly_nothing() {
        let foot = Foot { x_foot: 1.0, h: 2.0 };
        assert_eq!(airlight_isotropic(&grey(0.1, 0.0), 5.0, &foot, 3.0, 3.0), 0.0);
        assert_eq!(airlight_isotropic(&grey(0.0, 0.1), 5.0, &foot, 0.0, 3.0), 0.0);
        assert_eq!(airlight_isotropic(&grey(0.1, 0.1), 0.0, &foot, 0.0, 3.0), 0.0);
    }

    #[test]
    fn vacuum_is_an_angle() {
        let medium = HomogeneousMedium::<f64>::new(0.3, 0.0).unwrap();
        // σ_t → 0 while σ_s stays: no such medium, so the integral itself
        let span = Span::new(&Foot { x_foot: 2.0, h: 1.0 }, 0.0, 50.0).unwrap();
        let exact = (48.0_f64.atan() + 2.0_f64.atan()) / (4.0 * core::f64::consts::PI);
        assert!((isotropic_integral(&span, 0.0) / exact - 1.0).abs() < 1e-14);
        assert!(medium.sigma_t() == 0.3);
    }

    #[test]
    fn through_the_light_is_finite() {
        for x1 in [1.0_f32, 2.0, f32::INFINITY] {
            let l = airlight_isotropic(
                &HomogeneousMedium::<f32>::new(0.1, 0.0).unwrap(),
                1.0,
                &Foot { x_foot: 1.0, h: 0.0 },
                0.0,
                x1,
            );
            assert!(l.is_finite() && l > 0.0, "{l}");
        }
    }

    #[test]
    fn colours_are_three_scalars() {
        let foot = Foot { x_foot: 3.0, h: 1.0 };
        let (s, a) = ([0.1, 0.2, 0.3], [0.05, 0.0, 0.2]);
        let colour = airlight_isotropic(
            &HomogeneousMedium::<f64, [f64; 3]>::new(s, a).unwrap(),
            [1.0, 2.0, 3.0],
            &foot,
            0.0,
            9.0,
        );
        for c in 0..3 {
            let scalar = airlight_isotropic(&grey(s[c], a[c]), 1.0 + c as f64, &foot, 0.0, 9.0);
            assert!((colour[c] / scalar - 1.0).abs() < 1e-15);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn equals_its_definition(
            x_foot in -5.0..20.0_f64, log_h in -1.0..1.5_f64, log_sigma in -4.0..1.0_f64,
            x0 in 0.0..10.0_f64, log_length in -2.0..2.0_f64,
        ) {
            let (h, sigma) = (10.0_f64.powf(log_h), 10.0_f64.powf(log_sigma));
            let foot = Foot { x_foot, h };
            let x1 = x0 + 10.0_f64.powf(log_length);
            // the reference's own angle must be well conditioned
            prop_assume!((x1 - x0) * h > 1e-4 * (h * h + (x0 - x_foot).powi(2)));
            let exact = by_definition(sigma, sigma, 2.0, &foot, x0, x1);
            prop_assume!(exact > 1e-300);
            let got = airlight_isotropic(&grey(sigma, 0.0), 2.0, &foot, x0, x1);
            prop_assert!((got / exact - 1.0).abs() < 1e-10, "{} {}", got, exact);
        }

        #[test]
        fn pieces_add_up(
            x_foot in -5.0..20.0_f64, log_h in -8.0..1.5_f64, log_sigma in -9.0..2.0_f64,
            x0 in 0.0..10.0_f64, log_length in -9.0..3.0_f64, at in 0.001..0.999_f64, g in -0.95..0.95_f64,
        ) {
            let foot = Foot { x_foot, h: 10.0_f64.powf(log_h) };
            let medium = grey(10.0_f64.powf(log_sigma), 0.0);
            let x2 = x0 + 10.0_f64.powf(log_length);
            let x1 = x0 + at * (x2 - x0);
            prop_assume!(x1 > x0 && x2 > x1);
            for phase in [PhaseFunction::ISOTROPIC, PhaseFunction::henyey_greenstein(g).unwrap()] {
                let l = |a, b| airlight(&medium, &phase, 1.0, &foot, a, b);
                let (whole, sum) = (l(x0, x2), l(x0, x1) + l(x1, x2));
                prop_assert!(whole >= 0.0 && whole.is_finite());
                prop_assert!((whole - sum).abs() <= 1e-12 * whole + f64::MIN_POSITIVE, "{} {}", whole, sum);
            }
        }

        #[test]
        fn single_precision_holds_five_digits(
            x_foot in -50.0..200.0_f32, log_h in -7.0..2.0_f32, log_sigma in -9.0..2.0_f32,
            x0 in 0.0..100.0_f32, log_length in -5.0..4.0_f32, log_scale in -8.0..8.0_f32, g in -0.99..0.99_f32,
        ) {
            let scale = 10.0_f32.powf(log_scale);
            let foot = Foot { x_foot: x_foot * scale, h: 10.0_f32.powf(log_h) * scale };
            let sigma = 10.0_f32.powf(log_sigma) / scale;
            let (x0, x1) = (x0 * scale, (x0 + 10.0_f32.powf(log_length)) * scale);
            let wide = Foot { x_foot: f64::from(foot.x_foot), h: f64::from(foot.h) };
            let tau = f64::from(sigma) * (f64::from(x0) + (f64::from(x0) - wide.x_foot).hypot(wide.h));
            for phase in [PhaseFunction::ISOTROPIC, PhaseFunction::henyey_greenstein(g).unwrap()] {
                let exact = airlight(
                    &grey(f64::from(sigma), 0.0), &phase.widen(), 1.0, &wide, f64::from(x0), f64::from(x1),
                );
                let got = airlight(&HomogeneousMedium::<f32>::new(sigma, 0.0).unwrap(), &phase, 1.0, &foot, x0, x1);
                prop_assert!(got.is_finite());
                if exact > f64::from(f32::MIN_POSITIVE) {
                    let error = (f64::from(got) / exact - 1.0).abs();
                    prop_assert!(error < 1e-5 * (tau / 60.0).max(1.0), "{} {}: {:e}, tau {}", got, exact, error, tau);
                }
            }
        }
    }
}
