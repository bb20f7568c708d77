//! Simpler occluders that stand in for the real ones where shadow volumes are extruded.
//!
//! (Wyman and Ramsey 2008, sections 3.3 and 5): the volumes only say where a march has to ask for visibility, and that
//! need not be exact. A box is never wrong but wide: it no longer marks where a shadow begins. A coarser mesh keeps the
//! outline roughly. And in fog only what is near the viewer casts a shadow that anyone sees.
//!
//! Triangles are corner positions in m, wound as the caller likes.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use scene::Aabb;

/// The corners of a box by the bits of their index (x, y, z), as twelve triangles that are wound counterclockwise seen
/// from outside.
const BOX: [[usize; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

/// The twelve triangles of a box, wound counterclockwise seen from outside; none of an empty box.
///
/// Its shadow holds that of all inside it. Its faces are no shadow's boundary, so that a march between them errs there
/// by its step, as a march without volumes does.
pub fn bounding_box(bounds: &Aabb) -> Vec<[Vec3; 3]> {
    if bounds.is_empty() {
        return Vec::new();
    }
    let corner = |i: usize| {
        let high = |bit: usize| i >> bit & 1 == 1;
        Vec3::select(glam::BVec3::new(high(0), high(1), high(2)), bounds.max, bounds.min)
    };
    BOX.iter().map(|triangle| triangle.map(corner)).collect()
}

/// A coarser mesh: all corners in a cell of a grid become their mean. `cells` is the number of cells along the longest
/// side of the mesh's bounds.
///
/// Triangles that lose a corner to another are dropped, so a closed mesh stays closed: its directed edges still cancel,
/// even where it folds onto itself. What is thinner than a cell may vanish, and convex outlines shrink by up to a cell,
/// so the bounds that such a proxy gives are approximate: shadow is missed where it lies outside them. Triangles
/// with a corner that is not finite are dropped too.
pub fn cluster(triangles: &[[Vec3; 3]], cells: u32) -> Vec<[Vec3; 3]> {
    let finite = || triangles.iter().filter(|triangle| triangle.iter().all(|corner| corner.is_finite()));
    let bounds = Aabb::around(finite().flatten().copied());
    if bounds.is_empty() {
        return Vec::new();
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let side = (max - min).max_element() / f64::from(cells.max(1));
    let cell = |corner: &Vec3| {
        // the last cell holds its far side, and a mesh without extent has one cell
        let at = ((corner.as_dvec3() - min) / side).floor().to_array();
        at.map(|at| (at.max(0.0) as u32).min(cells.max(1) - 1))
    };
    let mut clusters: HashMap<[u32; 3], (DVec3, f64)> = HashMap::new();
    for corner in finite().flatten() {
        let (sum, count) = clusters.entry(cell(corner)).or_default();
        *sum += corner.as_dvec3();
        *count += 1.0;
    }
    let mean = |key: [u32; 3]| clusters.get(&key).map(|(sum, count)| (*sum / *count).as_vec3());
    finite()
        .filter_map(|triangle| {
            let [a, b, c] = [0, 1, 2].map(|i| cell(&triangle[i]));
            if a == b || b == c || c == a {
                return None;
            }
            Some([mean(a)?, mean(b)?, mean(c)?])
        })
        .collect()
}

/// The triangles that reach to within `radius` of `viewer`, both in m; whole ones, in their order.
///
/// A mesh that is cut off so is open, which the volumes extruded from it must allow. A `radius` that is negative or no
/// number leaves nothing.
pub fn near_viewer(triangles: &[[Vec3; 3]], viewer: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
    let (viewer, radius) = (viewer.as_dvec3(), f64::from(radius));
    let near = |corners: &&[Vec3; 3]| distance(viewer, corners.map(|corner| corner.as_dvec3())) <= radius;
    triangles.iter().filter(near).copied().collect()
}

/// Distance from a point to a triangle, which may be degenerate; units: m.
fn distance(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    // on the same side of the three planes through an edge and along the normal
    let above = normal.length_squared() > 0.0
        && edges.iter().all(|&(from, to)| normal.cross(to - from).dot(point - from) >= 0.0);
    if above {
        return (point - a).dot(normal).abs() / normal.length();
    }
    edges.iter().map(|&(from, to)| distance_to_edge(point, from, to)).fold(f64::INFINITY, f64::min)
}

fn distance_to_edge(point: DVec3, from: DVec3, to: DVec3) -> f64 {
    let (edge, w) = (to - from, point - from);
    let length_squared = edge.length_squared();
    let t = if length_squared > 0.0 { (w.dot(edge) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (w - t * edge).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> Aabb {
        Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 3.0, 2.5) }
    }

    /// A sphere of 16 by 32 quads around (1, 2, 3), wound outwards.
    fn sphere() -> Vec<[Vec3; 3]> {
        let at = |i: u32, j: u32| {
            // the same values at both ends of a circle, so that the mesh is closed to the last bit
            let (theta, phi) =
                (i as f32 / 16.0 * std::f32::consts::PI, (j % 32) as f32 / 32.0 * std::f32::consts::TAU);
            let ring = if i == 0 || i == 16 { 0.0 } else { theta.sin() };
            Vec3::new(1.0, 2.0, 3.0) + Vec3::new(ring * phi.cos(), theta.cos(), ring * phi.sin())
        };
        let quads = (0..16).flat_map(|i| (0..32).map(move |j| (i, j)));
        quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    /// Six times the volume inside a closed mesh, positive if it is wound outwards.
    fn volume(triangles: &[[Vec3; 3]]) -> f64 {
        let signed = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c));
        triangles.iter().map(|t| signed(t.map(|p| p.as_dvec3() - Vec3::ONE.as_dvec3()))).sum::<f64>() / 6.0
    }

    /// Whether each edge is passed as often one way as the other.
    fn is_closed(triangles: &[[Vec3; 3]]) -> bool {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        let key = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
        for [a, b, c] in triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry([key(*from), key(*to)]).or_default() += 1;
                *edges.entry([key(*to), key(*from)]).or_default() -= 1;
            }
        }
        edges.values().all(|&count| count == 0)
    }

    #[test]
    fn a_box_is_closed_and_faces_outwards() {
        let triangles = bounding_box(&unit_box());
        assert_eq!(triangles.len(), 12);
        assert!(is_closed(&triangles));
        assert!((volume(&triangles) - 3.0).abs() < 1e-9);
        assert_eq!(Aabb::around(triangles.into_iter().flatten()), unit_box());
        assert!(bounding_box(&Aabb::EMPTY).is_empty());
    }

    #[test]
    fn clusters_are_fewer_closed_and_alike() {
        let sphere = sphere();
        assert!(is_closed(&sphere), "the sphere itself");
        let exact = volume(&sphere);
        assert!(exact > 4.0);
        let mut last = sphere.len();
        for cells in [16, 8, 5] {
            let coarse = cluster(&sphere, cells);
            assert!(is_closed(&coarse), "{cells} cells");
            assert!(coarse.len() < last && !coarse.is_empty(), "{cells} cells: {}", coarse.len());
            last = coarse.len();
            assert!(coarse.iter().all(|&[a, b, c]| a != b && b != c && c != a), "{cells} cells");
            let side = 2.0 / f64::from(cells);
            for corner in coarse.iter().flatten() {
                let radius = (*corner - Vec3::new(1.0, 2.0, 3.0)).length();
                assert!(f64::from(radius) <= 1.0 + 1e-6 && f64::from(radius) > 1.0 - side, "{radius}");
            }
            // it shrinks, and not by more than a cell all around
            let share = volume(&coarse) / exact;
            assert!(share < 1.0 && share > (1.0 - side).powi(3), "{cells} cells: {share}");
        }
    }

    #[test]
    fn what_cannot_be_clustered_is_dropped() {
        let sphere = sphere();
        assert!(cluster(&sphere, 0).is_empty() && cluster(&sphere, 1).is_empty());
        assert!(cluster(&[], 8).is_empty());
        assert!(cluster(&[[Vec3::ONE; 3]], 8).is_empty());
        let bad = [Vec3::NAN, Vec3::INFINITY, Vec3::ZERO];
        let with_bad: Vec<_> = sphere.iter().copied().chain([bad]).collect();
        assert_eq!(cluster(&with_bad, 8), cluster(&sphere, 8));
        // as many cells as there can be: nothing moves
        assert_eq!(cluster(&bounding_box(&unit_box()), u32::MAX), bounding_box(&unit_box()));
    }

    #[test]
    fn distances_by_hand() {
        let triangle = [DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y];
        for (point, exact) in [
            // above its inside, its edge, its corner, and in it
            (DVec3::new(1.0, 1.0, -3.0), 3.0),
            (DVec3::new(2.0, -3.0, 4.0), 5.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(4.0, 4.0, 0.0), 8.0_f64.sqrt()),
            (DVec3::new(1.0, 1.0, 0.0), 0.0),
        ] {
            let [a, b, c] = triangle;
            for corners in [[a, b, c], [b, a, c], [c, a, b]] {
                assert!((distance(point, corners) - exact).abs() < 1e-12, "{point}");
            }
        }
        // a line, and a point
        assert_eq!(distance(DVec3::new(1.0, 2.0, 0.0), [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]), 2.0);
        assert_eq!(distance(2.0 * DVec3::Z, [DVec3::ZERO; 3]), 2.0);
    }

    #[test]
    fn near_triangles_are_kept_whole() {
        let sphere = sphere();
        let viewer = Vec3::new(1.0, 2.0, 5.0);
        assert_eq!(near_viewer(&sphere, viewer, f32::INFINITY), sphere);
        assert!(near_viewer(&sphere, viewer, 0.9).is_empty());
        let near = near_viewer(&sphere, viewer, 1.2);
        assert!(!near.is_empty() && near.len() < sphere.len() / 4);
        // a large triangle whose corners are all far away still reaches
        let large =
            [[Vec3::new(-90.0, -1.0, -90.0), Vec3::new(90.0, -1.0, -90.0), Vec3::new(0.0, -1.0, 90.0)]];
        assert_eq!(near_viewer(&large, Vec3::ZERO, 1.5), large);
        for nothing in [-1.0, f32::NAN] {
            assert!(near_viewer(&large, Vec3::new(0.0, -1.0, 0.0), nothing).is_empty());
        }
    }
}
