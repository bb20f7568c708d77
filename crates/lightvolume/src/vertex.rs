//! Vertices of a light volume, and where they are.

use glam::{DVec3, DVec4};
use scene::DRay;
use shadowmap::{Face, Projection, ProjectionKind};

/// What a vertex is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u16)]
pub enum VertexKind {
    /// A node of the map: a texel centre at its depth.
    Surface = 0,
    /// The light, in which the walls of a perspective volume meet.
    Apex = 1,
    /// A point of the far plane, under a node or, for the cap's middle, between nodes.
    Far = 2,
}

/// A vertex: a place on the map and a height above it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Vertex {
    /// Column of the node; texel centres have integers. 0 at the apex.
    pub x: f32,
    /// Row of the node. 0 at the apex.
    pub y: f32,
    /// What is linear over triangles, as a GPU has it: 1/depth in perspective and cube maps (units: m⁻¹; 0 at infinity),
    /// −depth in orthographic ones (units: m). 1 at the apex.
    pub height: f32,
    /// Planar depth as the map has it, in an orthographic map no farther than the far plane; units: m. 0 at the apex.
    pub depth: f32,
    /// What the vertex is.
    pub kind: VertexKind,
    /// Face of the map.
    pub face: u16,
}

/// A point in the coordinates in which rays meet triangles: a homogeneous vector whose fourth component is its height.
///
/// Perspective and orthographic maps: (U, V, W, h) with nodes at (x, y, 1, h). Cubes: the direction from the light times
/// the number of texels a side, and the height 1/depth. The light is (0, 0, 0, 1) in each, and every straight line of
/// the world is a straight line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) place: DVec3,
    pub(crate) height: f64,
}

/// How vertices and rays come into those coordinates, and vertices into the world.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    projection: Projection,
    size: (u32, u32),
    kind: ProjectionKind,
}

impl Frame {
    pub(crate) fn new(projection: &Projection, size: (u32, u32)) -> Self {
        Self { projection: projection.clone(), size, kind: projection.kind() }
    }

    pub(crate) fn projection(&self) -> &Projection {
        &self.projection
    }

    pub(crate) fn size(&self) -> (u32, u32) {
        self.size
    }

    fn face(&self, vertex: &Vertex) -> &Face {
        let faces = self.projection.faces();
        &faces[usize::from(vertex.face).min(faces.len() - 1)]
    }

    /// Height in `f64`, straight from the depth: that of the map's own surface.
    fn height(&self, vertex: &Vertex) -> f64 {
        let depth = f64::from(vertex.depth);
        if self.kind == ProjectionKind::Orthographic { -depth } else { 1.0 / depth }
    }

    /// A vertex in the coordinates of rays.
    pub(crate) fn point(&self, vertex: &Vertex) -> Point {
        if vertex.kind == VertexKind::Apex {
            return Point { place: DVec3::ZERO, height: 1.0 };
        }
        let (x, y) = (f64::from(vertex.x), f64::from(vertex.y));
        let place = if self.kind == ProjectionKind::Cube {
            let (face, n) = (self.face(vertex), f64::from(self.size.0));
            // integers
            face.forward * n + face.right * (2.0 * x + 1.0 - n) + face.down * (2.0 * y + 1.0 - n)
        } else {
            DVec3::new(x, y, 1.0)
        };
        Point { place, height: self.height(vertex) }
    }

    /// A view ray in the same coordinates: its origin, and what a metre along it adds.
    pub(crate) fn ray(&self, ray: &DRay) -> [Point; 2] {
        let face = &self.projection.faces()[0];
        let from = ray.origin - face.origin;
        if self.kind == ProjectionKind::Cube {
            let n = f64::from(self.size.0);
            return [Point { place: from * n, height: 1.0 }, Point { place: ray.direction * n, height: 0.0 }];
        }
        let (columns, rows) = (f64::from(self.size.0), f64::from(self.size.1));
        let place = |w: DVec3, one: f64| {
            let z = w.dot(face.forward);
            let (x, y) = (w.dot(face.right) / face.half.x, w.dot(face.down) / face.half.y);
            let w = if face.perspective { z } else { one };
            // texel centres at integers: half a texel off
            let place = DVec3::new(0.5 * columns * (w + x) - 0.5 * w, 0.5 * rows * (w + y) - 0.5 * w, w);
            Point { place, height: if face.perspective { one } else { -z } }
        };
        [place(from, 1.0), place(ray.direction, 0.0)]
    }

    /// What a metre along any ray adds at most, by component.
    pub(crate) fn most(&self) -> Point {
        let (columns, rows) = (f64::from(self.size.0), f64::from(self.size.1));
        let half = self.projection.faces()[0].half;
        match self.kind {
            ProjectionKind::Cube => Point { place: DVec3::splat(columns), height: 0.0 },
            ProjectionKind::Perspective => Point {
                place: DVec3::new(
                    0.5 * columns * (1.0 + 1.0 / half.x),
                    0.5 * rows * (1.0 + 1.0 / half.y),
                    1.0,
                ),
                height: 0.0,
            },
            ProjectionKind::Orthographic => {
                Point { place: DVec3::new(0.5 * columns / half.x, 0.5 * rows / half.y, 0.0), height: 1.0 }
            }
        }
    }

    /// Homogeneous position of a vertex in the world, the position times w in xyz; w = 0 for a point at infinity, which
    /// lies that way. Units: m where w is 1.
    pub(crate) fn world(&self, vertex: &Vertex) -> DVec4 {
        let face = self.face(vertex);
        if vertex.kind == VertexKind::Apex {
            return face.origin.extend(1.0);
        }
        let (u, v) = (f64::from(vertex.x) + 0.5, f64::from(vertex.y) + 0.5);
        if !face.perspective {
            return face.unproject(u, v, f64::from(vertex.depth), self.size).extend(1.0);
        }
        let direction = face.unproject(u, v, 1.0, self.size) - face.origin;
        let height = self.height(vertex);
        (face.origin * height + direction).extend(height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn vertex(x: f32, y: f32, depth: f32, face: u16) -> Vertex {
        Vertex { x, y, height: 0.0, depth, kind: VertexKind::Surface, face }
    }

    #[test]
    fn a_ray_to_a_vertex_meets_it_in_every_frame() {
        let (at, forward) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -1.0, 0.2));
        let half = DVec2::new(0.7, 1.3);
        let frames = [
            (Projection::perspective(at, forward, DVec3::X, half).unwrap(), 0),
            (Projection::orthographic(at, forward, DVec3::X, half).unwrap(), 0),
            (Projection::cube(at).unwrap(), 3),
        ];
        for (projection, face) in frames {
            let frame = Frame::new(&projection, (7, 7));
            let vertex = vertex(2.0, 5.0, 4.0, face);
            let world = frame.world(&vertex);
            let expected = projection.faces()[usize::from(face)].unproject(2.5, 5.5, 4.0, (7, 7));
            assert!((world.truncate() / world.w - expected).length() < 1e-12);
            let origin = DVec3::new(-2.0, 0.5, 1.0);
            let direction = (expected - origin).normalize();
            let t = (expected - origin).length();
            let [from, along] = frame.ray(&DRay { origin, direction });
            let (place, height) = (from.place + t * along.place, from.height + t * along.height);
            let point = frame.point(&vertex);
            // the same up to a factor
            let factor = place.length() / point.place.length();
            assert!((place - factor * point.place).length() < 1e-12 * place.length(), "{projection:?}");
            assert!((height - factor * point.height).abs() < 1e-12, "{projection:?}");
        }
    }

    #[test]
    fn infinity_is_a_direction() {
        let projection = Projection::perspective(DVec3::ONE, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        let frame = Frame::new(&projection, (2, 2));
        let world = frame.world(&vertex(0.0, 1.0, f32::INFINITY, 0));
        assert_eq!(world, DVec4::new(-0.5, -0.5, -1.0, 0.0));
    }
}
