//! Bounding volume hierarchy over a scene's triangles, and the three queries that shadows need.
//!
//! obvhs builds the tree. The queries of the exact reference run in `f64` on the `f32` vertices, so that they answer
//! for the very triangles that every other technique sees: the nearest hit of a view ray ([`Bvh::closest_hit`]),
//! whether anything lies between two points ([`Bvh::occluded`]), and which triangles cut the plane region swept by the
//! shadow rays of a view ray ([`Bvh::for_each_in`]).

use std::ops::ControlFlow;
use std::time::Duration;

use glam::{DVec3, Vec3};
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::{BvhBuildParams, aabb::Aabb as TreeBox};

use crate::{Aabb, Scene, SceneError};

mod occlusion;
mod ray;
mod region;
mod wide_bvh;

pub use occlusion::BvhVisibility;
pub use ray::Hit;
pub use region::PlaneRegion;
pub use wide_bvh::{WideBvh, WideNode};

/// A triangle in world space and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Corners; units: m.
    pub corners: [Vec3; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// A hierarchy over all triangles of a scene.
#[derive(Clone)]
pub struct Bvh {
    tree: Bvh2,
    /// In the order of the leaves.
    triangles: Vec<Triangle>,
    bounds: Aabb,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("triangles", &self.triangles.len())
            .field("nodes", &self.tree.nodes.len())
            .finish_non_exhaustive()
    }
}

impl Bvh {
    /// Builds the hierarchy; an empty scene gives one that nothing hits.
    ///
    /// # Errors
    /// [`SceneError::TooManyTriangles`] past 2³¹ triangles.
    pub fn build(scene: &Scene) -> Result<Self, SceneError> {
        let triangles = gather(scene)?;
        let boxes = boxes(&triangles);
        let tree = if boxes.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default())
        };
        // leaves then read their triangles in a row
        let ordered = tree.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Ok(Self { tree, triangles: ordered, bounds: scene.bounds() })
    }

    /// The smallest box around everything.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The triangles, in the order of the tree's leaves.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Number of nodes of the tree.
    pub fn node_count(&self) -> usize {
        self.tree.nodes.len()
    }

    /// Memory of tree and triangles; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.tree.nodes)
            + size_of_val(&*self.tree.primitive_indices)
            + size_of_val(&*self.triangles)
    }

    /// Visits the triangles of every leaf whose ancestors all pass `enter`.
    #[inline]
    fn walk(
        &self,
        mut enter: impl FnMut(&TreeBox) -> bool,
        mut leaf: impl FnMut(usize, &Triangle) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(root) = self.tree.nodes.first() else {
            return ControlFlow::Continue(());
        };
        if !enter(root.aabb()) {
            return ControlFlow::Continue(());
        }
        let mut stack = [0_u32; 128];
        let mut overflow = Vec::new();
        let mut depth = 1;
        while depth > 0 {
            let index = match overflow.pop() {
                Some(index) => index,
                None => {
                    depth -= 1;
                    stack[depth]
                }
            };
            let node = &self.tree.nodes[index as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                for i in first..first + node.prim_count as usize {
                    leaf(i, &self.triangles[i])?;
                }
                continue;
            }
            for child in [node.first_index + 1, node.first_index] {
                if enter(self.tree.nodes[child as usize].aabb()) {
                    if depth < stack.len() {
                        stack[depth] = child;
                        depth += 1;
                    } else {
                        // deeper than any tree seen; slower, still right
                        overflow.push(child);
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits every triangle that may meet `region`, and perhaps some that do not.
    pub fn for_each_in(&self, region: &PlaneRegion, mut visit: impl FnMut(&Triangle)) {
        let _ = self.walk(
            |b| region.may_meet(b.min, b.max),
            |_, triangle| {
                visit(triangle);
                ControlFlow::Continue(())
            },
        );
    }

    /// Rounding of `f32` at the largest coordinate of this scene and of `points`; units: m.
    pub fn rounding(&self, points: &[DVec3]) -> f64 {
        let scene = if self.bounds.is_empty() {
            0.0
        } else {
            f64::from(self.bounds.min.abs().max(self.bounds.max.abs()).max_element())
        };
        let largest = points.iter().fold(scene, |largest, point| largest.max(point.abs().max_element()));
        f64::from(f32::EPSILON) * largest
    }
}

/// All triangles of the scene.
fn gather(scene: &Scene) -> Result<Vec<Triangle>, SceneError> {
    let count = scene.triangle_count();
    if count > 1 << 31 {
        return Err(SceneError::TooManyTriangles(count));
    }
    let mut triangles = Vec::with_capacity(count);
    for mesh in &scene.meshes {
        let material = mesh.material as u32;
        triangles.extend(mesh.corners().map(|corners| Triangle { corners, material }));
    }
    Ok(triangles)
}

/// Their boxes, as obvhs takes them.
fn boxes(triangles: &[Triangle]) -> Vec<TreeBox> {
    let around = |t: &Triangle| {
        let b = Aabb::around(t.corners);
        TreeBox { min: b.min.into(), max: b.max.into() }
    };
    triangles.iter().map(around).collect()
}

fn wide(corners: &[Vec3; 3]) -> [DVec3; 3] {
    corners.map(|corner| corner.as_dvec3())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Material, Mesh};

    /// Random triangles in the unit cube, the same for every run.
    pub(crate) fn soup(count: usize, size: f32) -> Scene {
        let mut state = 12345_u32;
        let mut random = move || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut positions = Vec::new();
        for _ in 0..count {
            let c = Vec3::new(random(), random(), random());
            positions.extend([0; 3].map(|_| c + size * (Vec3::new(random(), random(), random()) - 0.5)));
        }
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Scene {
            meshes: vec![Mesh::new(positions, triangles, 0).unwrap()],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    #[test]
    fn every_triangle_is_in_the_tree_once() {
        for count in [0, 1, 2, 3, 500] {
            let bvh = Bvh::build(&soup(count, 0.1)).unwrap();
            assert_eq!(bvh.triangles().len(), count);
            let mut seen = 0;
            let _ = bvh.walk(
                |_| true,
                |_, _| {
                    seen += 1;
                    ControlFlow::Continue(())
                },
            );
            assert_eq!(seen, count);
        }
    }
}
