//! The edges at which the shadow volume of a mesh has its side faces.
//!
//! Every triangle is turned towards the light, so that each blocks it once and no two cancel: what lies in shadow is
//! where the winding number of the volume is positive, whatever the mesh, and its winding says nothing. An edge along
//! which as many turned triangles run one way as the other bounds nothing; every other one is a silhouette edge. On a
//! closed mesh these are the edges between triangles that face the light and triangles that do not.

use scene::Light;

use crate::adjacency::{Adjacency, Edge, NO_SIDE};

/// An edge where the light's view of a mesh ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SilhouetteEdge {
    /// Indices of its ends into [`Adjacency::positions`], in the direction in which the turned triangles run.
    pub vertices: [u32; 2],
    /// How many more turned triangles run that way than the other: 1 or 2.
    pub count: i32,
}

/// The silhouette of a mesh as a light sees it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Silhouette {
    /// Its edges, in the order of [`Adjacency::edges`].
    pub edges: Vec<SilhouetteEdge>,
    facing: Vec<bool>,
}

impl Silhouette {
    /// The silhouette of a mesh as `light` sees it; a spot counts as a point, since its cone is no matter of the mesh.
    pub fn of(mesh: &Adjacency, light: &Light) -> Self {
        let facing: Vec<bool> = mesh.triangles().iter().map(|&t| faces(mesh, t, light)).collect();
        let edges = mesh.edges().iter().filter_map(|edge| silhouette_edge(edge, &facing)).collect();
        Self { edges, facing }
    }

    /// Whether a triangle of the mesh faces the light as it is wound; those in the light's plane count as facing it.
    pub fn is_facing(&self, triangle: usize) -> bool {
        self.facing.get(triangle).copied().unwrap_or(false)
    }

    /// Whether the shadow volume has no hole: turned triangles, the side faces on the silhouette, and the triangles once
    /// more at infinity use every edge equally often in both directions.
    ///
    /// Counts the edges of the triangles themselves, not those of `mesh`, which must be the one that the silhouette is
    /// of. The rim at infinity is the near one's image and is not counted again.
    pub fn is_closed(&self, mesh: &Adjacency) -> bool {
        let mut rim = Vec::with_capacity(3 * mesh.triangles().len() + self.edges.len());
        for (i, &[a, b, c]) in mesh.triangles().iter().enumerate() {
            let turn = if self.is_facing(i) { 1 } else { -1 };
            rim.extend([(a, b), (b, c), (c, a)].map(|(from, to)| directed(from, to, turn)));
        }
        let mut upright = Vec::with_capacity(2 * self.edges.len());
        for &SilhouetteEdge { vertices: [a, b], count } in &self.edges {
            // a side face runs from b to a, from a to infinity, and from there back to b
            rim.push(directed(b, a, count));
            upright.extend([(a, count), (b, -count)]);
        }
        cancels(rim) && cancels(upright)
    }
}

/// Whether a triangle faces the light, in `f64`.
fn faces(mesh: &Adjacency, triangle: [u32; 3], light: &Light) -> bool {
    let [a, b, c] = triangle.map(|i| mesh.positions()[i as usize].as_dvec3());
    let normal = (b - a).cross(c - a);
    let to_light = match light {
        Light::Point(light) => light.position.as_dvec3() - a,
        Light::Spot(light) => light.position.as_dvec3() - a,
        Light::Directional(light) => -light.direction.as_dvec3(),
    };
    normal.dot(to_light) >= 0.0
}

fn silhouette_edge(edge: &Edge, facing: &[bool]) -> Option<SilhouetteEdge> {
    let run = |side: u32| match (side, facing.get(side as usize / 2)) {
        (NO_SIDE, _) | (_, None) => 0,
        (_, Some(&facing)) => {
            if facing == (side & 1 == 0) {
                1
            } else {
                -1
            }
        }
    };
    let [a, b] = edge.vertices;
    match run(edge.sides[0]) + run(edge.sides[1]) {
        0 => None,
        count if count > 0 => Some(SilhouetteEdge { vertices: [a, b], count }),
        count => Some(SilhouetteEdge { vertices: [b, a], count: -count }),
    }
}

/// `count` uses of an edge, by its ends in order.
fn directed(from: u32, to: u32, count: i32) -> (u64, i32) {
    let ends = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
    (ends, if from < to { count } else { -count })
}

/// Whether the counts of every key sum to zero.
fn cancels<K: Ord + Copy>(mut counts: Vec<(K, i32)>) -> bool {
    counts.sort_unstable();
    counts
        .chunk_by(|a, b| a.0 == b.0)
        .all(|same| same.iter().map(|&(_, count)| i64::from(count)).sum::<i64>() == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scene::{DirectionalLight, PointLight};

    fn lights() -> [Light; 4] {
        let point = |p| Light::Point(PointLight::new(p, Vec3::ONE).unwrap());
        let sun = DirectionalLight::new(Vec3::new(-1.0, -2.0, -0.5), Vec3::ONE).unwrap();
        [
            point(Vec3::new(2.0, 3.0, 4.0)),
            point(Vec3::new(-3.0, 0.2, 0.3)),
            point(Vec3::splat(0.1)),
            Light::Directional(sun),
        ]
    }

    fn mesh(faces: &[[usize; 3]]) -> Adjacency {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
        Adjacency::new(faces.iter().map(|f| f.map(|i| corners[i]))).unwrap()
    }

    /// Edges as pairs of positions' indices, whichever way, with counts; sorted.
    fn undirected(silhouette: &Silhouette) -> Vec<([u32; 2], i32)> {
        let mut edges: Vec<_> = silhouette
            .edges
            .iter()
            .map(|e| ([e.vertices[0].min(e.vertices[1]), e.vertices[0].max(e.vertices[1])], e.count))
            .collect();
        edges.sort_unstable();
        edges
    }

    const TETRAHEDRON: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn every_volume_is_closed() {
        let flipped = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        let mixed = [TETRAHEDRON[0], flipped[1], flipped[2], TETRAHEDRON[3]];
        let doubled: Vec<_> = TETRAHEDRON.iter().flat_map(|&f| [f, f, [f[0], f[2], f[1]]]).collect();
        let meshes: [&[[usize; 3]]; 9] = [
            &TETRAHEDRON,
            &flipped,
            &mixed,
            &doubled,
            &TETRAHEDRON[..3],
            &TETRAHEDRON[..1],
            &[[0, 1, 2], [0, 1, 3], [1, 0, 4]],
            &[[0, 1, 2], [0, 1, 3], [0, 1, 4]],
            &[],
        ];
        for (i, faces) in meshes.into_iter().enumerate() {
            let mesh = mesh(faces);
            for light in &lights() {
                let silhouette = Silhouette::of(&mesh, light);
                assert!(silhouette.is_closed(&mesh), "mesh {i}, {light:?}");
                assert!(silhouette.edges.iter().all(|edge| [1, 2].contains(&edge.count)), "mesh {i}");
            }
            let seen = Silhouette::of(&mesh, &lights()[0]);
            assert_eq!(seen.edges.is_empty(), faces.is_empty(), "mesh {i}");
        }
    }

    #[test]
    fn a_hole_is_seen() {
        let mesh = mesh(&TETRAHEDRON);
        let whole = Silhouette::of(&mesh, &lights()[0]);
        for missing in 0..whole.edges.len() {
            let mut torn = whole.clone();
            torn.edges.remove(missing);
            assert!(!torn.is_closed(&mesh));
            let mut turned = whole.clone();
            turned.edges[missing].vertices.reverse();
            assert!(!turned.is_closed(&mesh));
        }
        let mut blind = whole;
        blind.facing[0] ^= true;
        assert!(!blind.is_closed(&mesh));
    }

    #[test]
    fn a_closed_mesh_keeps_the_edges_between_lit_and_dark_faces() {
        // seen from far along +X+Y+Z only the slanted face is lit: its three edges, counted from both sides
        let silhouette = Silhouette::of(&mesh(&TETRAHEDRON), &lights()[0]);
        let slanted = mesh(&TETRAHEDRON[3..]);
        assert_eq!(silhouette.edges.len(), 3);
        assert!(silhouette.edges.iter().all(|edge| edge.count == 2));
        assert_eq!(Silhouette::of(&slanted, &lights()[0]).edges.len(), 3);
        // winding is no matter
        let mixed = TETRAHEDRON.map(|[a, b, c]| if a == 0 && b == 1 { [a, c, b] } else { [a, b, c] });
        assert_eq!(undirected(&Silhouette::of(&mesh(&mixed), &lights()[0])).len(), 3);
        // from inside no face is lit, and every edge is between two of a kind
        let inside = Silhouette::of(&mesh(&TETRAHEDRON), &lights()[2]);
        assert_eq!(inside.edges, []);
    }

    #[test]
    fn a_light_in_a_triangles_plane_is_faced_whichever_way_it_is_wound() {
        let light = Light::Point(PointLight::new(Vec3::new(3.0, 5.0, 0.0), Vec3::ONE).unwrap());
        for faces in [[[0, 1, 2]], [[0, 2, 1]]] {
            let mesh = mesh(&faces);
            let silhouette = Silhouette::of(&mesh, &light);
            assert!(silhouette.is_facing(0) && silhouette.is_closed(&mesh) && silhouette.edges.len() == 3);
        }
        assert!(!Silhouette::default().is_facing(7));
    }
}
