//! Airlight of a point light for any phase function, and of a light whose intensity depends on direction.
//!
//! Along a ray, a phase function turns at R/h ~ (1 − g)/(1 + g), the distance at 1, the extinction at 1/(σ_t h). The
//! variable y = ln(1 + (R − R₀)/(R₀ + R_s)) with R_s = h·(the phase function's feature scale) resolves all of them,
//! since the integrand is analytic in a strip around it whatever g and σ_t are:
//!
//! L = 2σ_s I₀ e^(−σ_t(x₀ + d₀)) ∫₀^Y p(R) e^(−σ_t(R − R₀)) (R + R_s)/(h² + R²) dy
//!
//! Panels of equal length with a Gauss-Legendre rule each. It is also the simplest single path for everything, and
//! the independent check of [`airlight`](crate::airlight).

use super::airlight::airlight_with;
use super::foot::{Foot, Span};
use super::medium::HomogeneousMedium;
use super::phase::{Lobe, PhaseFunction};
use crate::quadrature::gauss_legendre;
use crate::{Real, Spectrum};

/// Length of a panel in y.
const PANEL: f64 = 1.5;

/// [`airlight`](crate::airlight) through the composite rule for every phase function, the isotropic one included.
pub fn airlight_composite<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase: &PhaseFunction<T>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
) -> S {
    airlight_with(medium, intensity, foot, x0, x1, |span, sigma_t| {
        sum_of_lobes(phase, |lobe| lobe_integral(span, sigma_t, lobe))
    })
}

/// Airlight of a point source whose radiant intensity depends on direction: spot falloff, a picture, a measured lamp.
///
/// `intensity(x, cos_emission_foot)` gives I in W/sr for the light that reaches the ray at `x` metres from the eye;
/// its second argument is a/d, the cosine between the ray's direction and the way from the light to that point, which
/// stays exact where `x` is rounded. Split the interval where the intensity or its slope jumps (cone, texels);
/// between splits it should be smooth over a distance like d.
///
/// Other arguments and units as for [`airlight`](crate::airlight).
pub fn airlight_anisotropic<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase: &PhaseFunction<T>,
    foot: &Foot<T>,
    x0: T,
    x1: T,
    mut intensity: impl FnMut(T, T) -> S,
) -> S {
    let sigma_t = medium.sigma_t();
    let sum = inverse_square_integral(phase, foot, x0, x1, sigma_t.min_channel(), |node| {
        let light = intensity(node.distance, node.cos_emission);
        light.times(sigma_t.map(|sigma_t| (-sigma_t * node.path_excess).exp()))
    });
    let Some(span) = Span::new(foot, x0, x1) else {
        return sum;
    };
    let half = sigma_t.map(|sigma_t| span.half_transmittance(sigma_t * span.unit));
    medium.sigma_s().times(half).times(sum.times(half))
}

/// Where [`inverse_square_integral`] asks for its integrand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathNode<T> {
    /// Distance from the eye; units: m.
    pub distance: T,
    /// (d + x) − (d₀ + x₀): how much longer the way of the light is than at the near end; units: m.
    pub path_excess: T,
    /// Cosine between the ray's direction and the way from the light to the point.
    pub cos_emission: T,
}

/// ∫_{x₀}^{x₁} p(cos θ) f/d² dx by the composite rule; units: f/(m·sr).
///
/// The rule resolves 1/d², the phase function, and an extinction of at least `sigma_t` (in m⁻¹) in f along the light's
/// way; without one, `x1` should be finite. f should be smooth over a distance like d: split the interval elsewhere.
pub fn inverse_square_integral<T: Real, S: Spectrum<T>>(
    phase: &PhaseFunction<T>,
    foot: &Foot<T>,
    x0: T,
    x1: T,
    sigma_t: T,
    mut f: impl FnMut(PathNode<T>) -> S,
) -> S {
    let mut sum = S::splat(T::zero());
    let Some(span) = Span::new(foot, x0, x1) else {
        return sum;
    };
    for_each_node(&span, sigma_t * span.unit, phase.feature_scale(), |node| {
        let r = node.r;
        let x = foot.x_foot + T::lit(0.5) * (r - span.h * (span.h / r)) * span.unit;
        let (r2, h2) = (r * r, span.h * span.h);
        let value = f(PathNode {
            distance: x.max(x0).min(x1),
            path_excess: node.delta * span.unit,
            cos_emission: (r2 - h2) / (r2 + h2),
        });
        sum = sum.plus(value.scale(node.weight * phase.at(r, span.h)));
    });
    sum.scale(T::one() / span.unit)
}

/// ∫ p e^(−σ_t(R − R₀))/d² dx over the span, in its unit of length; each lobe in its own variable, and the isotropic
/// one in its faster form.
pub(crate) fn integral<T: Real>(span: &Span<T>, sigma_t: T, phase: &PhaseFunction<T>) -> T {
    sum_of_lobes(phase, |lobe| match lobe {
        Lobe::Isotropic => super::airlight::isotropic_integral(span, sigma_t),
        _ => lobe_integral(span, sigma_t, lobe),
    })
}

fn sum_of_lobes<T: Real>(phase: &PhaseFunction<T>, mut integral: impl FnMut(&Lobe<T>) -> T) -> T {
    phase
        .lobes()
        .iter()
        .filter(|(weight, _)| *weight > T::zero())
        .fold(T::zero(), |sum, (weight, lobe)| sum + *weight * integral(lobe))
}

/// One lobe by the composite rule.
fn lobe_integral<T: Real>(span: &Span<T>, sigma_t: T, lobe: &Lobe<T>) -> T {
    let mut sum = T::zero();
    for_each_node(span, sigma_t, lobe.feature_scale(), |node| {
        sum = sum + node.weight * lobe.at(node.r, span.h) * (-sigma_t * node.delta).exp();
    });
    sum
}

/// A node of the composite rule, in the span's unit of length.
struct Node<T> {
    /// Path excess R.
    r: T,
    /// R − R₀.
    delta: T,
    /// Quadrature weight times dx/(d² dy).
    weight: T,
}

/// Visits the nodes of the composite rule for extinction `sigma_t` and a phase function that turns at `scale`·h.
#[inline]
fn for_each_node<T: Real>(span: &Span<T>, sigma_t: T, scale: T, mut visit: impl FnMut(Node<T>)) {
    let (one, half, h) = (T::one(), T::lit(0.5), span.h);
    let start = scale * h;
    let from = span.r0 + start;
    // nothing turns within so short a piece: the short form's rule does with fewer nodes, and where R itself
    // underflows it still holds
    if span.dr <= T::lit(0.25) * from && sigma_t * span.dr <= one {
        super::airlight::for_each_short_node(span, |delta, weight| {
            visit(Node { r: span.r0 + delta, delta, weight: T::lit(2.0) * weight });
        });
        return;
    }
    // nothing is left beyond: attenuated away, or so far that distance alone makes it vanish
    let far = (span.r0 + h) * T::lit(T::PANEL_FAR);
    let reach = if sigma_t > T::zero() { (T::lit(T::PANEL_CUT) / sigma_t).min(far) } else { far };
    let y_end = (span.dr.min(reach) / from).ln_1p();
    let panels = (y_end / T::lit(PANEL)).ceil().max(one);
    let half_width = half * y_end / panels;
    let h2 = h * h;
    // at most a few dozen: ln(PANEL_FAR)/PANEL
    for panel in 0..panels.to_u32().unwrap_or(1) {
        let middle = half_width * (T::lit(f64::from(panel)) * T::lit(2.0) + one);
        for (node, w) in gauss_legendre::<T>(T::PANEL_NODES) {
            let delta = from * (middle + half_width * node).exp_m1();
            let r = span.r0 + delta;
            visit(Node { r, delta, weight: T::lit(2.0) * w * half_width * (r + start) / (h2 + r * r) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airlight_isotropic;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn isotropic_equals_the_interval_form(
            x_foot in -5.0..20.0_f64, log_h in -9.0..1.5_f64, log_sigma in -9.0..2.5_f64,
            x0 in 0.0..10.0_f64, log_length in -9.0..6.0_f64,
        ) {
            let foot = Foot { x_foot, h: 10.0_f64.powf(log_h) };
            let medium = HomogeneousMedium::<f64>::new(10.0_f64.powf(log_sigma), 0.0).unwrap();
            let x1 = x0 + 10.0_f64.powf(log_length);
            let interval = airlight_isotropic(&medium, 1.0, &foot, x0, x1);
            let sum = airlight_composite(&medium, &PhaseFunction::ISOTROPIC, 1.0, &foot, x0, x1);
            prop_assert!((sum - interval).abs() <= 2e-13 * interval + f64::MIN_POSITIVE, "{} {}", sum, interval);
        }

        #[test]
        fn a_constant_intensity_is_a_point_light(
            x_foot in -5.0..20.0_f64, log_h in -6.0..1.5_f64, g in -0.95..0.95_f64, x0 in 0.0..10.0_f64, length in 0.01..50.0_f64,
        ) {
            let foot = Foot { x_foot, h: 10.0_f64.powf(log_h) };
            let medium = HomogeneousMedium::<f64, [f64; 3]>::new([0.1, 0.3, 0.2], [0.0, 0.1, 0.5]).unwrap();
            let phase = PhaseFunction::henyey_greenstein(g).unwrap();
            let plain = airlight_composite(&medium, &phase, [1.0, 2.0, 3.0], &foot, x0, x0 + length);
            let directed = airlight_anisotropic(&medium, &phase, &foot, x0, x0 + length, |_, _| [1.0, 2.0, 3.0]);
            for c in 0..3 {
                prop_assert!((directed[c] / plain[c] - 1.0).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn the_node_knows_where_it_is() {
        // intensity x² of a light one metre beside x = 2, no extinction: ∫ x²/(1 + (x − 2)²) dx
        let medium = HomogeneousMedium::<f64>::new(1e-12, 0.0).unwrap();
        let foot = Foot { x_foot: 2.0, h: 1.0 };
        let got = airlight_anisotropic(&medium, &PhaseFunction::ISOTROPIC, &foot, 0.5, 4.0, |x, cos| {
            let a = x - 2.0;
            assert!((cos - a / (a * a + 1.0_f64).sqrt()).abs() < 1e-12);
            x * x
        });
        let antiderivative = |a: f64| a + 2.0 * (a * a + 1.0).ln() + 3.0 * a.atan();
        let exact = (antiderivative(2.0) - antiderivative(-1.5)) * 1e-12 / (4.0 * core::f64::consts::PI);
        assert!((got / exact - 1.0).abs() < 1e-9, "{got} {exact}");
    }
}
