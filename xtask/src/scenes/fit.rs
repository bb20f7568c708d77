//! How an original is scaled and moved to be a known scene, if it is one.

use glam::{DVec3, Vec3};
use scene::{Aabb, Scene};

use super::known::KnownScene;

/// Triangles by which an original may differ, as a share: degenerate ones are dropped, and publishers mend holes.
const COUNT_TOLERANCE: f64 = 0.01;

/// Lengths by which the boxes may differ once scaled, as a share of the longest side.
const SHAPE_TOLERANCE: f64 = 0.005;

/// A scale about a point, and where that point goes. Originals stand upright as scenes do: Y is up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    from: DVec3,
    scale: f64,
    to: DVec3,
}

impl Fit {
    /// What makes the original the known scene; `None` if its triangle count or the proportions of its box say that it
    /// is another.
    pub(super) fn find(original: &Scene, known: &KnownScene) -> Option<Self> {
        let (count, wanted) = (original.triangle_count() as f64, known.triangles as f64);
        if (count / wanted - 1.0).abs() > COUNT_TOLERANCE {
            return None;
        }
        // vertices that no triangle has do not count
        let corners = original.meshes.iter().flat_map(|mesh| mesh.corners()).flatten();
        let (from, size) = extent(&Aabb::around(corners));
        let (to, wanted) = extent(&known.bounds());
        let scale = wanted.max_element() / size.max_element();
        let off = (scale * size - wanted).abs().max_element();
        // the negation refuses NaN, from boxes without size
        if !(off <= SHAPE_TOLERANCE * wanted.max_element()) {
            return None;
        }
        Some(Self { from, scale, to })
    }

    /// Where a point of the original lies in the scene.
    pub(super) fn apply(&self, point: Vec3) -> Vec3 {
        let moved = self.scale * (point.as_dvec3() - self.from) + self.to;
        // one zero, so that equal points have equal bits
        moved.as_vec3() + Vec3::ZERO
    }
}

/// Centre and size of a box.
fn extent(bounds: &Aabb) -> (DVec3, DVec3) {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    (0.5 * (min + max), max - min)
}
