//! One light as one ray sees it: the airlight of a piece, by the integrals of `media-math`.

use media_math::{
    Foot, HomogeneousMedium, PhaseFunction, Real, Spectrum, airlight, airlight_anisotropic,
    directional_airlight,
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

/// A light relative to a view ray.
#[derive(Debug)]
pub(crate) struct Lamp<'a, T> {
    haze: &'a Haze<T>,
    light: &'a Light,
    ray: DRay,
    foot: Foot<T>,
    /// Phase value of a directional light.
    sun_phase: T,
}

impl<'a, T: Real> Lamp<'a, T> {
    pub(crate) fn new(haze: &'a Haze<T>, light: &'a Light, ray: &DRay) -> Self {
        let (mut foot, mut sun_phase) = (Foot { x_foot: T::zero(), h: T::one() }, T::zero());
        match light {
            Light::Point(scene::PointLight { position, .. }) | Light::Spot(SpotLight { position, .. }) => {
                let to = position.as_dvec3() - ray.origin;
                let near = Foot::new(to.to_array(), ray.direction.to_array());
                // a ray through the light itself has infinite airlight: move it aside by a rounding
                let least = (1e-12 * to.length()).max(1e-12);
                foot = Foot { x_foot: T::lit(near.x_foot), h: T::lit(near.h.max(least)) };
            }
            Light::Directional(light) => {
                let to_light = -light.direction.as_dvec3().normalize();
                let phase = haze.phase_f64.value_between(to_light.to_array(), ray.direction.to_array());
                sun_phase = T::lit(phase);
            }
        }
        Self { haze, light, ray: *ray, foot, sun_phase }
    }

    /// Airlight of a fully lit piece, which for a spot lies inside its cone; units: W/(m²·sr).
    pub(crate) fn airlight(&self, start: f64, end: f64) -> [T; 3] {
        if !(end > start) {
            return [T::zero(); 3];
        }
        let (x0, x1) = (T::lit(start), T::lit(end));
        let colour = |value: glam::Vec3| value.to_array().map(|value| T::lit(f64::from(value)));
        match self.light {
            Light::Point(light) => self.of_point(colour(light.intensity), x0, x1),
            Light::Spot(light) => self.of_spot(light, colour(light.intensity), Interval::new(start, end)),
            Light::Directional(light) => {
                directional_airlight(&self.haze.medium, self.sun_phase, colour(light.irradiance), x0, x1)
            }
        }
    }

    fn of_point(&self, intensity: [T; 3], x0: T, x1: T) -> [T; 3] {
        airlight(&self.haze.medium, &self.haze.phase, intensity, &self.foot, x0, x1)
    }

    /// Of constant intensity inside the inner cone, by quadrature of the falloff outside.
    fn of_spot(&self, light: &SpotLight, intensity: [T; 3], piece: Interval) -> [T; 3] {
        let inner = light.clip_within(&self.ray, piece, f64::from(light.inner));
        let falloff = |start: f64, end: f64| {
            if !(end > start) {
                return [T::zero(); 3];
            }
            let (medium, phase) = (&self.haze.medium, &self.haze.phase);
            airlight_anisotropic(medium, phase, &self.foot, T::lit(start), T::lit(end), |x, _| {
                let towards = self.ray.at(x.widen()) - light.position.as_dvec3();
                light.intensity_towards(towards).to_array().map(T::lit)
            })
        };
        if inner.is_empty() {
            return falloff(piece.start, piece.end);
        }
        let middle = self.of_point(intensity, T::lit(inner.start), T::lit(inner.end));
        falloff(piece.start, inner.start).plus(middle).plus(falloff(inner.end, piece.end))
    }
}
