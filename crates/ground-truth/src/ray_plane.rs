//! The plane of a view ray and a light, in which shadows are intervals.
//!
//! Coordinates: u along the ray from its origin, v at right angles to it towards the light. The ray is v = 0.

use glam::{DVec2, DVec3};
use media_math::Foot;
use scene::{Bvh, DRay, Interval, Light, PlaneRegion};

/// Smallest distance of a light from the ray, as a share of its distance from the eye.
///
/// A ray through a point light has no plane and infinite airlight; it is moved aside by this much.
const LEAST_OFFSET: f64 = 1e-12;

/// Where the light lies in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source {
    /// At (`x_foot`, `h`); units: m.
    Near(Foot<f64>),
    /// Infinitely far in direction (`along`, `across`), a unit vector with `across` > 0.
    Far { along: f64, across: f64 },
}

/// A view ray, the plane it spans with a light, and the light in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayPlane {
    pub(crate) ray: DRay,
    pub(crate) source: Source,
    /// Unit vector of v.
    across: DVec3,
    /// Unit normal of the plane.
    normal: DVec3,
}

impl RayPlane {
    pub(crate) fn new(ray: &DRay, light: &Light) -> Self {
        let (to_light, near) = match light {
            Light::Point(light) => (light.position.as_dvec3() - ray.origin, true),
            Light::Spot(light) => (light.position.as_dvec3() - ray.origin, true),
            Light::Directional(light) => (-light.direction.as_dvec3().normalize(), false),
        };
        let along = to_light.dot(ray.direction);
        // of all vectors with this cross product, the one at right angles to the ray
        let offset = ray.direction.cross(to_light).cross(ray.direction);
        let h = offset.length();
        let least = (LEAST_OFFSET * to_light.length()).max(LEAST_OFFSET);
        let across = if h < least { ray.direction.any_orthonormal_vector() } else { offset / h };
        let h = h.max(least);
        let source =
            if near { Source::Near(Foot { x_foot: along, h }) } else { Source::Far { along, across: h } };
        Self { ray: *ray, source, across, normal: ray.direction.cross(across) }
    }

    /// The part of the plane between the ray's `span` and the light.
    pub(crate) fn region(&self, span: Interval, bvh: &Bvh) -> PlaneRegion {
        let origin = self.ray.origin;
        let at = |u: f64, v: f64| origin + u * self.ray.direction + v * self.across;
        // inward normal of a side that leads from the ray into direction (u, v), v > 0; "right" is towards larger u
        let right_of = |direction: DVec2| {
            let n = DVec2::new(direction.y, -direction.x).normalize();
            n.x * self.ray.direction + n.y * self.across
        };
        let (light, near_side, far_side) = match self.source {
            Source::Near(Foot { x_foot, h }) => (
                at(x_foot, h),
                DVec2::new(x_foot - span.start, h),
                span.end.is_finite().then(|| DVec2::new(x_foot - span.end, h)),
            ),
            Source::Far { along, across } => {
                let direction = DVec2::new(along, across);
                (origin, direction, span.end.is_finite().then_some(direction))
            }
        };
        let margin = 16.0 * bvh.rounding(&[origin, light]);
        let mut region = PlaneRegion::plane(origin, self.normal, margin)
            .side(origin, self.across)
            .side(at(span.start, 0.0), right_of(near_side));
        if let Some(direction) = far_side {
            region = region.side(at(span.end, 0.0), -right_of(direction));
        }
        if let Source::Near(_) = self.source {
            region = region.side(light, -self.across);
        }
        region
    }

    /// Coordinates (u, v) of a point, and its distance from the plane.
    #[inline]
    fn coordinates(&self, point: DVec3) -> (DVec2, f64) {
        let from = point - self.ray.origin;
        (DVec2::new(from.dot(self.ray.direction), from.dot(self.across)), from.dot(self.normal))
    }

    /// Where a triangle cuts the plane.
    ///
    /// Corners on the plane count as above it, in every triangle alike, so that the cuts of neighbours meet.
    #[inline]
    pub(crate) fn cut(&self, corners: [DVec3; 3]) -> Option<[DVec2; 2]> {
        let c = corners.map(|corner| self.coordinates(corner));
        let above = c.map(|(_, side)| side >= 0.0);
        if above[0] == above[1] && above[1] == above[2] {
            return None;
        }
        // the corner that is alone on its side
        let alone = match above {
            [a, b, _] if a == b => 2,
            [a, _, b] if a == b => 1,
            _ => 0,
        };
        let crossing = |other: usize| {
            // from the upper to the lower corner: neighbours compute a shared edge alike
            let (upper, lower) = if above[alone] { (c[alone], c[other]) } else { (c[other], c[alone]) };
            upper.0.lerp(lower.0, upper.1 / (upper.1 - lower.1))
        };
        Some([crossing((alone + 1) % 3), crossing((alone + 2) % 3)])
    }
}
