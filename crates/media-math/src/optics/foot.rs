//! Where a light lies relative to a view ray, and the interval variables in which airlight is well conditioned.
//!
//! ```text
//!             light
//!               *
//!             ⁄ |
//!          d ⁄  | h             a = x − x_f      d = √(a² + h²)      R = d + a
//!           ⁄   |
//!   eye o--*----+-----------> view ray
//!          x    x_f  (foot)
//! ```
//!
//! The way of the light is d + x = R + x_f: up to a constant, it *is* the path excess R. R = h²/(d − a) where a < 0,
//! so nothing cancels, and the difference over an interval is ΔR = (x₁ − x₀)(R₀ + R₁)/(d₀ + d₁), which cancels
//! nothing either. R = h·tan ξ in the notation of (SRNN05) and (WR08), where the integration variable is ξ.

use crate::Real;

/// A point light relative to a view ray that starts at distance 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot<T> {
    /// Distance along the ray of the point nearest to the light, d_l cos γ; negative behind the eye; units: m.
    pub x_foot: T,
    /// Distance of the light from the ray's line, d_l sin γ ≥ 0; units: m.
    pub h: T,
}

impl<T: Real> Foot<T> {
    /// From the vector from the ray's origin to the light, and the ray's unit direction.
    ///
    /// h comes from the cross product: built from an angle it would lose its digits near γ = 0 and γ = π.
    #[inline]
    pub fn new(to_light: [T; 3], direction: [T; 3]) -> Self {
        let [px, py, pz] = to_light;
        let [wx, wy, wz] = direction;
        let cross = [py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx];
        Self {
            x_foot: px * wx + py * wy + pz * wz,
            h: (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt(),
        }
    }

    /// From the distance `light_distance` of eye and light and the angle γ between the ray and the way to the light.
    pub fn from_angle(light_distance: T, gamma: T) -> Self {
        Self { x_foot: light_distance * gamma.cos(), h: light_distance * gamma.sin() }
    }
}

/// An interval of a view ray in the variables of the module's figure; every airlight form starts from it.
///
/// Lengths are held as multiples of a power of two near the light's distance, so that their squares neither overflow
/// nor underflow, whatever the scene's size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span<T> {
    /// Distance of the light from the ray's line.
    pub(crate) h: T,
    /// Path excess R₀ at the near end.
    pub(crate) r0: T,
    /// ΔR = R₁ − R₀; infinite for a ray without end.
    pub(crate) dr: T,
    /// ΔR/(h² + R₀R₁) = tan(ξ₁ − ξ₀)/h.
    pub(crate) q: T,
    /// x₀ + d₀: the way of the light that is scattered at the near end.
    near: T,
    /// What `near` was rounded from.
    near_end: NearEnd<T>,
    /// θ₁ − θ₀, the angle that the interval subtends at the light, is atan2 of these two.
    pub(crate) angle: (T, T),
    /// Metres per unit of length used here.
    pub(crate) unit: T,
}

/// Optical depth from which the rounding of the exponent matters.
const THICK: f64 = 8.0;

/// The near end of an interval, with what its distance from the foot lost to rounding.
#[derive(Debug, Clone, Copy)]
struct NearEnd<T> {
    x0: T,
    /// x₀ − x_f, rounded, and the rest.
    a0: (T, T),
    /// √(a₀² + h²); 0 where there is no such triangle.
    d0: T,
}

impl<T: Real> NearEnd<T> {
    /// (x₀ + d₀) − `near` to twice the working precision, from the exact squares.
    fn lost(&self, h: T, near: T) -> T {
        let ((a, a_lost), d) = (self.a0, self.d0);
        let square = |x: T| (x * x, x.mul_add(x, -(x * x)));
        let ((a2, a2_lost), (h2, h2_lost), (d2, d2_lost)) = (square(a), square(h), square(d));
        let (large, small) = if a2 > h2 { (a2, h2) } else { (h2, a2) };
        // a² + h² − d² = 2d·(what d lost)
        let rest = ((large - d2) + small) + ((a2_lost + h2_lost) - d2_lost);
        let d_lost = (T::lit(0.5) * rest + a * a_lost) / d;
        d_lost + lost_by_adding(self.x0, d, near)
    }
}

/// The rounding error of `sum` = a + b.
fn lost_by_adding<T: Real>(a: T, b: T, sum: T) -> T {
    let b_part = sum - a;
    (a - (sum - b_part)) + (b - b_part)
}

impl<T: Real> Span<T> {
    /// The interval from `x0` to `x1` (may be infinite); `None` if it is empty.
    #[inline]
    pub(crate) fn new(foot: &Foot<T>, x0: T, x1: T) -> Option<Self> {
        let zero = T::zero();
        // written so that NaN is empty too
        if !(x1 > x0) {
            return None;
        }
        // each end from the foot by itself: near the light the difference is exact, the length is not
        let (mut a0, mut a1, mut h, mut length) = (x0 - foot.x_foot, x1 - foot.x_foot, foot.h.abs(), x1 - x0);
        let mut a0_lost = lost_by_adding(x0, -foot.x_foot, a0);
        let mut near = x0;
        let mut unit = T::one();
        let mut scale = a0.abs().max(h);
        if scale == zero {
            scale = length.min(T::one());
        }
        if !(T::lit(1e-3)..T::lit(1e6)).contains(&scale) {
            unit = power_of_two_near(scale);
            let per_unit = T::one() / unit;
            (a0, a1, a0_lost, h) = (a0 * per_unit, a1 * per_unit, a0_lost * per_unit, h * per_unit);
            (length, near) = (length * per_unit, near * per_unit);
            scale = scale * per_unit;
        }
        h = h.max(T::lit(T::MIN_RELATIVE_H) * scale);
        let h2 = h * h;
        let d0 = (a0 * a0 + h2).sqrt();
        let near_end = NearEnd { x0: near, a0: (a0, a0_lost), d0 };
        let near = near + d0;
        let span = if a1 < zero {
            // all of it before the light: R = h²/(d − a), and the h² is taken out of q, which stays finite on the axis
            let d1 = (a1 * a1 + h2).sqrt();
            let (rho0, rho1) = (T::one() / (d0 - a0), T::one() / (d1 - a1));
            let slope = length * (rho0 + rho1) / (d0 + d1);
            Self {
                h,
                r0: h2 * rho0,
                dr: h2 * slope,
                q: slope / (T::one() + h2 * rho0 * rho1),
                near,
                near_end,
                angle: (h * length, h2 + a0 * a1),
                unit,
            }
        } else {
            let r0 = if a0 < zero { h2 / (d0 - a0) } else { d0 + a0 };
            // beyond this the far end cannot be told from infinity, and its square would overflow
            if a1 > T::lit(T::FAR) * scale {
                Self { h, r0, dr: T::infinity(), q: T::one() / r0, near, near_end, angle: (h, a0), unit }
            } else {
                let d1 = (a1 * a1 + h2).sqrt();
                let r1 = d1 + a1;
                let dr = length * (r0 + r1) / (d0 + d1);
                Self {
                    h,
                    r0,
                    dr,
                    q: dr / (h2 + r0 * r1),
                    near,
                    near_end,
                    angle: (h * length, h2 + a0 * a1),
                    unit,
                }
            }
        };
        Some(span)
    }

    /// The interval of ξ from `v0` to `v1` in F's integral, as a span with h = 1 m and x_f = 0.
    pub(crate) fn of_angles(v0: T, v1: T) -> Option<Self> {
        if !(v1 > v0) {
            return None;
        }
        let (one, sine) = (T::one(), (v1 - v0).sin());
        let (c0, c1) = (v0.cos(), v1.cos());
        let r0 = v0.tan();
        let dr = if c1 > T::zero() { sine / (c0 * c1) } else { T::infinity() };
        // θ = 2ξ − π/2
        let double = (v1 - v0) + (v1 - v0);
        Some(Self {
            h: one,
            r0,
            dr,
            q: sine / (v1 - v0).cos(),
            near: r0,
            near_end: NearEnd { x0: r0, a0: (T::zero(), T::zero()), d0: T::zero() },
            angle: (double.sin(), double.cos()),
            unit: one,
        })
    }

    /// √(e^(−σ_t(x₀ + d₀))), with σ_t per unit of the span's length.
    ///
    /// The transmittance is applied in two halves: in a thick medium each is representable long after the whole is
    /// not, and a bright light may bring the product back into range. In a thick medium the rounding of the exponent is
    /// the largest error of all, so there it is made up for.
    #[inline]
    pub(crate) fn half_transmittance(&self, sigma_t: T) -> T {
        let depth = sigma_t * self.near;
        let rounded = (T::lit(-0.5) * depth).exp();
        if !(depth > T::lit(THICK)) || self.near_end.d0 == T::zero() {
            return rounded;
        }
        let lost = sigma_t.mul_add(self.near, -depth) + sigma_t * self.near_end.lost(self.h, self.near);
        rounded * (T::one() - T::lit(0.5) * lost)
    }
}

/// The power of two nearest below `value`, which must be positive.
#[cold]
fn power_of_two_near<T: Real>(value: T) -> T {
    if !value.is_finite() {
        return T::one();
    }
    let (mantissa, exponent, _) = value.integer_decode();
    let log2 = i32::from(exponent) + 63 - mantissa.leading_zeros() as i32;
    T::lit(2.0).powi(log2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two() {
        assert_eq!(power_of_two_near(1.0_f64), 1.0);
        assert_eq!(power_of_two_near(0.3_f64), 0.25);
        assert_eq!(power_of_two_near(5e9_f32), 4294967296.0);
    }

    #[test]
    fn vectors_and_angles_agree() {
        let gamma: f64 = 0.9;
        let foot = Foot::new([6.0 * gamma.cos(), 6.0 * gamma.sin(), 0.0], [1.0, 0.0, 0.0]);
        let other = Foot::from_angle(6.0, gamma);
        assert!((foot.x_foot - other.x_foot).abs() < 1e-15 && (foot.h - other.h).abs() < 1e-15);
    }

    #[test]
    fn span_by_hand() {
        // a 3-4-5 triangle: a₀ = −4, a₁ = 4, h = 3
        let span = Span::new(&Foot { x_foot: 4.0, h: 3.0 }, 0.0, 8.0).unwrap();
        assert_eq!((span.r0, span.dr, span.near), (1.0, 8.0, 5.0));
        assert_eq!(span.q, 8.0 / (9.0 + 9.0));
        assert!(Span::new(&Foot { x_foot: 4.0, h: 3.0 }, 2.0, 2.0).is_none());
        assert!(Span::new(&Foot { x_foot: 4.0, h: 3.0 }, f64::NAN, 2.0).is_none());
    }

    #[test]
    fn scale_does_not_matter() {
        let base = Span::new(&Foot { x_foot: 1.5_f32, h: 0.5 }, 0.25, 3.0).unwrap();
        for scale in [2.0_f32.powi(-60), 2.0_f32.powi(40)] {
            let span =
                Span::new(&Foot { x_foot: 1.5 * scale, h: 0.5 * scale }, 0.25 * scale, 3.0 * scale).unwrap();
            let same = |a: f32, b: f32| (a * span.unit / (b * scale) - 1.0).abs() < 1e-6;
            assert!(same(span.r0, base.r0) && same(span.dr, base.dr) && same(span.near, base.near));
        }
    }
}
