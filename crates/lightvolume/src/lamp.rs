//! One light as one ray sees it: the airlight of a piece, by the integrals of `media-math`.

use media_math::{
    Foot, HomogeneousMedium, PhaseFunction, Real, Spectrum, airlight, directional_airlight,
    inverse_square_integral,
};
use scene::{DRay, Interval, Light, Medium, SpotLight};

/// A homogeneous medium in the precision of the sum.
#[derive(Debug, Clone)]
pub(crate) struct Haze<T> {
    medium: HomogeneousMedium<T, [T; 3]>,
    phase: PhaseFunction<T>,
    /// For a directional light, whose one phase value is worth its digits.
    phase_f64: PhaseFunction<f64>,
}

impl<T: Real> Haze<T> {
    /// From a medium's coefficients, which every precision holds exactly.
    pub(crate) fn new(medium: &Medium) -> Self {
        let coefficients = |values: [f32; 3]| values.map(|value| T::lit(f64::from(value)));
        let (sigma_s, sigma_a) =
            (coefficients(medium.coefficients.sigma_s()), coefficients(medium.coefficients.sigma_a()));
        let phase_f64 = medium.phase.widen();
        let lobes: Vec<_> =
            phase_f64.lobes().iter().map(|&(weight, lobe)| (T::lit(weight), narrow(lobe))).collect();
        Self {
            // valid coefficients stay valid
            medium: HomogeneousMedium::new(sigma_s, sigma_a).unwrap_or_else(|_| HomogeneousMedium::clear()),
            phase: PhaseFunction::mixture(&lobes).unwrap_or(PhaseFunction::ISOTROPIC),
            phase_f64,
        }
    }

    /// e^(−σ_t x) for a way of `x` metres.
    fn transmittance(&self, x: f64) -> [T; 3] {
        self.medium.sigma_t().map(|sigma_t| T::lit((-sigma_t.widen() * x).exp()))
    }
}

fn narrow<T: Real>(lobe: media_math::Lobe<f64>) -> media_math::Lobe<T> {
    use media_math::Lobe::{HenyeyGreenstein, HoffmanPreethamMie, Isotropic, Rayleigh};
    match lobe {
        Isotropic => Isotropic,
        Rayleigh => Rayleigh,
        HenyeyGreenstein { g } => HenyeyGreenstein { g: T::lit(g) },
        HoffmanPreethamMie { g } => HoffmanPreethamMie { g: T::lit(g) },
    }
}

/// A light relative to a view ray, from the near end of a span on.
///
/// Distances are counted from there: a spot's cone may be a sliver far from the eye, whose length the rounding of
/// distances from the eye would change.
#[derive(Debug)]
pub(crate) struct Lamp<'a, T> {
    haze: &'a Haze<T>,
    light: &'a Light,
    /// From the near end on.
    ray: DRay,
    /// Distance of the near end from the eye; units: m.
    near: f64,
    /// Square root of what the medium leaves of light from there: representable long after the whole is not.
    half: [T; 3],
    foot: Foot<f64>,
    /// Phase value of a directional light.
    sun_phase: T,
}

impl<'a, T: Real> Lamp<'a, T> {
    /// For pieces of `ray` no nearer than `near` metres.
    pub(crate) fn new(haze: &'a Haze<T>, light: &'a Light, ray: &DRay, near: f64) -> Self {
        let ray = DRay { origin: ray.at(near), direction: ray.direction };
        let (mut foot, mut sun_phase) = (Foot { x_foot: 0.0, h: 1.0 }, T::zero());
        match light {
            Light::Point(scene::PointLight { position, .. }) | Light::Spot(SpotLight { position, .. }) => {
                let to = position.as_dvec3() - ray.origin;
                foot = Foot::new(to.to_array(), ray.direction.to_array());
                // a ray through the light itself has infinite airlight: move it aside by a rounding
                foot.h = foot.h.max(1e-12 * to.length()).max(1e-12);
            }
            Light::Directional(light) => {
                let to_light = -light.direction.as_dvec3().normalize();
                let phase = haze.phase_f64.value_between(to_light.to_array(), ray.direction.to_array());
                sun_phase = T::lit(phase);
            }
        }
        Self { haze, light, ray, near, half: haze.transmittance(0.5 * near), foot, sun_phase }
    }

    /// Airlight of a fully lit piece, which for a spot lies inside its cone; distances from the eye.
    /// Units: W/(m²·sr).
    pub(crate) fn airlight(&self, start: f64, end: f64) -> [T; 3] {
        if !(end > start) {
            return [T::zero(); 3];
        }
        let piece = Interval::new(start - self.near, end - self.near);
        let airlight = match self.light {
            Light::Point(light) => self.of_point(colour(light.intensity), piece),
            Light::Spot(light) => self.of_spot(light, piece),
            Light::Directional(light) => {
                let (x0, x1) = (T::lit(piece.start), T::lit(piece.end));
                directional_airlight(&self.haze.medium, self.sun_phase, colour(light.irradiance), x0, x1)
            }
        };
        airlight.times(self.half).times(self.half)
    }

    /// The foot in the precision of the sum.
    fn narrow_foot(&self) -> Foot<T> {
        Foot { x_foot: T::lit(self.foot.x_foot), h: T::lit(self.foot.h) }
    }

    fn of_point(&self, intensity: [T; 3], piece: Interval) -> [T; 3] {
        let Haze { medium, phase, .. } = self.haze;
        airlight(medium, phase, intensity, &self.narrow_foot(), T::lit(piece.start), T::lit(piece.end))
    }

    /// Of constant intensity inside the inner cone, by quadrature of the falloff outside.
    fn of_spot(&self, light: &SpotLight, piece: Interval) -> [T; 3] {
        let inner = light.clip_within(&self.ray, piece, f64::from(light.inner));
        if inner.is_empty() {
            return self.of_falloff(light, piece);
        }
        let middle = self.of_point(colour(light.intensity), inner);
        let before = self.of_falloff(light, Interval::new(piece.start, inner.start));
        before.plus(middle).plus(self.of_falloff(light, Interval::new(inner.end, piece.end)))
    }

    /// Where a spot fades towards the edge of its cone.
    ///
    /// There a node's distance from the edge is all that counts. So it is taken from how much longer the light's way has
    /// become since the piece's start, Δx = ΔR/2 (1 + h²/(R R₀)), which keeps its digits where the distance from the foot
    /// loses them.
    fn of_falloff(&self, light: &SpotLight, piece: Interval) -> [T; 3] {
        if piece.is_empty() {
            return [T::zero(); 3];
        }
        let Haze { medium, phase, .. } = self.haze;
        let (sigma_t, h, from_foot) = (medium.sigma_t(), self.foot.h, piece.start - self.foot.x_foot);
        let to_light = from_foot.hypot(h);
        let r0 = if from_foot < 0.0 { h * (h / (to_light - from_foot)) } else { to_light + from_foot };
        let (x0, x1) = (T::lit(piece.start), T::lit(piece.end));
        let cone = light.cone();
        let sum: [T; 3] =
            inverse_square_integral(phase, &self.narrow_foot(), x0, x1, sigma_t.min_channel(), |node| {
                let excess = node.path_excess.widen();
                let x = piece.start + 0.5 * excess * (1.0 + (h / (r0 + excess)) * (h / r0));
                let towards = self.ray.at(x.min(piece.end)) - light.position.as_dvec3();
                let intensity = cone.intensity_towards(towards).to_array().map(T::lit);
                intensity.times(sigma_t.map(|sigma_t| (-sigma_t * node.path_excess).exp()))
            });
        let half = self.haze.transmittance(0.5 * (piece.start + to_light));
        medium.sigma_s().times(half).times(sum.times(half))
    }
}

fn colour<T: Real>(value: glam::Vec3) -> [T; 3] {
    value.to_array().map(|value| T::lit(f64::from(value)))
}
