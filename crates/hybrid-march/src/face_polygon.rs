//! A side face of a shadow volume as a polygon, and what of it a view sees.
//!
//! Corners are homogeneous: a direction is a corner that is infinitely far away, so that a face without end is a polygon
//! of four corners, and clipping asks nothing of where they are.

use glam::{DVec2, DVec3, DVec4};

use crate::shadow_volume::ShadowVolume;

/// How much wider than the image the pyramid is that polygons are clipped to, so that rounding is no matter to it.
const WIDER: f64 = 1.001;

/// The ends of an edge, and the same infinitely far away, going round; relative to the volume's origin. `None` for an edge
/// that points at the light: its face has no area.
pub(crate) fn polygon_of(volume: &ShadowVolume, ends: [DVec3; 2]) -> Option<[DVec4; 4]> {
    let [a, b] = ends;
    let is_flat = volume.direction.unwrap_or(a).cross(b - a) == DVec3::ZERO;
    (!is_flat).then(|| [a.extend(1.0), b.extend(1.0), far(volume, b), far(volume, a)])
}

/// Where the shadow of a point ends.
fn far(volume: &ShadowVolume, end: DVec3) -> DVec4 {
    volume.direction.unwrap_or(end).extend(0.0)
}

/// The sides of the slab around a face: as much thicker at each end as `thickness` says (in m), to both sides and over the
/// ends of the edge; the last side is infinitely far away.
pub(crate) fn thickened(volume: &ShadowVolume, ends: [DVec3; 2], thickness: [f64; 2]) -> [[DVec4; 4]; 6] {
    let [a, b] = ends;
    let normal = volume.direction.unwrap_or(a).cross(b - a).normalize_or_zero();
    let along = (b - a).normalize_or_zero();
    let near = [-1.0, 1.0]
        .map(|side| [a + thickness[0] * (side * normal - along), b + thickness[1] * (side * normal + along)]);
    let [[fa, fb], [ga, gb]] = near.map(|side| side.map(|end| far(volume, end)));
    let [[a, b], [c, d]] = near.map(|side| side.map(|end| end.extend(1.0)));
    [[a, b, fb, fa], [c, d, gb, ga], [a, c, ga, fa], [b, d, gb, fb], [a, c, d, b], [fa, ga, gb, fb]]
}

/// A polygon in the camera's axes (right, up, forward), with the eye at the origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeenPolygon {
    corners: [DVec4; 4],
    /// normal · p = offset on the polygon's plane, a unit vector; 0 if the polygon is infinitely far away.
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
    /// Distance of the farthest finite corner from the eye; units: m.
    pub(crate) reach: f64,
}

impl SeenPolygon {
    /// The polygon of four corners in a plane, going round, the first two finite if any is.
    pub(crate) fn new(corners: [DVec4; 4]) -> Self {
        let [a, b, _, last] = corners;
        let finite = corners.iter().filter(|corner| corner.w > 0.0);
        let reach = finite.map(|corner| corner.truncate().length()).fold(0.0, f64::max);
        // a length is no matter to a direction, but it is to rounding
        let scaled =
            |p: DVec4| if p.w > 0.0 { p } else { (reach * p.truncate().normalize_or_zero()).extend(0.0) };
        let (nearer, to_last) = (if a.length() < b.length() { a } else { b }, (last - last.w * a).truncate());
        let normal = if a.w > 0.0 {
            (b - a).truncate().normalize_or_zero().cross(to_last.normalize_or_zero()).normalize_or_zero()
        } else {
            DVec3::ZERO
        };
        Self { corners: corners.map(scaled), normal, offset: normal.dot(nearer.truncate()), reach }
    }

    /// Whether the eye is inside the slab of these sides, or on it.
    pub(crate) fn enclose_eye(sides: &[Self; 6]) -> bool {
        let inner =
            sides[0].corners.iter().chain(&sides[1].corners).map(|corner| corner.truncate()).sum::<DVec3>();
        let inner = 0.25 * inner;
        sides[..5].iter().all(|side| {
            let inwards = (side.normal.dot(inner) - side.offset).signum();
            -inwards * side.offset >= 0.0
        })
    }

    /// Writes the part of the polygon before the eye and in the image to `outline` (cleared first), homogeneous, with
    /// z > 0; `corner` holds the tangents at the image's upper left corner.
    pub(crate) fn clip(&self, corner: DVec2, outline: &mut Vec<DVec4>) {
        outline.clear();
        outline.extend(self.corners);
        let (wide, high) = (WIDER * corner.x.abs(), WIDER * corner.y.abs());
        // the pyramid's sides; its inside has z > 0
        for side in [
            DVec3::new(1.0, 0.0, wide),
            DVec3::new(-1.0, 0.0, wide),
            DVec3::new(0.0, 1.0, high),
            DVec3::new(0.0, -1.0, high),
        ] {
            clip_at(side, outline);
        }
        outline.retain(|p| p.z > 0.0);
    }
}

/// Cuts off what of a convex polygon lies behind a plane through the eye (Sutherland and Hodgman 1974).
fn clip_at(side: DVec3, outline: &mut Vec<DVec4>) {
    let Some(&last) = outline.last() else { return };
    let count = outline.len();
    let mut before = last;
    for k in 0..count {
        let here = outline[k];
        let (from, to) = (side.dot(before.truncate()), side.dot(here.truncate()));
        if (from >= 0.0) != (to >= 0.0) {
            outline.push(before.lerp(here, from / (from - to)));
        }
        if to >= 0.0 {
            outline.push(here);
        }
        before = here;
    }
    outline.drain(..count);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjacency::Adjacency;
    use glam::Vec3;
    use scene::{Light, PointLight};

    /// The edge from (−1, 1, 0) to (1, 1, 0) under a lamp at (0, 2, 0), as an eye at `eye` sees it that looks along +Z.
    fn seen(eye: DVec3, corners: impl Fn(&ShadowVolume, [DVec3; 2]) -> Vec<[DVec4; 4]>) -> Vec<SeenPolygon> {
        let lamp = Light::Point(PointLight::new(Vec3::new(0.0, 2.0, 0.0), Vec3::ONE).unwrap());
        let triangle = [Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, -1.0)];
        let volume = ShadowVolume::new(&Adjacency::new([triangle]).unwrap(), &lamp);
        let ends = [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0)];
        let from_eye = volume.origin - eye;
        let place = |p: DVec4| (p.truncate() + p.w * from_eye).extend(p.w);
        corners(&volume, ends).into_iter().map(|polygon| SeenPolygon::new(polygon.map(place))).collect()
    }

    #[test]
    fn a_face_without_end_is_clipped_to_the_image() {
        let face =
            seen(DVec3::new(0.0, 0.0, -2.0), |volume, ends| vec![polygon_of(volume, ends).unwrap()])[0];
        assert!((face.normal.z.abs() - 1.0).abs() < 1e-12 && (face.offset.abs() - 2.0).abs() < 1e-12);
        let mut outline = Vec::new();
        face.clip(DVec2::new(-1.0, 1.0), &mut outline);
        assert!(outline.len() >= 4);
        for p in &outline {
            // in the plane z = 2, in the image, below the edge and under the lamp
            let (x, y) = (p.x / p.w, p.y / p.w);
            assert!((p.z / p.w - 2.0).abs() < 1e-12, "{p}");
            assert!(
                x.abs() <= 2.01 && y.abs() <= 2.01 && y <= 1.0 + 1e-12 && x.abs() <= 2.0 - y + 1e-12,
                "{p}"
            );
        }
        // behind the eye nothing is left
        let behind =
            seen(DVec3::new(0.0, 0.0, 2.0), |volume, ends| vec![polygon_of(volume, ends).unwrap()])[0];
        behind.clip(DVec2::new(-1.0, 1.0), &mut outline);
        assert!(outline.is_empty(), "{outline:?}");
    }

    #[test]
    fn a_slab_encloses_what_is_near_its_face() {
        let encloses = |x: f64, y: f64, z: f64| {
            let slab = seen(DVec3::new(x, y, z), |volume, ends| thickened(volume, ends, [0.1, 0.1]).to_vec());
            SeenPolygon::enclose_eye(&slab.try_into().unwrap())
        };
        // 0.1 m at the edge, and more below it
        assert!(encloses(0.0, 0.99, 0.09) && encloses(0.0, 0.99, -0.09) && !encloses(0.0, 0.99, 0.12));
        assert!(encloses(0.0, -8.0, 0.9) && !encloses(0.0, -8.0, 1.2));
        assert!(encloses(1.05, 0.98, 0.0) && !encloses(1.2, 0.98, 0.0));
        assert!(!encloses(0.0, 1.01, 0.0) && !encloses(0.0, 3.0, 0.0));
    }

    #[test]
    fn an_edge_that_points_at_the_light_has_no_face() {
        let none = seen(DVec3::ZERO, |volume, _| {
            let ends = [DVec3::new(1.0, -1.0, 0.0), DVec3::new(2.0, -2.0, 0.0)];
            polygon_of(volume, ends).into_iter().collect()
        });
        assert!(none.is_empty());
    }
}
