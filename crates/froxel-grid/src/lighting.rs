//! Light that a froxel's medium sends towards the eye (section 3.1.3; Hillaire 2015).

use glam::{DVec3, Vec3};
use media_math::PhaseFunction;
use scene::{AirlightModel, Light, Medium, SpotCone};

use crate::Lit;

/// 1/(4·asinh 1): the mean of 1/h over a square around a light is that of a light at this share of its side. So a
/// light inside a froxel's width is spread over it, and cannot blaze.
const SQUARE: f64 = 0.284;

/// Evaluates the medium and the lights of a frame.
#[derive(Debug)]
pub(crate) struct Lighting<'a> {
    medium: &'a Medium,
    lights: &'a [Light],
    /// Of the spot lights among them.
    cones: Vec<Option<SpotCone<'a>>>,
    model: AirlightModel,
    sigma_s: DVec3,
    sigma_t: DVec3,
    emission: DVec3,
    phase: PhaseFunction<f64>,
}

/// Where a froxel is on its view ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Eye; units: m.
    pub(crate) eye: DVec3,
    /// Unit vector along the ray.
    pub(crate) direction: DVec3,
    /// Where it samples; units: m.
    pub(crate) point: Vec3,
    /// Where its slice begins and ends; units: m.
    pub(crate) slice: [f64; 2],
    /// Its width at the sample; units: m.
    pub(crate) width: f64,
}

impl Place {
    /// The mean of 1/distance² to a light over the slice, at least a froxel's width away; units: m⁻².
    fn inverse_square(&self, position: Vec3) -> f64 {
        let from = position.as_dvec3() - self.eye;
        let foot = from.dot(self.direction);
        let h = (from - foot * self.direction).length().max(SQUARE * self.width);
        let [a, b] = self.slice;
        let across = h * (b - a);
        across.atan2(h * h + (a - foot) * (b - foot)) / across
    }
}

impl<'a> Lighting<'a> {
    pub(crate) fn new(medium: &'a Medium, lights: &'a [Light], model: AirlightModel) -> Self {
        let wide = |values: [f32; 3]| DVec3::from_array(values.map(f64::from));
        Self {
            medium,
            lights,
            cones: lights.iter().map(Light::cone).collect(),
            model,
            sigma_s: wide(medium.coefficients.sigma_s()),
            sigma_t: wide(medium.coefficients.sigma_t()),
            emission: wide(medium.emission),
            phase: medium.phase.widen(),
        }
    }

    /// Density of the medium at a point inside its extent, a factor on its coefficients.
    pub(crate) fn density(&self, point: Vec3) -> f64 {
        let point = point.as_dvec3();
        if self.medium.bounds.is_some_and(|bounds| !bounds.contains(point)) {
            return 0.0;
        }
        self.medium.density.as_ref().map_or(1.0, |density| density.at(point))
    }

    /// Source radiance of a froxel of that density, from its own emission and the lights with what arrives of each.
    ///
    /// J = ρ (emission + σ_s Σ V p A e^(−σ_t · light path)), A = E for directional lights and I · mean of 1/d² for
    /// local ones.
    pub(crate) fn source(
        &self,
        place: &Place,
        density: f64,
        visible: impl Iterator<Item = (usize, f64)>,
    ) -> DVec3 {
        let mut arriving = DVec3::ZERO;
        for (light, visibility) in visible {
            if visibility > 0.0 {
                arriving += visibility * self.light(place, light);
            }
        }
        density * (self.emission + self.sigma_s * arriving)
    }

    /// What a light that nothing shadows adds, by σ_s; units: W/(m²·sr).
    fn light(&self, place: &Place, index: usize) -> DVec3 {
        let light = &self.lights[index];
        let point = place.point.as_dvec3();
        let local = |position: Vec3, intensity: DVec3| match self.model {
            AirlightModel::Sun => intensity * place.inverse_square(position),
            AirlightModel::HoffmanPreetham => intensity,
        };
        let (arriving, to_light) = match light {
            Light::Point(light) => {
                (local(light.position, light.intensity.as_dvec3()), light.position.as_dvec3() - point)
            }
            Light::Spot(light) => {
                let to = light.position.as_dvec3() - point;
                let intensity = self.cones[index].map_or(DVec3::ZERO, |cone| cone.intensity_towards(-to));
                (local(light.position, intensity), to)
            }
            Light::Directional(light) => (light.irradiance.as_dvec3(), -light.direction.as_dvec3()),
        };
        let to_light = to_light.normalize_or(-place.direction);
        let phase = self.phase.value_between(to_light.to_array(), place.direction.to_array());
        phase * arriving * self.on_the_way(point, light)
    }

    /// Transmittance from a light.
    fn on_the_way(&self, point: DVec3, light: &Light) -> DVec3 {
        if self.model == AirlightModel::HoffmanPreetham && !matches!(light, Light::Directional(_)) {
            return DVec3::ONE;
        }
        transmittance(self.sigma_t, self.medium.light_path(point, light))
    }

    /// Extinction coefficient at density 1; units: m⁻¹.
    pub(crate) fn sigma_t(&self) -> DVec3 {
        self.sigma_t
    }
}

/// e^(−σ·path), 1 for σ = 0 on any path; `path` in m.
pub(crate) fn transmittance(sigma: DVec3, path: f64) -> DVec3 {
    DVec3::from_array(sigma.to_array().map(|s| if s == 0.0 { 1.0 } else { (-s * path).exp() }))
}

/// A froxel's value, and whether it had to be mended: anything negative or not finite becomes 0.
pub(crate) fn checked(source: DVec3, density: f64) -> (Lit, bool) {
    let mut mended = false;
    let mut check = |value: f64| {
        let narrow = value as f32;
        let good = narrow.is_finite() && narrow >= 0.0;
        mended |= !good;
        if good { narrow } else { 0.0 }
    };
    let source = Vec3::from_array(source.to_array().map(&mut check));
    (Lit { source, density: check(density) }, mended)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(slice: [f64; 2]) -> Place {
        let point = Vec3::new(0.0, 0.0, 0.5 * (slice[0] + slice[1]) as f32);
        Place { eye: DVec3::ZERO, direction: DVec3::Z, point, slice, width: 0.2 }
    }

    #[test]
    fn mean_of_the_inverse_square_equals_a_sum() {
        for (position, slice) in [
            (Vec3::new(0.3, 0.0, 2.0), [1.0, 4.0]),
            (Vec3::new(0.0, -2.0, 9.0), [1.0, 4.0]),
            (Vec3::new(0.1, 0.1, -1.0), [0.0, 0.3]),
        ] {
            let n = 200_000;
            let (a, b) = (slice[0], slice[1]);
            let at = |i: u32| DVec3::new(0.0, 0.0, a + (b - a) * (f64::from(i) + 0.5) / f64::from(n));
            let sum: f64 = (0..n).map(|i| 1.0 / (position.as_dvec3() - at(i)).length_squared()).sum();
            let got = place(slice).inverse_square(position);
            assert!((got * f64::from(n) / sum - 1.0).abs() < 1e-8, "{position} {slice:?}: {got}");
        }
    }

    #[test]
    fn a_light_on_the_ray_is_as_far_as_a_froxel_is_wide() {
        // over ±10 m, ∫ dx/(x² + h²) is π/h but for the ends
        let got = 20.0 * place([10.0, 30.0]).inverse_square(Vec3::new(0.0, 0.0, 20.0));
        let h = SQUARE * 0.2;
        assert!((got * h / std::f64::consts::PI - 1.0).abs() < 0.01, "{got}");
        // and 1/h is the mean over the square, 0.2 m a side
        let n = 400;
        let mean: f64 = (0..n * n)
            .map(|i| {
                let along = |i: i32| 0.2 * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
                1.0 / along(i % n).hypot(along(i / n))
            })
            .sum();
        assert!((mean / f64::from(n * n) * h - 1.0).abs() < 0.01);
    }

    #[test]
    fn nonsense_becomes_nothing_and_is_told() {
        let (lit, mended) = checked(DVec3::new(1.0, f64::NAN, -2.0), f64::INFINITY);
        assert!(mended && lit == Lit { source: Vec3::X, density: 0.0 });
        assert!(!checked(DVec3::ONE, 0.5).1);
        assert_eq!(transmittance(DVec3::new(0.0, 1.0, 2.0), f64::INFINITY), DVec3::X);
    }
}
