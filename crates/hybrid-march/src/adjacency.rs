//! Which triangles meet along which edge: what a light's silhouette is found from.
//!
//! A shadow volume has its side faces on the edges where its caps end (Wyman and Ramsey 2008, section 3.1), so a mesh is
//! asked for edges, and for the triangles on both sides. Vertices of the same position are one, whichever mesh they come
//! from; nothing else is asked of the triangles, which may be open, doubled, wound either way or meet by threes. The
//! arrays are plain, because a GPU reads the same.

use glam::Vec3;
use scene::Scene;
use thiserror::Error;

/// A side of an edge where there is no triangle.
pub const NO_SIDE: u32 = u32::MAX;

/// Most triangles: a side names a triangle and its direction in 32 bits, and leaves room for [`NO_SIDE`].
const MOST_TRIANGLES: usize = 1 << 30;

/// What cannot be welded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AdjacencyError {
    /// A position is not finite.
    #[error("position {0} is not finite")]
    NotFinite(usize),
    /// More triangles than a side can name.
    #[error("{0} triangles; at most 2^30 can be indexed")]
    TooManyTriangles(usize),
    /// More positions than 32 bits index.
    #[error("{0} positions; at most 2^32 - 1 can be indexed")]
    TooManyPositions(usize),
}

/// An edge and the triangles on it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Indices of its ends into [`Adjacency::positions`], the smaller first.
    pub vertices: [u32; 2],
    /// The triangles on it, each as 2·triangle, plus 1 where that triangle runs from `vertices[1]` to `vertices[0]`;
    /// [`NO_SIDE`] where there is none, which is never so for the first.
    pub sides: [u32; 2],
}

/// A mesh whose vertices of equal position are one, with its edges.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adjacency {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<Edge>,
}

impl Adjacency {
    /// The adjacency of any triangles, given by their corners (in m).
    ///
    /// # Errors
    /// [`AdjacencyError`] if a corner is not finite (its number is that of the corner, three a triangle), or past 2³⁰
    /// triangles.
    pub fn new(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Result<Self, AdjacencyError> {
        let corners: Vec<Vec3> = triangles.into_iter().flatten().collect();
        let count = corners.len() / 3;
        check_count(count)?;
        Self::indexed(&corners, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]))
    }

    /// The adjacency of all meshes of a scene as one.
    ///
    /// # Errors
    /// [`AdjacencyError`] past 2³⁰ triangles or 2³² − 1 vertices.
    pub fn of_scene(scene: &Scene) -> Result<Self, AdjacencyError> {
        check_count(scene.triangle_count())?;
        let positions: Vec<Vec3> = scene.meshes.iter().flat_map(|mesh| mesh.positions()).copied().collect();
        let mut base = 0;
        let triangles = scene.meshes.iter().flat_map(move |mesh| {
            let first = base;
            base += mesh.positions().len() as u32;
            mesh.triangles().iter().map(move |triangle| triangle.map(|i| i + first))
        });
        Self::indexed(&positions, triangles)
    }

    fn indexed(
        positions: &[Vec3],
        triangles: impl Iterator<Item = [u32; 3]>,
    ) -> Result<Self, AdjacencyError> {
        if positions.len() >= u32::MAX as usize {
            return Err(AdjacencyError::TooManyPositions(positions.len()));
        }
        if let Some(at) = positions.iter().position(|p| !p.is_finite()) {
            return Err(AdjacencyError::NotFinite(at));
        }
        let (positions, welded) = weld(positions);
        let triangles: Vec<[u32; 3]> = triangles
            .map(|triangle| triangle.map(|i| welded[i as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let edges = edges_of(&triangles);
        Ok(Self { positions, triangles, edges })
    }

    /// Positions, no two of them equal; units: m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Triangles as indices into [`Adjacency::positions`], in the order in which they were given; those of which two
    /// corners coincide are left out.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Edges, sorted by their vertices; one on which more than two triangles meet comes several times.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Memory of positions, triangles and edges; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.positions) + size_of_val(&*self.triangles) + size_of_val(&*self.edges)
    }
}

fn check_count(triangles: usize) -> Result<(), AdjacencyError> {
    if triangles > MOST_TRIANGLES {
        return Err(AdjacencyError::TooManyTriangles(triangles));
    }
    Ok(())
}

/// The different positions in the order in which they first appear, and for each of `positions` its index among them.
fn weld(positions: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    // + 0.0 makes −0 and 0 one
    let bits = |x: f32| u128::from((x + 0.0).to_bits());
    let key = |p: &Vec3| bits(p.x) << 64 | bits(p.y) << 32 | bits(p.z);
    let mut sorted: Vec<u128> = positions.iter().enumerate().map(|(i, p)| key(p) << 32 | i as u128).collect();
    sorted.sort_unstable();
    // each position stands for itself or for the first that equals it
    let mut welded = vec![0; positions.len()];
    let mut first = 0;
    for (k, &entry) in sorted.iter().enumerate() {
        if k == 0 || entry >> 32 != sorted[k - 1] >> 32 {
            first = entry as u32;
        }
        welded[entry as u32 as usize] = first;
    }
    let mut kept = Vec::new();
    for i in 0..positions.len() {
        // the first of its kind comes before all that refer to it
        welded[i] = if welded[i] as usize == i {
            kept.push(positions[i]);
            kept.len() as u32 - 1
        } else {
            welded[welded[i] as usize]
        };
    }
    (kept, welded)
}

/// The edges of triangles without equal corners.
fn edges_of(triangles: &[[u32; 3]]) -> Vec<Edge> {
    // both vertices, then direction and triangle: runs along the edge come before those against it
    let mut uses: Vec<(u64, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let ends = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
            uses.push((ends, u32::from(from > to), i as u32));
        }
    }
    uses.sort_unstable();
    let mut edges = Vec::with_capacity(uses.len() / 2);
    for uses in uses.chunk_by(|a, b| a.0 == b.0) {
        let side = |&(_, against, triangle): &(u64, u32, u32)| 2 * triangle + against;
        let vertices = [(uses[0].0 >> 32) as u32, uses[0].0 as u32];
        let mut add = |sides| edges.push(Edge { vertices, sides });
        let (along, against) = uses.split_at(uses.partition_point(|u| u.1 == 0));
        // triangles that run against each other belong together, as on a closed surface; doubled ones then pair up as well
        let pairs = along.len().min(against.len());
        for (one, other) in along.iter().zip(against) {
            add([side(one), side(other)]);
        }
        for rest in along[pairs..].chunks(2).chain(against[pairs..].chunks(2)) {
            add([side(&rest[0]), rest.get(1).map_or(NO_SIDE, side)]);
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Mesh;

    const CORNERS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    const TETRAHEDRON: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn of(faces: &[[usize; 3]]) -> Adjacency {
        Adjacency::new(faces.iter().map(|f| f.map(|i| CORNERS[i]))).unwrap()
    }

    /// Checks that each side's triangle runs along its edge as the side says, and that each use is there once.
    fn check(adjacency: &Adjacency) {
        let mut uses = 0;
        for edge in adjacency.edges() {
            let [a, b] = edge.vertices;
            assert!(a < b && edge.sides[0] != NO_SIDE, "{edge:?}");
            for side in edge.sides.into_iter().filter(|&side| side != NO_SIDE) {
                let t = adjacency.triangles()[side as usize / 2];
                let run = if side % 2 == 0 { [a, b] } else { [b, a] };
                assert!((0..3).any(|i| [t[i], t[(i + 1) % 3]] == run), "{edge:?} of {t:?}");
                uses += 1;
            }
        }
        assert_eq!(uses, 3 * adjacency.triangles().len());
    }

    #[test]
    fn a_closed_mesh_has_two_sides_everywhere() {
        let adjacency = of(&TETRAHEDRON);
        check(&adjacency);
        assert_eq!((adjacency.positions().len(), adjacency.edges().len()), (4, 6));
        assert!(
            adjacency.edges().iter().all(|e| e.sides[1] != NO_SIDE && (e.sides[0] ^ e.sides[1]) & 1 == 1)
        );
        assert_eq!(adjacency.bytes(), 4 * 12 + 4 * 12 + 6 * 16);
    }

    #[test]
    fn a_lone_triangle_has_one() {
        let adjacency = of(&TETRAHEDRON[..1]);
        check(&adjacency);
        assert_eq!(adjacency.edges().len(), 3);
        assert!(adjacency.edges().iter().all(|edge| edge.sides[1] == NO_SIDE));
    }

    #[test]
    fn three_triangles_on_an_edge_are_two_records() {
        let adjacency = of(&[[0, 1, 2], [1, 0, 3], [0, 1, 3]]);
        check(&adjacency);
        let shared: Vec<&Edge> = adjacency.edges().iter().filter(|edge| edge.vertices == [0, 1]).collect();
        assert_eq!(shared.len(), 2);
        assert_eq!((shared[0].sides, shared[1].sides), ([0, 3], [4, NO_SIDE]));
    }

    #[test]
    fn doubled_triangles_pair_up() {
        let faces: Vec<[usize; 3]> = TETRAHEDRON.iter().flat_map(|&f| [f, f]).collect();
        let adjacency = of(&faces);
        check(&adjacency);
        assert_eq!(adjacency.edges().len(), 12);
        assert!(adjacency.edges().iter().all(|e| (e.sides[0] ^ e.sides[1]) & 1 == 1));
    }

    #[test]
    fn zeros_of_both_signs_are_one_position_and_degenerate_triangles_are_dropped() {
        let minus = Vec3::new(-0.0, 0.0, -0.0);
        let degenerate = [Vec3::ZERO, minus, Vec3::X];
        let adjacency =
            Adjacency::new([[Vec3::ZERO, Vec3::X, Vec3::Y], degenerate, [Vec3::X, minus, Vec3::Z]]).unwrap();
        check(&adjacency);
        assert_eq!((adjacency.positions().len(), adjacency.triangles().len()), (4, 2));
        assert_eq!(adjacency.edges().len(), 5);
    }

    #[test]
    fn meshes_of_a_scene_are_one_and_nothing_is_a_mesh_too() {
        let mesh = |faces: &[[u32; 3]]| Mesh::new(CORNERS.to_vec(), faces.to_vec(), 0).unwrap();
        let scene = Scene {
            meshes: vec![mesh(&[[0, 2, 1], [0, 1, 3]]), mesh(&[[0, 3, 2], [1, 2, 3]])],
            ..Scene::default()
        };
        let (welded, given) = (Adjacency::of_scene(&scene).unwrap(), of(&TETRAHEDRON));
        check(&welded);
        let corners = |a: &Adjacency| -> Vec<Vec3> {
            a.triangles().concat().iter().map(|&i| a.positions()[i as usize]).collect()
        };
        assert_eq!(corners(&welded), corners(&given));
        assert_eq!((welded.positions().len(), welded.edges().len()), (4, 6));
        assert_eq!(Adjacency::new([]).unwrap(), Adjacency::of_scene(&Scene::default()).unwrap());
    }

    #[test]
    fn nonsense_is_refused() {
        let nan = Adjacency::new([CORNERS[..3].try_into().unwrap(), [Vec3::X, Vec3::NAN, Vec3::Y]]);
        assert_eq!(nan.unwrap_err(), AdjacencyError::NotFinite(4));
        assert!(check_count((1 << 30) + 1).is_err());
    }
}
