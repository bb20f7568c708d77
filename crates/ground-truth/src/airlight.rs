//! Airlight of one light along one view ray, over the pieces that the light reaches.

use glam::DVec3;
use media_math::{
    Foot, HomogeneousMedium, PhaseFunction, airlight, airlight_anisotropic, directional_airlight,
    directional_airlight_slab, inverse_square_integral,
};
use scene::{AirlightModel, DRay, DirectionalLight, Interval, Light, LightId, SpotLight};

use crate::Reference;
use crate::face_cuts::face_cuts;
use crate::quadrature::adaptive;
use crate::ray_plane::{RayPlane, Source};
use crate::spot_cuts::intensity_cuts;

/// Relative tolerance where an integral has no closed form.
const TOLERANCE: f64 = 1e-9;

/// Optical depth after which nothing is left: e^(−45) is 3·10⁻²⁰.
const OPAQUE: f64 = 45.0;

/// Coefficients and phase function in `f64`.
pub(crate) type Coefficients = HomogeneousMedium<f64, [f64; 3]>;

/// Memory that is reused from light to light.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    lit: Vec<Interval>,
    cuts: Vec<f64>,
}

impl Reference<'_> {
    /// Airlight that `light` adds to `ray` up to `end` metres; units: W/(m²·sr).
    pub(crate) fn light_airlight(&self, ray: &DRay, end: f64, id: LightId, scratch: &mut Scratch) -> DVec3 {
        let light = &self.lights[id.0];
        let mut span = Interval::new(0.0, end);
        if let Some(bounds) = &self.medium.bounds {
            span = span.intersect(bounds.clip(ray));
        }
        // the eye's way through the medium starts here
        let entry = span.start;
        if let Light::Spot(spot) = light {
            span = spot.clip(ray, span);
        }
        if span.is_empty() || self.coefficients.is_clear() {
            return DVec3::ZERO;
        }
        let mut lit = std::mem::take(&mut scratch.lit);
        if self.settings.shadows_in_medium {
            self.shadows.of_medium().lit_intervals(ray, span, id, &mut lit);
        } else {
            lit.clear();
            lit.push(span);
        }
        // distances from the entry on, where the medium's attenuation starts
        let inner = DRay { origin: ray.at(entry), direction: ray.direction };
        let sum = lit.iter().fold(DVec3::ZERO, |sum, piece| {
            let piece = Interval::new(piece.start - entry, piece.end - entry);
            sum + match light {
                Light::Point(_) => self.local_piece(&inner, piece, light, None, scratch),
                Light::Spot(spot) => self.local_piece(&inner, piece, light, Some(spot), scratch),
                Light::Directional(sun) => self.directional_piece(&inner, piece, light, sun, scratch),
            }
        });
        scratch.lit = lit;
        sum
    }

    fn directional_piece(
        &self,
        ray: &DRay,
        piece: Interval,
        light: &Light,
        sun: &DirectionalLight,
        scratch: &mut Scratch,
    ) -> DVec3 {
        let to_light = -sun.direction.as_dvec3().normalize();
        let phase = self.phase.value_between(to_light.to_array(), ray.direction.to_array());
        let irradiance = sun.irradiance.as_dvec3().to_array();
        // Hoffman and Preetham's model knows no extinction on the light's way
        let attenuating = self.medium.bounds.as_ref().filter(|_| self.settings.model == AirlightModel::Sun);
        let Some(bounds) = attenuating else {
            let sum = directional_airlight(&self.coefficients, phase, irradiance, piece.start, piece.end);
            return sum.into();
        };
        face_cuts(bounds, ray, piece, light, &mut scratch.cuts);
        pieces(piece, &scratch.cuts).fold(DVec3::ZERO, |sum, Interval { start, end }| {
            let path = |x: f64| self.medium.light_path(ray.at(x), light);
            // linear: any two points inside give it
            let (a, b) = (start + 0.25 * (end - start), start + 0.75 * (end - start));
            // between two cuts a rounding apart there is only one
            let slope = if b > a { (path(b) - path(a)) / (b - a) } else { 0.0 };
            let at_start = path(a) + slope * (start - a);
            let airlight =
                directional_airlight_slab(&self.coefficients, phase, irradiance, start, end, at_start, slope);
            sum + DVec3::from(airlight)
        })
    }

    /// A lit piece of the ray in the light of a point or spot light.
    fn local_piece(
        &self,
        ray: &DRay,
        piece: Interval,
        light: &Light,
        spot: Option<&SpotLight>,
        scratch: &mut Scratch,
    ) -> DVec3 {
        let (position, point_intensity) = match light {
            Light::Point(light) => (light.position.as_dvec3(), light.intensity.as_dvec3()),
            Light::Spot(light) => (light.position.as_dvec3(), DVec3::ZERO),
            Light::Directional(_) => return DVec3::ZERO,
        };
        let Source::Near(foot) = RayPlane::new(ray, light).source else {
            return DVec3::ZERO;
        };
        let mut cuts = std::mem::take(&mut scratch.cuts);
        cuts.clear();
        if let Some(spot) = spot {
            intensity_cuts(spot, ray, piece, &mut cuts);
        }
        let cone = spot.map(SpotLight::cone);
        let intensity =
            |x: f64| cone.map_or(point_intensity, |cone| cone.intensity_towards(ray.at(x) - position));
        let sum = pieces(piece, &cuts).fold(DVec3::ZERO, |sum, part| {
            sum + match self.settings.model {
                AirlightModel::HoffmanPreetham => self.without_falloff(&foot, part, &intensity),
                AirlightModel::Sun => match &self.medium.bounds {
                    Some(bounds) if !bounds.contains(position) => {
                        self.light_outside(ray, &foot, part, light, &intensity)
                    }
                    _ => self.light_inside(&foot, part, spot, &intensity),
                },
            }
        });
        scratch.cuts = cuts;
        sum
    }

    /// Both ways lie in the medium throughout: the textbook integral.
    fn light_inside(
        &self,
        foot: &Foot<f64>,
        part: Interval,
        spot: Option<&SpotLight>,
        intensity: &impl Fn(f64) -> DVec3,
    ) -> DVec3 {
        // without a texture, the middle of the cone is a point light
        let middle =
            if part.end.is_finite() { 0.5 * (part.start + part.end) } else { 2.0 * part.start + 1.0 };
        let constant =
            spot.is_none_or(|spot| spot.texture.is_none() && intensity(middle) == spot.intensity.as_dvec3());
        if constant {
            let intensity = intensity(middle).to_array();
            return airlight(&self.coefficients, &self.phase, intensity, foot, part.start, part.end).into();
        }
        airlight_anisotropic(&self.coefficients, &self.phase, foot, part.start, part.end, |x, _| {
            intensity(x).to_array()
        })
        .into()
    }

    /// The light stands outside the medium's bounds: its way inside is a smooth function between the faces' cuts.
    fn light_outside(
        &self,
        ray: &DRay,
        foot: &Foot<f64>,
        part: Interval,
        light: &Light,
        intensity: &impl Fn(f64) -> DVec3,
    ) -> DVec3 {
        let Some(bounds) = &self.medium.bounds else {
            return DVec3::ZERO;
        };
        let sigma_t = DVec3::from(self.coefficients.sigma_t());
        let mut cuts = Vec::new();
        let part = self.until_opaque(part);
        face_cuts(bounds, ray, part, light, &mut cuts);
        let sum = pieces(part, &cuts).fold(DVec3::ZERO, |sum, Interval { start, end }| {
            let value = inverse_square_integral(&self.phase, foot, start, end, 0.0, |node| {
                let x = node.distance;
                let path = x + self.medium.light_path(ray.at(x), light);
                (intensity(x) * (-sigma_t * path).exp()).to_array()
            });
            sum + DVec3::from(value)
        });
        DVec3::from(self.coefficients.sigma_s()) * sum
    }

    /// Hoffman and Preetham's model for a local light: no 1/d², no extinction on the light's way.
    fn without_falloff(&self, foot: &Foot<f64>, part: Interval, intensity: &impl Fn(f64) -> DVec3) -> DVec3 {
        let part = self.until_opaque(part);
        let sigma_t = DVec3::from(self.coefficients.sigma_t());
        // one exponential of three where the medium has no colour
        let is_gray = sigma_t == DVec3::splat(sigma_t.x);
        let mut f = |x: f64| {
            let a = x - foot.x_foot;
            let d = a.hypot(foot.h);
            let r = if a < 0.0 { foot.h * (foot.h / (d - a)) } else { d + a };
            let left = if is_gray { DVec3::splat((-sigma_t.x * x).exp()) } else { (-sigma_t * x).exp() };
            self.phase.at(r, foot.h) * intensity(x) * left
        };
        // the scattering angle turns at the foot
        let cuts = [foot.x_foot];
        let inside = if foot.x_foot > part.start && foot.x_foot < part.end { &cuts[..] } else { &[] };
        let sum = pieces(part, inside)
            .fold(DVec3::ZERO, |sum, Interval { start, end }| sum + adaptive(&mut f, start, end, TOLERANCE));
        DVec3::from(self.coefficients.sigma_s()) * sum
    }

    /// The part of a piece, measured from the medium's near side, from which any light is left.
    fn until_opaque(&self, part: Interval) -> Interval {
        let (sigma_s, sigma_t) = (self.coefficients.sigma_s(), self.coefficients.sigma_t());
        // a channel that scatters nothing has no say
        let scattering = sigma_t.into_iter().zip(sigma_s).filter(|(_, sigma_s)| *sigma_s > 0.0);
        let least = scattering.map(|(sigma_t, _)| sigma_t).fold(f64::INFINITY, f64::min);
        Interval::new(part.start, part.end.min(part.start + OPAQUE / least))
    }
}

/// The pieces of an interval between sorted cuts inside it.
fn pieces(whole: Interval, cuts: &[f64]) -> impl Iterator<Item = Interval> + '_ {
    let starts = std::iter::once(whole.start).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain(std::iter::once(whole.end));
    starts.zip(ends).map(|(start, end)| Interval::new(start, end)).filter(|piece| !piece.is_empty())
}

/// The medium's coefficients and phase function in `f64`.
pub(crate) fn widen(medium: &scene::Medium) -> (Coefficients, PhaseFunction<f64>) {
    let wide = |c: [f32; 3]| c.map(f64::from);
    let (sigma_s, sigma_a) = (wide(medium.coefficients.sigma_s()), wide(medium.coefficients.sigma_a()));
    let sigma_t = wide(medium.coefficients.sigma_t());
    // the sum has more digits, but where less is lost than scattered it is not what was asked for
    let is_sum = (0..3).all(|c| sigma_t[c] >= sigma_s[c]);
    let coefficients = if is_sum {
        Coefficients::new(sigma_s, sigma_a)
    } else {
        Coefficients::with_extinction(sigma_s, sigma_t)
    };
    // a valid f32 medium is a valid f64 medium
    let coefficients = coefficients.unwrap_or_else(|_| Coefficients::clear());
    (coefficients, medium.phase.widen())
}
