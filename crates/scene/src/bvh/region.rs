//! The part of a plane that the shadow rays of one view ray sweep.

use glam::{DVec3, Vec3A};

/// A flat convex region: a plane and the half-spaces that bound it within the plane.
///
/// All ways from the points of a view ray to a light lie in one plane, between the ray, the ways from its two ends,
/// and the light. Only triangles that cut this region can shadow the ray.
#[derive(Debug, Clone)]
pub struct PlaneRegion {
    normal: Vec3A,
    normal_abs: Vec3A,
    offset: f32,
    sides: [Side; MAX_SIDES],
    count: usize,
    margin: f32,
}

/// Most sides that a region has: the ray, the light's height, and the ways from the ray's two ends.
const MAX_SIDES: usize = 4;

#[derive(Debug, Clone, Copy, Default)]
struct Side {
    inward: Vec3A,
    inward_abs: Vec3A,
    /// Dot product of `inward` and any point on the side.
    least: f32,
}

impl PlaneRegion {
    /// The plane through `point` with unit `normal`, without sides yet.
    ///
    /// The tests run in `f32`: `margin`, in m, must cover the rounding of the coordinates involved.
    pub fn plane(point: DVec3, normal: DVec3, margin: f64) -> Self {
        let n = normal.as_vec3a();
        Self {
            normal: n,
            normal_abs: n.abs(),
            offset: normal.dot(point) as f32,
            sides: [Side::default(); MAX_SIDES],
            count: 0,
            margin: margin as f32,
        }
    }

    /// Adds the side on which (point − `through`)·`inward` ≥ 0, with `inward` of unit length in the plane.
    ///
    /// A fifth side is dropped: the region is then larger than meant, never smaller.
    #[must_use]
    pub fn side(mut self, through: DVec3, inward: DVec3) -> Self {
        if let Some(slot) = self.sides.get_mut(self.count) {
            let n = inward.as_vec3a();
            *slot = Side { inward: n, inward_abs: n.abs(), least: inward.dot(through) as f32 };
            self.count += 1;
        }
        self
    }

    /// Whether the box may meet the region; errs towards yes.
    #[inline]
    pub fn may_meet(&self, min: Vec3A, max: Vec3A) -> bool {
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
        (self.normal.dot(center) - self.offset).abs() <= self.normal_abs.dot(half) + self.margin
            && self.sides[..self.count]
                .iter()
                .all(|side| side.inward.dot(center) + side.inward_abs.dot(half) + self.margin >= side.least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_by_hand() {
        // the quarter x ≥ 1, y ≥ 0 of the plane z = 2
        let region = PlaneRegion::plane(DVec3::new(0.0, 0.0, 2.0), DVec3::Z, 1e-6)
            .side(DVec3::X, DVec3::X)
            .side(DVec3::ZERO, DVec3::Y);
        let unit_box = |x: f32, y: f32, z: f32| {
            region.may_meet(Vec3A::new(x, y, z), Vec3A::new(x + 1.0, y + 1.0, z + 1.0))
        };
        assert!(unit_box(3.0, 3.0, 1.5) && unit_box(0.5, -0.5, 1.0) && unit_box(1.0, 0.0, 2.0));
        assert!(!unit_box(3.0, 3.0, 2.5) && !unit_box(-0.5, 3.0, 1.5) && !unit_box(3.0, -1.5, 1.5));
    }
}
