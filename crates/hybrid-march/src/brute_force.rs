//! The unaccelerated march: the baseline that every technique is compared with.
//!
//! It is an honest one. A ray is clipped to the light's extent, to the surface it hits, and to what occluders can
//! shadow at all; visibility is asked once a step, at its middle; and the airlight of adjoining lit steps is one
//! evaluation of the interval form, so that all of its error is in where it believes the shadow's boundaries to be.
//! Where the medium varies, or a picture colours the light, each step is weighted on its own.

use glam::{DVec3, Vec3};
use scene::{Aabb, AirlightModel, DRay, Density, Interval, Light, LightId, Medium, Visibility};

use crate::extent::shadow_extent;
use crate::piece::{Piece, least_extinction};

/// Optical depth at which a march through a varying medium stops along an infinite ray: e^(−16) is 10⁻⁷.
const MARCH_DEPTH: f64 = 16.0;

/// What a march needs to know about a frame.
#[derive(Clone, Copy)]
pub struct BruteForce<'a> {
    /// The medium, of any kind.
    pub medium: &'a Medium,
    /// The lights.
    pub lights: &'a [Light],
    /// What casts shadows; `None` if nothing does.
    pub occluders: Option<Occluders<'a>>,
    /// Steps along each ray for each light.
    pub samples: u32,
    /// How airlight of local lights is formed.
    pub model: AirlightModel,
}

/// Shadows to ask for, and where their casters are.
#[derive(Clone, Copy)]
pub struct Occluders<'a> {
    /// Answers for every step.
    pub visibility: &'a dyn Visibility,
    /// A box around all that casts shadows.
    pub bounds: Aabb,
}

impl std::fmt::Debug for Occluders<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Occluders").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for BruteForce<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BruteForce")
            .field("samples", &self.samples)
            .field("lights", &self.lights.len())
            .finish_non_exhaustive()
    }
}

/// Airlight of one ray, and what it cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Marched {
    /// Radiance; units: W/(m²·sr).
    pub airlight: Vec3,
    /// Steps marched.
    pub samples: u64,
    /// Times that visibility was asked: shadow rays, or lookups.
    pub rays: u64,
}

impl BruteForce<'_> {
    /// Airlight of all lights, and the medium's own glow, along `ray` up to `end` metres (may be infinite).
    pub fn airlight(&self, ray: &DRay, end: f64) -> Marched {
        let mut sum = Marched::default();
        if self.medium.emission != [0.0; 3] {
            self.march_varying(ray, end, None, &mut sum);
        }
        if self.medium.coefficients.is_clear() {
            return sum;
        }
        for id in 0..self.lights.len() {
            let id = LightId(id);
            if self.varies_along(id) {
                self.march_varying(ray, end, Some(id), &mut sum);
            } else {
                self.march_uniform(ray, end, id, &mut sum);
            }
        }
        sum
    }

    /// Whether a step's airlight is no closed form: the medium varies, or the light's way is no plain distance.
    fn varies_along(&self, id: LightId) -> bool {
        let local = |position: Vec3| {
            self.model == AirlightModel::HoffmanPreetham
                || self.medium.bounds.is_some_and(|bounds| !bounds.contains(position.as_dvec3()))
        };
        !self.medium.is_homogeneous()
            || match &self.lights[id.0] {
                Light::Point(light) => local(light.position),
                Light::Spot(light) => light.texture.is_some() || local(light.position),
                Light::Directional(_) => self.medium.bounds.is_some() && self.model == AirlightModel::Sun,
            }
    }

    fn visibility(&self, ray: &DRay, x: f64, id: LightId, sum: &mut Marched) -> f32 {
        let Some(occluders) = &self.occluders else { return 1.0 };
        sum.rays += 1;
        occluders.visibility.visibility(ray.at(x).as_vec3(), id)
    }

    /// The part of the ray in which the light shines, and the distance at which the medium begins.
    fn lit_span(&self, ray: &DRay, end: f64, light: &Light) -> (Interval, f64) {
        let mut span = Interval::new(0.0, end);
        if let Some(bounds) = &self.medium.bounds {
            span = span.intersect(bounds.clip(ray));
        }
        if let Some(Density::Grid(grid)) = &self.medium.density {
            span = span.intersect(grid.bounds.clip(ray));
        }
        let entry = span.start;
        if let Light::Spot(spot) = light {
            span = spot.clip(ray, span);
        }
        (span, entry)
    }

    /// Homogeneous medium, and a light whose way lies in it: airlight in closed form over each lit run.
    fn march_uniform(&self, ray: &DRay, end: f64, id: LightId, sum: &mut Marched) {
        let light = &self.lights[id.0];
        let (span, entry) = self.lit_span(ray, end, light);
        if span.is_empty() {
            return;
        }
        let piece = Piece::new(self.medium, light, ray, entry);
        // outside this nothing is shadowed: no sample is spent there
        let shadowed = match (self.occluders, light) {
            (None, _) => Interval::new(span.start, span.start),
            // a spot's cone is its extent
            (Some(_), Light::Spot(_)) => span,
            (Some(occluders), _) => shadow_extent(&occluders.bounds, light, ray, span),
        };
        sum.airlight += piece.airlight(span.start, shadowed.start, Vec3::ONE);
        self.march_runs(ray, shadowed, id, &piece, sum);
        let after = if shadowed.is_empty() { shadowed.start } else { shadowed.end };
        sum.airlight += piece.airlight(after, span.end, Vec3::ONE);
    }

    /// One evaluation for each run of steps of equal visibility.
    fn march_runs(&self, ray: &DRay, span: Interval, id: LightId, piece: &Piece<'_>, sum: &mut Marched) {
        let mut run = (span.start, 0.0);
        for step in piece.steps(span, self.samples, false) {
            sum.samples += 1;
            let visibility = self.visibility(ray, step.middle, id, sum);
            if visibility != run.1 {
                sum.airlight += run.1 * piece.airlight(run.0, step.start, Vec3::ONE);
                run = (step.start, visibility);
            }
        }
        sum.airlight += run.1 * piece.airlight(run.0, span.end, Vec3::ONE);
    }

    /// The part of an infinite span from which any light is left, in a varying medium; a finite span is kept.
    ///
    /// Where the density falls off, the ray may never become opaque: then the part that holds all but a millionth of
    /// what lies on the ray.
    fn until_opaque(&self, ray: &DRay, span: Interval) -> Interval {
        if span.end.is_finite() {
            return span;
        }
        let path = |end| self.medium.optical_path(ray, Interval::new(span.start, end));
        let enough =
            (MARCH_DEPTH / least_extinction(&self.medium.coefficients)).min(0.999999 * path(f64::INFINITY));
        let (mut low, mut high) = (span.start, span.start + 1.0);
        while path(high) < enough && high < 1e30 {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if path(middle) < enough {
                low = middle;
            } else {
                high = middle;
            }
        }
        Interval::new(span.start, high)
    }

    /// Any medium: one step at a time, with the transmittance of the way so far.
    fn march_varying(&self, ray: &DRay, end: f64, id: Option<LightId>, sum: &mut Marched) {
        let unlit = Light::Point(scene::PointLight { position: Vec3::ZERO, intensity: Vec3::ZERO });
        let light = id.map_or(&unlit, |id| &self.lights[id.0]);
        let (span, entry) = self.lit_span(ray, end, light);
        let endless = span.end.is_infinite() && id.is_some();
        let span = self.until_opaque(ray, span);
        let piece = Piece::new(self.medium, light, ray, entry);
        let (sigma_s, sigma_t) = (
            DVec3::from(self.medium.coefficients.sigma_s().map(f64::from)),
            DVec3::from(self.medium.coefficients.sigma_t().map(f64::from)),
        );
        let emission = DVec3::from(self.medium.emission.map(f64::from));
        // the way to the first step, exactly
        let mut path = self.medium.optical_path(ray, Interval::new(0.0, span.start.max(0.0)));
        let mut radiance = DVec3::ZERO;
        for step in piece.steps(span, self.samples, endless) {
            sum.samples += 1;
            let (middle, width) = (step.middle, step.end - step.start);
            let point = ray.at(middle);
            let density = self.medium.density.as_ref().map_or(1.0, |density| density.at(point));
            let (near, step_path) = ((-sigma_t * path).exp(), density * width);
            path += step_path;
            if density == 0.0 {
                continue;
            }
            // mean transmittance over the step
            let mean = near * DVec3::from(sigma_t.to_array().map(|s| media_math::phi(s * step_path)));
            let Some(id) = id else {
                radiance += emission * density * width * mean;
                continue;
            };
            let visibility = f64::from(self.visibility(ray, middle, id, sum));
            if visibility == 0.0 {
                continue;
            }
            let arriving = match (light, self.model) {
                (Light::Directional(light), _) => light.irradiance.as_dvec3() * width,
                (_, AirlightModel::HoffmanPreetham) => piece.intensity_at(middle).as_dvec3() * width,
                // ∫ dx/d² over the step is an angle over h: it stays right next to the light
                (_, AirlightModel::Sun) => piece.intensity_at(middle).as_dvec3() * piece.inverse_square(step),
            };
            let light_path = match (light, self.model) {
                (_, AirlightModel::Sun) => self.medium.light_path(point, light),
                (_, AirlightModel::HoffmanPreetham) => 0.0,
            };
            let scattered = sigma_s * density * f64::from(piece.phase_at(middle));
            radiance += visibility * scattered * arriving * (-sigma_t * light_path).exp() * mean;
        }
        sum.airlight += radiance.as_vec3();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{DirectionalLight, PointLight, SpotLight};

    fn lights() -> Vec<Light> {
        vec![
            Light::Point(PointLight::new(Vec3::new(0.5, 1.0, -3.0), Vec3::new(3.0, 2.0, 1.0)).unwrap()),
            Light::Spot(SpotLight::new(Vec3::new(0.0, 2.0, -3.0), Vec3::NEG_Y, 0.2, 0.6, Vec3::ONE).unwrap()),
            Light::Directional(DirectionalLight::new(Vec3::new(0.2, -1.0, 0.3), Vec3::ONE).unwrap()),
        ]
    }

    fn ray() -> DRay {
        DRay { origin: DVec3::ZERO, direction: DVec3::new(0.05, 0.1, -1.0).normalize() }
    }

    fn march(medium: &Medium, lights: &[Light], samples: u32, end: f64) -> Marched {
        BruteForce { medium, lights, occluders: None, samples, model: AirlightModel::Sun }
            .airlight(&ray(), end)
    }

    #[test]
    fn without_occluders_a_point_light_takes_no_sample() {
        let medium = Medium::homogeneous([0.1; 3], [0.02; 3]).unwrap();
        let marched = march(&medium, &lights()[..1], 100, 8.0);
        assert!(marched.samples == 0 && marched.airlight.min_element() > 0.0);
    }

    #[test]
    fn a_varying_medium_that_does_not_vary_is_a_homogeneous_one() {
        let medium = Medium::homogeneous([0.1, 0.2, 0.3], [0.02; 3]).unwrap();
        // density 1 everywhere the ray goes, but by the general path
        let varying = Medium { density: Some(Density::height(1000.0, 1.0).unwrap()), ..medium.clone() };
        for light in lights() {
            let light = [light];
            let uniform = march(&medium, &light, 4000, 8.0).airlight;
            let stepped = march(&varying, &light, 4000, 8.0).airlight;
            assert!((stepped / uniform - 1.0).abs().max_element() < 1e-4, "{light:?}: {stepped} {uniform}");
        }
    }

    #[test]
    fn thin_parts_of_a_dense_medium_are_marched_to_their_end() {
        // a grid of density 0.001 in a medium of σ 10 is a box of σ 0.01
        let bounds = Aabb { min: Vec3::new(-50.0, -50.0, -100.0), max: Vec3::splat(50.0) };
        let grid = scene::DensityGrid::new([2, 2, 2], bounds, vec![0.001; 8]).unwrap();
        let sparse = Medium {
            density: Some(Density::Grid(grid)),
            ..Medium::homogeneous([10.0; 3], [0.0; 3]).unwrap()
        };
        let thin = Medium { bounds: Some(bounds), ..Medium::homogeneous([0.01; 3], [0.0; 3]).unwrap() };
        for light in lights() {
            let light = [light];
            let (a, b) =
                (march(&sparse, &light, 4000, 90.0).airlight, march(&thin, &light, 4000, 90.0).airlight);
            assert!((a / b - 1.0).abs().max_element() < 1e-3, "{light:?}: {a} {b}");
        }
        // height fog seen from far above it: nearly all of it lies ahead
        let fog = Medium {
            density: Some(Density::height(0.0, 5.0).unwrap()),
            ..Medium::homogeneous([1.0; 3], [0.0; 3]).unwrap()
        };
        let down = DRay { origin: DVec3::new(0.0, 45.0, 0.0), direction: DVec3::NEG_Y };
        let sun = [Light::Directional(DirectionalLight::new(Vec3::X, Vec3::ONE).unwrap())];
        let march = BruteForce {
            medium: &fog,
            lights: &sun,
            occluders: None,
            samples: 20_000,
            model: AirlightModel::Sun,
        };
        // all light is scattered in the end: p·E·(1 − e^(−∞))
        let got = march.airlight(&down, f64::INFINITY).airlight.x;
        let exact = 1.0 / (4.0 * std::f32::consts::PI);
        assert!((got / exact - 1.0).abs() < 1e-3, "{got} {exact}");
        // and up from its floor: the ray leaves the fog and never becomes opaque, its path in all is the scale height
        let up = DRay { origin: DVec3::ZERO, direction: DVec3::Y };
        let thin =
            Medium { density: fog.density.clone(), ..Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap() };
        let got = BruteForce { medium: &thin, ..march }.airlight(&up, f64::INFINITY).airlight.x;
        let exact = exact * (1.0 - (-0.5_f32).exp());
        assert!((got / exact - 1.0).abs() < 1e-3, "{got} {exact}");
    }

    #[test]
    fn a_channel_without_medium_does_not_starve_the_others() {
        let partly = Medium::homogeneous([0.3, 0.3, 0.0], [0.0; 3]).unwrap();
        let grey = Medium::homogeneous([0.3; 3], [0.0; 3]).unwrap();
        for light in lights() {
            let light = [light];
            for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
                let of = |medium| {
                    BruteForce { medium, lights: &light, occluders: None, samples: 500, model }
                        .airlight(&ray(), f64::INFINITY)
                        .airlight
                };
                let (a, b): (Vec3, Vec3) = (of(&partly), of(&grey));
                assert!((a.x / b.x - 1.0).abs() < 1e-4 && a.z == 0.0, "{light:?} {model:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn emission_alone_by_hand() {
        let medium = Medium { emission: [1.0, 2.0, 3.0], ..Medium::homogeneous([0.0; 3], [0.5; 3]).unwrap() };
        let marched = march(&medium, &[], 50, 4.0);
        let exact = (1.0 - (-2.0_f32).exp()) / 0.5;
        assert!((marched.airlight / (exact * Vec3::new(1.0, 2.0, 3.0)) - 1.0).abs().max_element() < 1e-5);
    }
}
