//! How an original is scaled and moved to be a known scene, if it is one.

use glam::{DVec3, Vec3};
use scene::{Aabb, Scene};

use super::known::KnownScene;

/// Triangles by which an original may differ, as a share: degenerate ones are dropped, and publishers mend holes.
const COUNT_TOLERANCE: f64 = 0.01;

/// Lengths by which the boxes may differ once scaled, as a share of the longest side.
const SHAPE_TOLERANCE: f64 = 0.005;

/// A turn, a scale about a point, and where that point goes. Originals stand upright as scenes do, with Y up, or as
/// modellers have them, with Z up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    turned: bool,
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
        let (centre, size) = extent(&Aabb::around(corners));
        let (to, wanted) = extent(&known.bounds());
        let scale = wanted.max_element() / size.max_element();
        [false, true].into_iter().find_map(|turned| {
            let [from, size] = [centre, size].map(|vector| if turned { y_up(vector) } else { vector });
            let off = (scale * size.abs() - wanted).abs().max_element();
            // a comparison with NaN, from boxes without size, is false
            (off <= SHAPE_TOLERANCE * wanted.max_element()).then_some(Self { turned, from, scale, to })
        })
    }

    /// Where a point of the original lies in the scene.
    pub(super) fn apply(&self, point: Vec3) -> Vec3 {
        let point = point.as_dvec3();
        let point = if self.turned { y_up(point) } else { point };
        let moved = self.scale * (point - self.from) + self.to;
        // one zero, so that equal points have equal bits
        moved.as_vec3() + Vec3::ZERO
    }
}

/// Turns what stands with Z up so that Y is up.
fn y_up(vector: DVec3) -> DVec3 {
    DVec3::new(vector.x, vector.z, -vector.y)
}

/// Centre and size of a box.
fn extent(bounds: &Aabb) -> (DVec3, DVec3) {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    (0.5 * (min + max), max - min)
}

#[cfg(test)]
mod tests {
    use scene::{Material, Mesh};

    use super::*;
    use crate::scenes::known::Known;

    /// The box of the Sponza of Dabrovic, with as many triangles, of which all but four say nothing.
    fn original(known: &KnownScene, place: impl Fn(Vec3) -> Vec3) -> Scene {
        let Aabb { min, max } = known.bounds();
        let corners = [min, Vec3::new(max.x, min.y, min.z), Vec3::new(min.x, max.y, min.z), max];
        let positions = corners.map(place).to_vec();
        let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let triangles = faces.into_iter().cycle().take(known.triangles).collect();
        let mesh = Mesh::new(positions, triangles, 0).unwrap();
        let white = Material { name: String::new(), base_color: [1.0; 3] };
        Scene { meshes: vec![mesh], materials: vec![white], ..Scene::default() }
    }

    #[test]
    fn either_axis_may_be_up() {
        let known = Known::load().unwrap();
        let sponza = known.scenes.iter().find(|known| known.file.starts_with("sponza_dabrovic")).unwrap();
        let y_up = |p: Vec3| 39.37 * p + Vec3::new(3.0, -2.0, 100.0);
        let z_up = |p: Vec3| 39.37 * Vec3::new(p.x, -p.z, p.y) + Vec3::new(3.0, -2.0, 100.0);
        let lying = |p: Vec3| Vec3::new(p.y, p.x, p.z);
        let (a, b) = (original(sponza, y_up), original(sponza, z_up));
        for scene in [&a, &b] {
            let fit = Fit::find(scene, sponza).unwrap();
            let placed: Vec<Vec3> = scene.meshes[0].positions().iter().map(|p| fit.apply(*p)).collect();
            let wanted = original(sponza, |p| p);
            for (placed, wanted) in placed.iter().zip(wanted.meshes[0].positions()) {
                assert!(placed.distance(*wanted) < 1e-4, "{placed} {wanted}");
            }
        }
        assert!(Fit::find(&original(sponza, lying), sponza).is_none());
    }
}
