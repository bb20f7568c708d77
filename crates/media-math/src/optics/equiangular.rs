//! Airlight by quadrature in the equiangular variable, for comparison.
//!
//! With θ the angle at the light, dx/d² = dθ/h: the distance cancels from the integrand and what is left is
//! p·e^(−σ_t(d + x)). Smooth, but with a layer of width 1/(σ_t h) at the far end that few nodes miss, and a peak of
//! the phase function that they straddle.

use super::foot::{Foot, Span};
use super::medium::HomogeneousMedium;
use super::phase::PhaseFunction;
use crate::quadrature::gauss_legendre;
use crate::{Real, Spectrum};

/// Airlight by one Gauss-Legendre rule of `nodes` nodes over the angle at the light; units as for
/// [`airlight`](crate::airlight), for any phase function.
pub fn airlight_equiangular<T: Real, S: Spectrum<T>>(
    medium: &HomogeneousMedium<T, S>,
    phase: &PhaseFunction<T>,
    intensity: S,
    foot: &Foot<T>,
    x0: T,
    x1: T,
    nodes: usize,
) -> S {
    let Some(span) = Span::new(foot, x0, x1) else {
        return S::splat(T::zero());
    };
    let sigma_t = medium.sigma_t().scale(span.unit);
    let width = span.angle.0.atan2(span.angle.1);
    let (h, half) = (span.h, T::lit(0.5) * width);
    // angle of the near end, −π/2 to π/2
    let theta0 = ((x0 - foot.x_foot) / span.unit).atan2(h);
    let mut sum = S::splat(T::zero());
    for (node, weight) in gauss_legendre::<T>(nodes) {
        let (sine, cosine) = (theta0 + half * (T::one() + node)).sin_cos();
        // R = h(1 + sin θ)/cos θ, in the form that does not cancel
        let r =
            if sine < T::zero() { h * cosine / (T::one() - sine) } else { h * (T::one() + sine) / cosine };
        let weight = weight * half * phase.at(r, h) / h;
        sum = sum.plus(sigma_t.map(|sigma_t| weight * (-sigma_t * (r - span.r0)).exp()));
    }
    let half = sigma_t.map(|sigma_t| span.half_transmittance(sigma_t));
    medium.sigma_s().times(intensity).times(half).times(sum.scale(T::one() / span.unit)).times(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airlight;

    #[test]
    fn converges_on_an_ordinary_interval() {
        let medium = HomogeneousMedium::<f64>::new(0.05, 0.02).unwrap();
        let phase = PhaseFunction::henyey_greenstein(0.5).unwrap();
        let foot = Foot { x_foot: 3.0, h: 2.0 };
        let exact = airlight(&medium, &phase, 1.0, &foot, 0.5, 20.0);
        let error = |n| (airlight_equiangular(&medium, &phase, 1.0, &foot, 0.5, 20.0, n) / exact - 1.0).abs();
        assert!(error(32) < 1e-10 && error(8) < error(4), "{} {} {}", error(4), error(8), error(32));
    }
}
