//! Meshes piece by piece: patches, boxes, tubes and turned shapes, counter-clockwise seen from outside.

use glam::{Affine3A, Vec2, Vec3};

/// A mesh under construction; lengths in m.
#[derive(Debug, Clone, Default)]
pub(super) struct MeshBuilder {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl MeshBuilder {
    pub(super) fn vertex(&mut self, p: Vec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    pub(super) fn triangle(&mut self, a: u32, b: u32, c: u32) {
        self.triangles.push([a, b, c]);
    }

    /// A flat or folded quadrangle with vertices of its own.
    pub(super) fn quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// A copy of `other` under `transform`.
    pub(super) fn append(&mut self, other: &Self, transform: Affine3A) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|&p| transform.transform_point3(p)));
        // a mirror image turns every triangle inside out
        let mirrored = transform.matrix3.determinant() < 0.0;
        self.triangles.extend(other.triangles.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a + base, b + base, c + base];
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }

    /// An open patch of `nu` × `nv` quadrangles through `at(i, j)`; outside is where ∂i × ∂j points.
    pub(super) fn grid(&mut self, nu: usize, nv: usize, at: impl Fn(usize, usize) -> Vec3) {
        let row = |b: &mut Self, j| (0..=nu).map(|i| b.vertex(at(i, j))).collect::<Vec<_>>();
        let mut below = row(self, 0);
        for j in 1..=nv {
            let above = row(self, j);
            self.band(&below, &above, false);
            below = above;
        }
    }

    /// Joins two rows of vertices by quadrangles; outside is where (along the row) × (from `a` to `b`) points.
    pub(super) fn band(&mut self, a: &[u32], b: &[u32], closed: bool) {
        let n = a.len();
        for i in 0..if closed { n } else { n.saturating_sub(1) } {
            let k = (i + 1) % n;
            self.triangle(a[i], a[k], b[k]);
            self.triangle(a[i], b[k], b[i]);
        }
    }

    /// Closes a ring with a fan around `apex`; outside is where the ring runs counter-clockwise.
    pub(super) fn fan(&mut self, ring: &[u32], apex: Vec3) {
        let apex = self.vertex(apex);
        for i in 0..ring.len() {
            self.triangle(ring[i], ring[(i + 1) % ring.len()], apex);
        }
    }

    /// A closed body through rings of as many vertices each, its ends closed by fans; rings run counter-clockwise
    /// seen from the last one's side.
    pub(super) fn loft(&mut self, rings: &[Vec<Vec3>]) {
        let mut below: Vec<u32> = Vec::new();
        for (k, points) in rings.iter().enumerate() {
            let ring: Vec<u32> = points.iter().map(|&p| self.vertex(p)).collect();
            let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f32;
            if k == 0 {
                let backwards: Vec<u32> = ring.iter().rev().copied().collect();
                self.fan(&backwards, middle);
            } else {
                self.band(&below, &ring, true);
            }
            if k + 1 == rings.len() {
                self.fan(&ring, middle);
            }
            below = ring;
        }
    }

    /// A closed box between two corners: 12 triangles.
    pub(super) fn cuboid(&mut self, min: Vec3, max: Vec3) {
        let corner = |i: u32| {
            let pick = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            Vec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
        };
        let base = self.positions.len() as u32;
        self.positions.extend((0..8).map(corner));
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            self.triangle(base + a, base + b, base + c);
            self.triangle(base + a, base + c, base + d);
        }
    }

    /// A closed box of the given size around `center`.
    pub(super) fn block(&mut self, center: Vec3, size: Vec3) {
        self.cuboid(center - 0.5 * size, center + 0.5 * size);
    }

    /// A capped tube along `path` with `radius(k)` at its k-th point: 2·`sides`·points triangles.
    pub(super) fn tube(&mut self, path: &[Vec3], sides: usize, radius: impl Fn(usize) -> f32) {
        let Some(last) = path.len().checked_sub(1) else { return };
        let forward = |k: usize| (path[(k + 1).min(last)] - path[k.saturating_sub(1)]).normalize_or(Vec3::Y);
        let mut across = forward(0).any_orthonormal_vector();
        let rings: Vec<Vec<Vec3>> = (0..=last)
            .map(|k| {
                // carried along instead of chosen anew at each point, so that the tube does not twist
                let forward = forward(k);
                across =
                    across.reject_from_normalized(forward).normalize_or(forward.any_orthonormal_vector());
                let up = forward.cross(across);
                let angle = |i: usize| (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
                let point = |(sin, cos): (f32, f32)| path[k] + radius(k) * (cos * across + sin * up);
                (0..sides).map(|i| point(angle(i))).collect()
            })
            .collect();
        self.loft(&rings);
    }

    /// A tube of one radius between two points: 4·`sides` triangles.
    pub(super) fn rod(&mut self, a: Vec3, b: Vec3, radius: f32, sides: usize) {
        self.tube(&[a, b], sides, |_| radius);
    }

    /// A shape turned around the Y axis from (radius, height) pairs, bottom to top; `flute(i)` scales the radius at
    /// the i-th side. Ends of radius 0 become poles, the others are closed by flat fans.
    pub(super) fn lathe(&mut self, profile: &[Vec2], sides: usize, flute: impl Fn(usize) -> f32) {
        let mut below: Option<Vec<u32>> = None;
        let (mut pole, mut top) = (None, 0.0);
        for &Vec2 { x: radius, y } in profile {
            top = y;
            if radius <= 0.0 {
                if let Some(ring) = below.take() {
                    self.fan(&ring, Vec3::new(0.0, y, 0.0));
                }
                pole = Some(y);
                continue;
            }
            let ring: Vec<u32> = (0..sides)
                .map(|i| {
                    let (sin, cos) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
                    let r = radius * flute(i);
                    self.vertex(Vec3::new(r * cos, y, -r * sin))
                })
                .collect();
            if let Some(below) = &below {
                self.band(below, &ring, true);
            } else {
                let backwards: Vec<u32> = ring.iter().rev().copied().collect();
                self.fan(&backwards, Vec3::new(0.0, pole.take().unwrap_or(y), 0.0));
            }
            below = Some(ring);
        }
        if let Some(ring) = below {
            self.fan(&ring, Vec3::new(0.0, top, 0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey;
    use super::*;

    fn closed(build: impl Fn(&mut MeshBuilder)) -> super::super::topology::Survey {
        let mut b = MeshBuilder::default();
        build(&mut b);
        survey(&b.positions, &b.triangles)
    }

    #[test]
    fn closed_pieces_are_closed_and_face_outwards() {
        let bend: Vec<Vec3> = (0..9)
            .map(|k| Vec3::new((0.4 * k as f32).cos(), 0.3 * k as f32, (0.4 * k as f32).sin()))
            .collect();
        let spindle = [(0.0, 0.0), (0.5, 0.5), (0.2, 1.0), (0.0, 1.5)].map(Vec2::from);
        let post = [(0.5, 0.0), (0.2, 1.0), (0.4, 1.5)].map(Vec2::from);
        for piece in [
            closed(|b| b.cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0))),
            closed(|b| b.tube(&bend, 7, |_| 0.1)),
            closed(|b| b.rod(Vec3::ZERO, Vec3::Y, 0.1, 5)),
            closed(|b| b.lathe(&spindle, 9, |_| 1.0)),
            closed(|b| b.lathe(&post, 8, |i| if i % 2 == 0 { 1.0 } else { 0.8 })),
        ] {
            assert!(piece.is_closed_manifold(), "{piece:?}");
            assert_eq!((piece.components, piece.euler), (1, 2));
            assert!(piece.volume > 0.0, "{piece:?}");
        }
    }

    #[test]
    fn volumes_by_hand() {
        let six = closed(|b| b.cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0))).volume;
        assert!((six - 6.0).abs() < 1e-6);
        let cylinder = closed(|b| b.rod(Vec3::ZERO, 2.0 * Vec3::X, 0.5, 64)).volume;
        assert!((cylinder - 0.5 * std::f64::consts::PI).abs() < 5e-3);
    }

    #[test]
    fn a_mirrored_copy_still_faces_outwards() {
        let mut one = MeshBuilder::default();
        one.block(Vec3::ONE, Vec3::ONE);
        let mirrored = closed(|b| b.append(&one, Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))));
        assert!(mirrored.is_closed_manifold() && mirrored.volume > 0.0);
    }
}
