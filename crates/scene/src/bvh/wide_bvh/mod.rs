//! The hierarchy in the form that a GPU walks: eight children a node, their boxes in bytes.
//!
//! Layout after Ylitie, Karras and Laine 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs*; obvhs builds it. Everything is plain data, so that whoever uploads it needs to know neither.

use std::collections::HashSet;

use obvhs::cwbvh::node::CwBvhNode;

use super::{Triangle, boxes, gather};
use crate::{Scene, SceneError};

mod tree;
mod walk;

/// A node with up to eight children.
///
/// The box of child *i* reaches from `origin` + step·`min[axis][i]` to `origin` + step·`max[axis][i]`. It may be
/// short of what it holds by rounding: whoever tests it grows it by [`WideBvh::GROWTH`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WideNode {
    /// Smallest corner of the node's box; units: m.
    pub origin: [f32; 3],
    /// Per axis the exponent bits of the grid's step, an `f32` and a power of two; units of the step: m.
    pub exponents: [u8; 3],
    /// Bit *i* is set if child *i* is a node.
    pub inner: u8,
    /// Index of the first child that is a node; the others follow it in the order of their bits in `inner`.
    pub first_child: u32,
    /// Index of the first triangle of the children that are leaves.
    pub first_triangle: u32,
    /// Per child, in the upper three bits, as many ones as it has triangles (1 for a node, 0 for nothing); in the lower
    /// five its first triangle, counted from `first_triangle` and below 24, or 24 + *i* for a node.
    pub contents: [u8; 8],
    /// Smallest corners of the children on the grid, by axis, then child.
    pub min: [[u8; 8]; 3],
    /// Largest corners.
    pub max: [[u8; 8]; 3],
}

/// A compressed wide hierarchy over all triangles of a scene, for shadow rays on the GPU.
///
/// ```
/// use glam::Vec3;
/// use scene::{Mesh, Scene, WideBvh};
///
/// let wall = Mesh::new(vec![Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z], vec![[0, 1, 2]], 0)?;
/// let bvh = WideBvh::build(&Scene { meshes: vec![wall], ..Scene::default() })?;
/// assert!(bvh.blocked(Vec3::new(0.3, 0.2, 0.0), Vec3::Z, 2.0));
/// assert!(!bvh.blocked(Vec3::new(0.3, 0.2, 0.0), Vec3::Z, 0.5));
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct WideBvh {
    nodes: Vec<WideNode>,
    triangles: Vec<Triangle>,
    levels: usize,
}

impl WideBvh {
    /// By how much a box has to be grown on each side, relative to its node's size plus the ray origin's distance from
    /// the node's, per axis.
    ///
    /// It covers the rounding of the grid's step (obvhs takes it from a rounded logarithm, 1.3·10⁻⁶ of the size at
    /// most), of the corners, and of the ray's own arithmetic in `f32`.
    pub const GROWTH: f32 = 4e-6;

    /// Most levels of a hierarchy: a walk needs a stack of [`WideBvh::STACK`] entries at most.
    ///
    /// A walk that has reached level *n*, the root's being 0, has left unvisited siblings on levels 1 to *n* at most,
    /// one entry each.
    pub const MAX_LEVELS: usize = Self::STACK + 1;

    /// Entries of a stack that no walk overflows.
    pub const STACK: usize = 32;

    /// Largest coordinate of a scene; units: m.
    ///
    /// Products of three lengths, as the test of a triangle has them, stay far from the largest `f32`.
    pub const MAX_COORDINATE: f32 = 1e11;

    /// Builds the hierarchy; an empty scene gives one without nodes.
    ///
    /// Triangles without area, which no ray hits, and all but one of equal triangles are left out.
    ///
    /// # Errors
    /// [`SceneError::TooManyTriangles`] past 2³¹ triangles, [`SceneError::TooWide`] past
    /// [`WideBvh::MAX_COORDINATE`].
    pub fn build(scene: &Scene) -> Result<Self, SceneError> {
        let mut triangles = gather(scene)?;
        let bounds = scene.bounds();
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !bounds.is_empty() && largest > Self::MAX_COORDINATE {
            return Err(SceneError::TooWide { largest, most: Self::MAX_COORDINATE });
        }
        let mut known = HashSet::with_capacity(triangles.len());
        triangles.retain(|t| has_area(t) && known.insert(t.corners.map(|c| c.to_array().map(f32::to_bits))));
        if triangles.is_empty() {
            return Ok(Self::default());
        }
        // halving 2³¹ triangles needs 32 levels, so the limit is kept whatever the scene
        let tree = tree::build(&boxes(&triangles), Self::MAX_LEVELS);
        Ok(Self {
            nodes: tree.nodes.iter().map(plain).collect(),
            triangles: tree.primitive_indices.iter().map(|&i| triangles[i as usize]).collect(),
            levels: tree::levels(&tree),
        })
    }

    /// The nodes, the root first; none without triangles.
    pub fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// The triangles in the order in which the nodes count them.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Number of levels, the root's among them; 0 without nodes.
    pub fn levels(&self) -> usize {
        self.levels
    }
}

fn plain(node: &CwBvhNode) -> WideNode {
    WideNode {
        origin: node.p.to_array(),
        exponents: node.e,
        inner: node.imask,
        first_child: node.child_base_idx,
        first_triangle: node.primitive_base_idx,
        contents: node.child_meta,
        min: [node.child_min_x, node.child_min_y, node.child_min_z],
        max: [node.child_max_x, node.child_max_y, node.child_max_z],
    }
}

fn has_area(triangle: &Triangle) -> bool {
    let [a, b, c] = super::wide(&triangle.corners);
    (b - a).cross(c - a) != glam::DVec3::ZERO
}
