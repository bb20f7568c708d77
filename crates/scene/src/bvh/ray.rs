//! The nearest hit of a ray, and whether a segment is blocked; in `f64`.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3A};

use super::{Bvh, wide};
use crate::DRay;

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray; units: m.
    pub distance: f64,
    /// Index into [`Bvh::triangles`].
    pub triangle: usize,
    /// Unit normal of the triangle, either side; zero for a triangle without area.
    pub normal: DVec3,
}

/// A ray prepared for box tests.
struct Slabs {
    origin: DVec3,
    inverse: DVec3,
    /// Half the size by which boxes are grown, so that rounding cannot make a ray miss the box of what it hits.
    margin: f64,
}

impl Slabs {
    fn new(ray: &DRay, margin: f64) -> Self {
        // a zero component gives ±infinity, which the comparisons below take as "parallel"
        Self { origin: ray.origin, inverse: ray.direction.recip(), margin }
    }

    /// Whether the box is met between distance 0 and `far`.
    #[inline]
    fn meet(&self, min: Vec3A, max: Vec3A, far: f64) -> bool {
        let (mut near, mut far) = (0.0_f64, far);
        for axis in 0..3 {
            let (lo, hi) = (f64::from(min[axis]) - self.margin, f64::from(max[axis]) + self.margin);
            let a = (lo - self.origin[axis]) * self.inverse[axis];
            let b = (hi - self.origin[axis]) * self.inverse[axis];
            // f64::min and max drop the NaN of 0 · ∞: a ray inside a slab that it is parallel to
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        near <= far
    }
}

/// Distance at which the ray meets the triangle, if it does beyond `near`; Möller and Trumbore's test.
#[inline]
fn intersect(ray: &DRay, corners: &[DVec3; 3], near: f64) -> Option<f64> {
    let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let p = ray.direction.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let from = ray.origin - corners[0];
    let q = from.cross(e1);
    let (u, v) = (from.dot(p) / det, ray.direction.dot(q) / det);
    let distance = e2.dot(q) / det;
    // written so that NaN misses
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > near && distance.is_finite()).then_some(distance)
}

impl Bvh {
    /// The nearest surface along `ray` within `max_distance` metres, either side of it.
    pub fn closest_hit(&self, ray: &DRay, max_distance: f64) -> Option<Hit> {
        let slabs = Slabs::new(ray, self.rounding(&[ray.origin]));
        let far = std::cell::Cell::new(max_distance);
        let mut best = None;
        let _ = self.walk(
            |b| slabs.meet(b.min, b.max, far.get()),
            |index, triangle| {
                if let Some(distance) = intersect(ray, &wide(&triangle.corners), 0.0)
                    && distance < far.get()
                {
                    far.set(distance);
                    best = Some((distance, index));
                }
                ControlFlow::Continue(())
            },
        );
        best.and_then(|(distance, triangle)| self.hit_on(triangle, distance))
    }

    /// The hit on the triangle of index `triangle`, `distance` metres along a ray: for whoever keeps only these two of
    /// what [`Bvh::closest_hit`] found. `None` if there is no such triangle.
    pub fn hit_on(&self, triangle: usize, distance: f64) -> Option<Hit> {
        let [a, b, c] = wide(&self.triangles().get(triangle)?.corners);
        Some(Hit { distance, triangle, normal: (b - a).cross(c - a).normalize_or_zero() })
    }

    /// Whether a surface lies on `ray` beyond `near` and before `far` metres.
    pub fn occluded(&self, ray: &DRay, near: f64, far: f64) -> bool {
        let slabs = Slabs::new(ray, self.rounding(&[ray.origin]));
        self.walk(
            |b| slabs.meet(b.min, b.max, far),
            |_, triangle| match intersect(ray, &wide(&triangle.corners), near) {
                Some(distance) if distance < far => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            },
        )
        .is_break()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::soup;
    use super::*;
    use crate::{Scene, Unoccluded};

    fn rays() -> impl Iterator<Item = DRay> {
        (0..400).map(|i| {
            let a = f64::from(i) * 0.7;
            let origin = DVec3::new(0.5 + 2.0 * a.cos(), 0.5 + (1.3 * a).sin(), 0.5 + 2.0 * a.sin());
            let target = DVec3::new(0.5 + 0.3 * (2.1 * a).sin(), 0.5, 0.5 + 0.3 * (3.7 * a).cos());
            DRay { origin, direction: (target - origin).normalize() }
        })
    }

    #[test]
    fn the_tree_finds_what_a_list_finds() {
        let bvh = Bvh::build(&soup(800, 0.2)).unwrap();
        let mut hits = 0;
        for ray in rays() {
            let by_list = bvh
                .triangles()
                .iter()
                .filter_map(|t| intersect(&ray, &wide(&t.corners), 0.0))
                .fold(f64::INFINITY, f64::min);
            let by_tree = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            assert_eq!(by_list, by_tree);
            assert_eq!(bvh.occluded(&ray, 0.0, f64::INFINITY), by_list.is_finite());
            assert!(!bvh.occluded(&ray, 0.0, by_list.min(1e9)));
            hits += usize::from(by_list.is_finite());
        }
        assert!(hits > 100 && hits < 400, "{hits} of 400 rays hit: the test sees only one outcome");
    }

    #[test]
    fn axis_aligned_rays_hit_axis_aligned_triangles() {
        let mut scene = Scene::default();
        let square = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| glam::Vec3::new(x, y, 0.0));
        scene.meshes.push(crate::Mesh::new(square.to_vec(), vec![[0, 1, 2]], 0).unwrap());
        let bvh = Bvh::build(&scene).unwrap();
        let down = |x| DRay { origin: DVec3::new(x, 0.25, 3.0), direction: DVec3::NEG_Z };
        assert_eq!(bvh.closest_hit(&down(0.25), f64::INFINITY).unwrap().distance, 3.0);
        assert!(bvh.closest_hit(&down(0.25), 2.5).is_none());
        assert!(bvh.closest_hit(&down(1.25), f64::INFINITY).is_none());
        let _ = Unoccluded;
    }
}
