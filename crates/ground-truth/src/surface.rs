//! Surfaces: two-sided Lambert, lit by every light and attenuated on both ways.
//!
//! L_s = base colour/π · E cos θ · V · e^(−σ_t d_light), seen as L_s e^(−σ_t d_eye), with both lengths counted inside
//! the medium only. A directional light reaches a surface in an unbounded medium unattenuated.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use scene::{DRay, Hit, Interval, Light};

use crate::Reference;

/// Shadow rays start this share of the scene's size away from the surface, lest it shadows itself.
const SHADOW_OFFSET: f64 = 1e-9;

impl Reference<'_> {
    /// Radiance of the surface at `hit` as it arrives at the ray's origin; units: W/(m²·sr).
    pub fn surface_radiance(&self, ray: &DRay, hit: &Hit) -> DVec3 {
        let point = ray.at(hit.distance);
        let sigma_t = DVec3::from(self.coefficients.sigma_t());
        let eye_path = self.medium.optical_path(ray, Interval::new(0.0, hit.distance));
        let material = self.bvh.triangles()[hit.triangle].material as usize;
        let colour =
            self.materials.get(material).map_or(DVec3::ONE, |m| DVec3::from(m.base_color.map(f64::from)));
        let eye_side = if hit.normal.dot(ray.direction) <= 0.0 { hit.normal } else { -hit.normal };
        let lit = self
            .lights
            .iter()
            .fold(DVec3::ZERO, |sum, light| sum + self.irradiance(point, eye_side, light, sigma_t));
        colour * FRAC_1_PI * lit * (-sigma_t * eye_path).exp()
    }

    /// Irradiance from one light on the side of a surface that `normal` points to; units: W/m².
    fn irradiance(&self, point: DVec3, normal: DVec3, light: &Light, sigma_t: DVec3) -> DVec3 {
        let (direction, far, unoccluded) = match light {
            Light::Point(light) => {
                let to = light.position.as_dvec3() - point;
                (to.normalize_or_zero(), to.length(), light.intensity.as_dvec3() / to.length_squared())
            }
            Light::Spot(light) => {
                let to = light.position.as_dvec3() - point;
                (to.normalize_or_zero(), to.length(), light.intensity_towards(-to) / to.length_squared())
            }
            Light::Directional(light) => {
                (-light.direction.as_dvec3().normalize(), f64::INFINITY, light.irradiance.as_dvec3())
            }
        };
        let cosine = normal.dot(direction);
        // also dark: the light in the surface, where its irradiance is not a number
        if !(cosine > 0.0 && unoccluded.is_finite()) || unoccluded == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let near = SHADOW_OFFSET * f64::from(self.bvh.bounds().diagonal()).max(1e-3);
        if self.bvh.occluded(&DRay { origin: point, direction }, near, far - near) {
            return DVec3::ZERO;
        }
        let path = self.medium.light_path(point, light);
        unoccluded * cosine * (-sigma_t * path).exp()
    }
}
