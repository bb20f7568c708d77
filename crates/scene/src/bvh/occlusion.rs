//! [`Visibility`] by shadow rays through the hierarchy, in `f32`.

use std::ops::ControlFlow;

use glam::Vec3;
use obvhs::ray::Ray as TreeRay;

use super::{Bvh, Triangle};
use crate::{Light, LightId, Visibility};

/// Shadow rays from any point to the lights of a scene.
#[derive(Debug, Clone, Copy)]
pub struct BvhVisibility<'a> {
    bvh: &'a Bvh,
    lights: &'a [Light],
}

impl<'a> BvhVisibility<'a> {
    /// Visibility of `lights` among the triangles of `bvh`.
    pub fn new(bvh: &'a Bvh, lights: &'a [Light]) -> Self {
        Self { bvh, lights }
    }
}

/// Whether the segment from `origin` over `direction`·(0, far) meets the triangle.
#[inline]
pub(super) fn blocks(triangle: &Triangle, origin: Vec3, direction: Vec3, far: f32) -> bool {
    let [a, b, c] = triangle.corners;
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let inverse = 1.0 / e1.dot(p);
    let from = origin - a;
    let q = from.cross(e1);
    let (u, v, t) = (from.dot(p) * inverse, direction.dot(q) * inverse, e2.dot(q) * inverse);
    // written so that the NaN of a ray within the triangle's plane does not block
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < far
}

impl Bvh {
    /// Whether a triangle lies between `origin` and `origin + far·direction`; `f32`, for techniques that ask often.
    #[inline]
    pub fn blocked(&self, origin: Vec3, direction: Vec3, far: f32) -> bool {
        let ray = TreeRay::new(origin.into(), direction.into(), 0.0, far);
        self.walk(
            |b| b.intersect_ray(&ray) < far,
            |_, triangle| {
                if blocks(triangle, origin, direction, far) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        )
        .is_break()
    }
}

impl Visibility for BvhVisibility<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        let (direction, far) = match &self.lights[light.0] {
            Light::Point(light) => (light.position - point, 1.0),
            Light::Spot(light) => (light.position - point, 1.0),
            Light::Directional(light) => (-light.direction, f32::INFINITY),
        };
        f32::from(!self.bvh.blocked(point, direction, far))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::soup;
    use super::*;
    use crate::{DRay, PointLight};

    #[test]
    fn agrees_with_double_precision() {
        let bvh = Bvh::build(&soup(600, 0.15)).unwrap();
        let position = Vec3::new(0.4, 1.7, 0.6);
        let lights = [Light::Point(PointLight::new(position, Vec3::ONE).unwrap())];
        let visibility = BvhVisibility::new(&bvh, &lights);
        let (mut lit, mut differ) = (0, 0);
        for i in 0..2000 {
            let t = i as f32;
            let point = Vec3::new((t * 0.377).fract(), (t * 0.611).fract(), (t * 0.873).fract());
            let to = (position - point).as_dvec3();
            let ray = DRay { origin: point.as_dvec3(), direction: to.normalize() };
            let seen = visibility.visibility(point, LightId(0)) == 1.0;
            differ += usize::from(seen == bvh.occluded(&ray, 0.0, to.length()));
            lit += usize::from(seen);
        }
        assert!(lit > 200 && lit < 1800, "{lit} of 2000 lit: the test sees only one outcome");
        assert!(differ <= 1, "{differ} of 2000 differ");
    }
}
