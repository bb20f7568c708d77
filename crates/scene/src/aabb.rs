//! Axis-aligned boxes.

use crate::{DRay, Interval};
use glam::{DVec3, Vec3};

/// An axis-aligned box; units: m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing; growing it by a point gives that point.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Centre; units: m.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Length of the diagonal; units: m; 0 for the empty box.
    pub fn diagonal(&self) -> f32 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() }
    }

    /// Whether `point` lies inside or on the surface.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min.as_dvec3()).all() && point.cmple(self.max.as_dvec3()).all()
    }

    /// The part of the ray inside the box, from its origin on; empty if the ray misses.
    pub fn clip(&self, ray: &DRay) -> Interval {
        let mut span = Interval::new(0.0, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            let (lo, hi) = (f64::from(self.min[axis]), f64::from(self.max[axis]));
            if d == 0.0 {
                if o < lo || o > hi {
                    return Interval::new(0.0, 0.0);
                }
            } else {
                let (a, b) = ((lo - o) / d, (hi - o) / d);
                span = span.intersect(Interval::new(a.min(b), a.max(b)));
            }
        }
        if span.is_empty() { Interval::new(0.0, 0.0) } else { span }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clip_by_hand() {
        let b = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        let ray = |o: [f64; 3], d: [f64; 3]| DRay { origin: o.into(), direction: d.into() };
        assert_eq!(b.clip(&ray([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0])), Interval::new(2.0, 4.0));
        assert_eq!(b.clip(&ray([0.0, 0.5, 0.0], [0.0, 1.0, 0.0])), Interval::new(0.0, 0.5));
        assert!(b.clip(&ray([-3.0, 1.5, 0.0], [1.0, 0.0, 0.0])).is_empty());
        assert!(b.clip(&ray([3.0, 0.0, 0.0], [1.0, 0.0, 0.0])).is_empty());
        assert!(Aabb::EMPTY.clip(&ray([0.0; 3], [1.0, 0.0, 0.0])).is_empty());
        assert!(Aabb::EMPTY.is_empty() && Aabb::EMPTY.diagonal() == 0.0);
    }
}
