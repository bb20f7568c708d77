//! View rays and pieces of them.

use glam::{DVec3, Vec3};

/// A half-line; `direction` has unit length, so parameters along it are metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start; units: m.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
}

impl Ray {
    /// The point `distance` metres along the ray.
    #[inline]
    pub fn at(&self, distance: f32) -> Vec3 {
        self.origin + distance * self.direction
    }
}

/// [`Ray`] in `f64`, for the exact reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DRay {
    /// Start; units: m.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl DRay {
    /// The point `distance` metres along the ray.
    #[inline]
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }

    /// The same ray rounded to `f32`.
    pub fn narrow(&self) -> Ray {
        Ray { origin: self.origin.as_vec3(), direction: self.direction.as_vec3() }
    }
}

impl From<Ray> for DRay {
    fn from(ray: Ray) -> Self {
        Self { origin: ray.origin.as_dvec3(), direction: ray.direction.as_dvec3() }
    }
}

/// A piece of a ray between two distances; units: m. `end` may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Near end.
    pub start: f64,
    /// Far end, at least `start` unless the interval is empty.
    pub end: f64,
}

impl Interval {
    /// The interval from `start` to `end`.
    pub const fn new(start: f64, end: f64) -> Self {
        Self { start, end }
    }

    /// Whether nothing lies between the ends.
    pub fn is_empty(&self) -> bool {
        self.end <= self.start
    }

    /// `end − start`; units: m.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }

    /// What both intervals cover; empty if they do not meet.
    #[must_use]
    pub fn intersect(&self, other: Self) -> Self {
        Self { start: self.start.max(other.start), end: self.end.min(other.end) }
    }
}
