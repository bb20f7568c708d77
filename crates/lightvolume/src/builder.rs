//! The surface of a map as triangles between nodes, each node one vertex.

use crate::hierarchy::Hierarchy;
use crate::nodes::Nodes;
use crate::quads::Quads;
use crate::stitch::{PLACES, STITCHES};
use crate::{Vertex, VertexKind};

/// A node that is no vertex yet.
const NONE: u32 = u32::MAX;

/// A quad of an adaptive tessellation that is not split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(C)]
pub struct Leaf {
    /// Face of the map.
    pub face: u32,
    /// Level: 2^level cells a side.
    pub level: u32,
    /// Column, in quads of its level.
    pub x: u32,
    /// Row, in quads of its level.
    pub y: u32,
    /// Which of [`STITCHES`](crate::STITCHES) it is cut by.
    pub configuration: u32,
}

/// A mesh that grows.
#[derive(Debug)]
pub(crate) struct Builder<'a> {
    pub(crate) nodes: Nodes<'a>,
    /// Vertex of each node, or [`NONE`].
    index: Vec<u32>,
    /// Whether right × down is against forward, as in cube maps.
    mirrored: bool,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) leaves: Vec<Leaf>,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(nodes: Nodes<'a>, mirrored: bool) -> Self {
        let index = vec![NONE; nodes.map.depths().len()];
        Self { nodes, index, mirrored, vertices: Vec::new(), triangles: Vec::new(), leaves: Vec::new() }
    }

    #[inline]
    fn slot(&self, face: usize, x: u32, y: u32) -> usize {
        let (columns, rows) = self.nodes.size();
        (face * rows as usize + y as usize) * columns as usize + x as usize
    }

    /// The vertex of a node, new if it had none.
    #[inline]
    pub(crate) fn node(&mut self, face: usize, x: u32, y: u32) -> u32 {
        let slot = self.slot(face, x, y);
        if self.index[slot] == NONE {
            let (depth, height) = (self.nodes.depth(face, x, y), self.nodes.height(face, x, y));
            self.index[slot] = self.vertex(Vertex {
                x: x as f32,
                y: y as f32,
                height,
                depth,
                kind: VertexKind::Surface,
                face: face as u16,
            });
        }
        self.index[slot]
    }

    /// The vertex of a node that has one.
    pub(crate) fn existing(&self, face: usize, x: u32, y: u32) -> Option<u32> {
        Some(self.index[self.slot(face, x, y)]).filter(|&index| index != NONE)
    }

    /// Adds a vertex.
    pub(crate) fn vertex(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        (self.vertices.len() - 1) as u32
    }

    /// Two triangles for each cell of a face.
    pub(crate) fn cells(&mut self, face: usize, quads: &Quads) {
        self.triangles.reserve(2 * quads.cells.0 as usize * quads.cells.1 as usize);
        self.descend(face, quads, None, (quads.top(), 0, 0));
    }

    /// The leaves of a hierarchy.
    pub(crate) fn leaves(&mut self, face: usize, hierarchy: &Hierarchy) {
        let quads = *hierarchy.quads();
        self.descend(face, &quads, Some(hierarchy), (quads.top(), 0, 0));
    }

    /// In the order of the quadtree, so that neighbours in the list are neighbours on the map.
    fn descend(
        &mut self,
        face: usize,
        quads: &Quads,
        hierarchy: Option<&Hierarchy>,
        (level, x, y): (u32, u32, u32),
    ) {
        let split = hierarchy.map_or(level > 0, |hierarchy| hierarchy.is_split(level, x, y));
        if split {
            for (x, y) in quads.children(level, x, y) {
                self.descend(face, quads, hierarchy, (level - 1, x, y));
            }
            return;
        }
        let configuration = hierarchy.map_or(0, |hierarchy| hierarchy.configuration(level, x, y));
        if hierarchy.is_some() {
            self.leaves.push(Leaf { face: face as u32, level, x, y, configuration });
        }
        self.leaf(face, quads, (level, x, y), configuration);
    }

    fn leaf(&mut self, face: usize, quads: &Quads, (level, x, y): (u32, u32, u32), configuration: u32) {
        let stitch = &STITCHES[configuration as usize & 15];
        for triangle in stitch.triangles() {
            let [a, b, c] = triangle.map(|place| {
                let (i, j) = PLACES[usize::from(place)];
                // in halves of a side; a cell has no middles
                let at = |x: u32, i: u32, cells: u32| (((2 * x + i) << level) / 2).min(cells);
                (at(x, i, quads.cells.0), at(y, j, quads.cells.1))
            });
            if twice_area(a, b, c) != 0 {
                self.triangle(face, [a, b, c]);
            }
        }
    }

    /// Adds a triangle of nodes that turns from columns to rows.
    #[inline]
    pub(crate) fn triangle(&mut self, face: usize, nodes: [(u32, u32); 3]) {
        let [a, b, c] = nodes.map(|(x, y)| self.node(face, x, y));
        self.triangles.push(if self.mirrored { [a, c, b] } else { [a, b, c] });
    }
}

/// Twice the area of a triangle of nodes.
#[inline]
pub(crate) fn twice_area(a: (u32, u32), b: (u32, u32), c: (u32, u32)) -> i64 {
    let edge = |to: (u32, u32)| (i64::from(to.0) - i64::from(a.0), i64::from(to.1) - i64::from(a.1));
    let (p, q) = (edge(b), edge(c));
    p.0 * q.1 - p.1 * q.0
}
