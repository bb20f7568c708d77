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

/// Smallest component of a direction relative to its largest: below, the ray moves by less than any rounding.
const MIN_COMPONENT: f32 = 1e-18;

/// Inverse of each component, finite unless the direction has no length.
///
/// Directions come in any length, so that the least component is relative to the largest: obvhs's own 10⁻⁷ bends rays
/// in scenes of millimetres.
#[inline]
pub(super) fn inverse(direction: Vec3) -> Vec3 {
    let least = MIN_COMPONENT * direction.abs().max_element();
    let kept = |d: f32| 1.0 / if d.abs() < least { least.copysign(d) } else { d };
    Vec3::from_array(direction.to_array().map(kept))
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
        // not by `new`, which asserts that values are finite: a march may ask from where an f32 overflows, and hits nothing
        let ray = TreeRay {
            origin: origin.into(),
            direction: direction.into(),
            inv_direction: inverse(direction).into(),
            tmin: 0.0,
            tmax: far,
        };
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
    fn what_overflows_is_not_hit() {
        let bvh = Bvh::build(&soup(60, 0.15)).unwrap();
        let lights = [Light::Point(PointLight::new(Vec3::ONE, Vec3::ONE).unwrap())];
        let visibility = BvhVisibility::new(&bvh, &lights);
        // where a march ends up whose distances are no f32
        for x in [3e38, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(visibility.visibility(Vec3::new(x, 0.0, 0.0), LightId(0)), 1.0, "{x}");
        }
    }

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

    #[test]
    fn a_short_direction_is_as_good_as_a_long_one() {
        let bvh = Bvh::build(&soup(600, 0.15)).unwrap();
        let mut blocked = 0;
        for i in 0..2000 {
            let t = i as f32;
            let point = Vec3::new((t * 0.377).fract(), (t * 0.611).fract(), (t * 0.873).fract());
            let mut direction =
                Vec3::new((t * 0.719).fract(), (t * 0.237).fract(), (t * 0.531).fract()) - 0.5;
            direction[i % 3] *= 1e-3;
            direction[(i + 1) % 3] *= if i % 2 == 0 { 0.0 } else { 1.0 };
            // powers of two: nothing is rounded otherwise
            let short = bvh.blocked(point, direction / 16_777_216.0, 16_777_216.0);
            assert_eq!(bvh.blocked(point, direction, 1.0), short, "from {point} along {direction}");
            blocked += usize::from(short);
        }
        assert!(blocked > 200 && blocked < 1800, "{blocked} of 2000 blocked: the test sees only one outcome");
    }
}
