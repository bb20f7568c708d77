//! What the tests ask of a mesh: is it closed, which way does it face, how many handles does it have?

use glam::Vec3;
use std::collections::HashMap;

/// Findings about a mesh whose vertices of bit-identical position count as one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Survey {
    /// Directed edges that are used twice or whose opposite is missing.
    pub(super) bad_edges: usize,
    /// Vertices where two or more surfaces touch in a point.
    pub(super) pinched: usize,
    pub(super) degenerate: usize,
    /// Pieces that no edge connects.
    pub(super) components: usize,
    /// V − E + F.
    pub(super) euler: i64,
    /// Signed volume, positive where triangles face outwards; units: m³.
    pub(super) volume: f64,
}

impl Survey {
    pub(super) fn is_closed_manifold(&self) -> bool {
        (self.bad_edges, self.pinched, self.degenerate) == (0, 0, 0)
    }

    /// Handles of a closed surface in one piece.
    pub(super) fn genus(&self) -> i64 {
        assert_eq!(self.components, 1, "genus is asked of one piece");
        1 - self.euler / 2
    }
}

/// All meshes of a scene as one.
pub(super) fn survey_scene(scene: &crate::Scene) -> Survey {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let base = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|i| i + base)));
    }
    survey(&positions, &triangles)
}

pub(super) fn survey(positions: &[Vec3], triangles: &[[u32; 3]]) -> Survey {
    let mut ids = HashMap::new();
    let weld: Vec<u32> = positions
        .iter()
        .map(|p| {
            let next = ids.len() as u32;
            // + 0.0 makes −0 and 0 one
            *ids.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|i| weld[i as usize])).collect();
    let degenerate = faces.iter().filter(|[a, b, c]| a == b || b == c || c == a).count();

    // half-edge h runs from corner h of its face to the next
    let half_edge = |h: usize| (faces[h / 3][h % 3], faces[h / 3][(h % 3 + 1) % 3]);
    let mut sorted: Vec<((u32, u32), usize)> = (0..3 * faces.len()).map(|h| (half_edge(h), h)).collect();
    sorted.sort_unstable();
    let find = |edge: (u32, u32)| sorted.binary_search_by_key(&edge, |&(e, _)| e).ok().map(|i| sorted[i].1);
    let twins: Vec<Option<usize>> = (0..3 * faces.len())
        .map(|h| {
            let (a, b) = half_edge(h);
            find((b, a))
        })
        .collect();
    let twice = sorted.windows(2).filter(|w| w[0].0 == w[1].0).count();
    let bad_edges = twice + twins.iter().filter(|t| t.is_none()).count();

    // around a vertex: from an outgoing half-edge over the one before it in its face to that one's twin
    let mut pinched = 0;
    if bad_edges == 0 {
        let mut fans = vec![0_usize; ids.len()];
        let mut seen = vec![false; twins.len()];
        for start in 0..twins.len() {
            let mut h = start;
            if !seen[h] {
                fans[half_edge(h).0 as usize] += 1;
            }
            while !seen[h] {
                seen[h] = true;
                h = twins[h / 3 * 3 + (h % 3 + 2) % 3].unwrap_or(start);
            }
        }
        pinched = fans.iter().filter(|&&n| n > 1).count();
    }

    let mut parent: Vec<usize> = (0..faces.len()).collect();
    let root = |parent: &mut Vec<usize>, mut i: usize| {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    };
    for (h, twin) in twins.iter().enumerate() {
        if let Some(twin) = twin {
            let (a, b) = (root(&mut parent, h / 3), root(&mut parent, twin / 3));
            parent[a] = b;
        }
    }
    let components = (0..faces.len()).filter(|&i| parent[i] == i).count();

    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut edges: Vec<(u32, u32)> = sorted.iter().map(|&((a, b), _)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    edges.dedup();
    let corner = |i: u32| positions[i as usize].as_dvec3();
    let volume =
        triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f64>() / 6.0;
    Survey {
        bad_edges,
        pinched,
        degenerate,
        components,
        euler: used.len() as i64 - edges.len() as i64 + faces.len() as i64,
        volume,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(at: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        (vec![at, at + Vec3::X, at + Vec3::Y, at + Vec3::Z], vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn by_hand() {
        let (p, t) = tetrahedron(Vec3::ZERO);
        let s = survey(&p, &t);
        assert!(s.is_closed_manifold());
        assert_eq!((s.components, s.euler, s.genus()), (1, 2, 0));
        assert!((s.volume - 1.0 / 6.0).abs() < 1e-9);
        assert_eq!(survey(&p, &t[..3]).bad_edges, 3);
        // three edges are used twice, and six half-edges have no opposite
        assert_eq!(survey(&p, &[t[0], t[1], t[2], [1, 3, 2]]).bad_edges, 9);
    }

    #[test]
    fn two_solids_that_share_a_vertex_are_pinched() {
        let (mut p, mut t) = tetrahedron(Vec3::ZERO);
        let (q, u) = tetrahedron(Vec3::X);
        p.extend(q);
        t.extend(u.iter().map(|f| f.map(|i| i + 4)));
        let s = survey(&p, &t);
        assert_eq!((s.bad_edges, s.pinched, s.components), (0, 1, 2));
    }
}
