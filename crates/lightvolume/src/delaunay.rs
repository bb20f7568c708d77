//! Delaunay triangles of the nodes that matter most: greatest error first.
//!
//! It starts from the two triangles between the map's four corners and adds, again and again, the node that lies farthest
//! from the surface, until none is farther than the bound. Only the triangles around a new vertex have changed, and only
//! their nodes are looked at again.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::LightVolumeError;
use crate::builder::{Builder, twice_area};
use crate::nodes::Nodes;

/// A node as a vertex of the triangulation.
#[derive(Debug, Clone, Copy)]
struct Node(u32, u32);

impl HasPosition for Node {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(f64::from(self.0), f64::from(self.1))
    }
}

/// The worst node of a triangle.
#[derive(Debug, Clone, Copy)]
struct Worst {
    /// Distance from the surface along the light's axis; units: m.
    error: f64,
    node: (u32, u32),
    /// Index of the triangle, and how often it had changed when it was looked at.
    face: usize,
    version: u32,
}

impl Ord for Worst {
    fn cmp(&self, other: &Self) -> Ordering {
        // of equal errors the first node in reading order
        let order = self.error.total_cmp(&other.error);
        order.then_with(|| (other.node.1, other.node.0).cmp(&(self.node.1, self.node.0)))
    }
}

impl PartialOrd for Worst {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Worst {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Worst {}

/// A triangulation that is being refined.
struct Refinement<'a> {
    nodes: Nodes<'a>,
    bound: f64,
    mesh: DelaunayTriangulation<Node>,
    /// Nodes that are vertices.
    taken: Vec<bool>,
    /// How often each triangle has changed, and a vertex of it.
    faces: Vec<(u32, FixedVertexHandle)>,
    heap: BinaryHeap<Worst>,
}

/// Adds the triangles to `builder`, which holds a map of one image and at least one cell.
pub(crate) fn triangulate(builder: &mut Builder<'_>, bound: f32) -> Result<(), LightVolumeError> {
    let nodes = builder.nodes;
    let (columns, rows) = nodes.size();
    let mut refinement = Refinement {
        nodes,
        bound: f64::from(bound),
        mesh: DelaunayTriangulation::new(),
        taken: vec![false; columns as usize * rows as usize],
        faces: Vec::new(),
        heap: BinaryHeap::new(),
    };
    for (x, y) in [(0, 0), (columns - 1, 0), (0, rows - 1), (columns - 1, rows - 1)] {
        refinement.insert((x, y), None)?;
    }
    refinement.run()?;
    let mut triangles: Vec<[(u32, u32); 3]> = refinement.triangles();
    // in the order of a quadtree: neighbours in the list are neighbours on the map
    triangles.sort_unstable_by_key(|t| morton(t[0].0 + t[1].0 + t[2].0, t[0].1 + t[1].1 + t[2].1));
    for triangle in triangles {
        builder.triangle(0, triangle);
    }
    Ok(())
}

/// The bits of two coordinates in turn.
fn morton(x: u32, y: u32) -> u64 {
    (0..32).fold(0, |key, bit| {
        key | u64::from(x >> bit & 1) << (2 * bit) | u64::from(y >> bit & 1) << (2 * bit + 1)
    })
}

impl Refinement<'_> {
    fn run(&mut self) -> Result<(), LightVolumeError> {
        while let Some(worst) = self.heap.pop() {
            let (version, corner) = self.faces[worst.face];
            if version == worst.version {
                // close to where the node lies
                self.insert(worst.node, Some(corner))?;
            }
        }
        Ok(())
    }

    /// Makes a node a vertex, and looks at the triangles around it; the search for its place begins at `hint`.
    fn insert(&mut self, node: (u32, u32), hint: Option<FixedVertexHandle>) -> Result<(), LightVolumeError> {
        let refused = LightVolumeError::Insertion { x: node.0, y: node.1 };
        let vertex = match hint {
            Some(hint) => self.mesh.insert_with_hint(Node(node.0, node.1), hint),
            None => self.mesh.insert(Node(node.0, node.1)),
        };
        let vertex = vertex.map_err(|_| refused)?;
        let slot = node.1 as usize * self.nodes.size().0 as usize + node.0 as usize;
        self.taken[slot] = true;
        let around: Vec<(usize, [(u32, u32); 3])> = self
            .mesh
            .vertex(vertex)
            .out_edges()
            .filter_map(|edge| edge.face().as_inner())
            .map(|face| (face.index(), face.vertices().map(|v| (v.data().0, v.data().1))))
            .collect();
        for (face, corners) in around {
            self.look_at(face, vertex, corners);
        }
        Ok(())
    }

    fn triangles(&self) -> Vec<[(u32, u32); 3]> {
        let faces = self.mesh.inner_faces();
        faces.map(|face| face.vertices().map(|vertex| (vertex.data().0, vertex.data().1))).collect()
    }

    /// Finds the worst node of a new triangle.
    fn look_at(&mut self, face: usize, corner: FixedVertexHandle, corners: [(u32, u32); 3]) {
        if self.faces.len() <= face {
            self.faces.resize(face + 1, (0, corner));
        }
        let version = self.faces[face].0 + 1;
        self.faces[face] = (version, corner);
        let plane = Plane::new(&self.nodes, corners);
        let mut worst: Option<Worst> = None;
        for (x, y) in nodes_in(corners) {
            if self.taken[y as usize * self.nodes.size().0 as usize + x as usize] {
                continue;
            }
            let error = plane.distance(f64::from(self.nodes.depth(0, x, y)), x, y);
            let candidate = Worst { error, node: (x, y), face, version };
            if error > self.bound && worst.is_none_or(|worst| candidate > worst) {
                worst = Some(candidate);
            }
        }
        self.heap.extend(worst);
    }
}

/// The nodes within a triangle, its border included, row by row.
fn nodes_in(corners: [(u32, u32); 3]) -> impl Iterator<Item = (u32, u32)> {
    let corners = if twice_area(corners[0], corners[1], corners[2]) < 0 {
        [corners[0], corners[2], corners[1]]
    } else {
        corners
    };
    let wide = corners.map(|(x, y)| (i64::from(x), i64::from(y)));
    let (top, bottom) =
        corners.iter().fold((u32::MAX, 0), |(top, bottom), c| (top.min(c.1), bottom.max(c.1)));
    let (left, right) =
        wide.iter().fold((i64::MAX, i64::MIN), |(left, right), c| (left.min(c.0), right.max(c.0)));
    (top..=bottom).flat_map(move |y| {
        let (mut first, mut last) = (left, right);
        for (p, q) in [(wide[0], wide[1]), (wide[1], wide[2]), (wide[2], wide[0])] {
            // inside: (q − p) × (x − p) ≥ 0
            let fall = q.1 - p.1;
            let limit = (q.0 - p.0) * (i64::from(y) - p.1) + fall * p.0;
            match fall.cmp(&0) {
                Ordering::Greater => last = last.min(limit.div_euclid(fall)),
                Ordering::Less => first = first.max(-limit.div_euclid(-fall)),
                Ordering::Equal => {}
            }
        }
        (first..=last).map(move |x| (x as u32, y))
    })
}

/// Heights of a triangle over the map.
struct Plane {
    height: f64,
    at: (f64, f64),
    slope: (f64, f64),
    perspective: bool,
}

impl Plane {
    fn new(nodes: &Nodes<'_>, [a, b, c]: [(u32, u32); 3]) -> Self {
        let height = |(x, y): (u32, u32)| {
            let depth = f64::from(nodes.depth(0, x, y));
            if nodes.perspective { 1.0 / depth } else { -depth }
        };
        let edge = |to: (u32, u32)| (f64::from(to.0) - f64::from(a.0), f64::from(to.1) - f64::from(a.1));
        let (p, q) = (edge(b), edge(c));
        let (dp, dq) = (height(b) - height(a), height(c) - height(a));
        let area = p.0 * q.1 - p.1 * q.0;
        Self {
            height: height(a),
            at: (f64::from(a.0), f64::from(a.1)),
            slope: ((dp * q.1 - dq * p.1) / area, (dq * p.0 - dp * q.0) / area),
            perspective: nodes.perspective,
        }
    }

    /// How far a node of `depth` metres is from the triangle along the light's axis; units: m.
    fn distance(&self, depth: f64, x: u32, y: u32) -> f64 {
        let aside = (f64::from(x) - self.at.0, f64::from(y) - self.at.1);
        let height = self.height + self.slope.0 * aside.0 + self.slope.1 * aside.1;
        let own = if self.perspective { 1.0 / height.max(0.0) } else { -height };
        // also both infinite
        if own == depth { 0.0 } else { (own - depth).abs() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_a_triangle_by_hand() {
        let found: Vec<_> = nodes_in([(0, 0), (4, 0), (0, 2)]).collect();
        assert_eq!(found, [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (0, 1), (1, 1), (2, 1), (0, 2)]);
        // turned over, and a sliver with nothing inside
        let mut turned: Vec<_> = nodes_in([(0, 0), (0, 2), (4, 0)]).collect();
        turned.sort_unstable_by_key(|&(x, y)| (y, x));
        assert_eq!(turned, found);
        assert_eq!(nodes_in([(0, 0), (5, 2), (3, 1)]).count(), 3);
    }
}
