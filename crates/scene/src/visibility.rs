//! The two questions that every technique asks of its shadows.

use crate::{DRay, Interval, LightId};
use glam::Vec3;

/// How much of a light arrives at a point: 1 lit, 0 shadowed, between for a filtered lookup.
///
/// A shadow map, a hierarchy of triangles, a voxel mask and an analytic occluder all answer it, so one ray march
/// checks all of them.
pub trait Visibility: Sync {
    /// Visibility of `light` from `point` (in m), in [0, 1].
    fn visibility(&self, point: Vec3, light: LightId) -> f32;
}

/// Which pieces of a view ray a light reaches.
pub trait LitIntervals: Sync {
    /// Writes the lit pieces of `ray` within `span` to `out` (cleared first): sorted, disjoint, none empty.
    ///
    /// Distances are metres along the ray; the last piece may end at infinity.
    fn lit_intervals(&self, ray: &DRay, span: Interval, light: LightId, out: &mut Vec<Interval>);
}

/// No occluder: everything is lit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unoccluded;

impl Visibility for Unoccluded {
    fn visibility(&self, _point: Vec3, _light: LightId) -> f32 {
        1.0
    }
}

impl LitIntervals for Unoccluded {
    fn lit_intervals(&self, _ray: &DRay, span: Interval, _light: LightId, out: &mut Vec<Interval>) {
        out.clear();
        if !span.is_empty() {
            out.push(span);
        }
    }
}
