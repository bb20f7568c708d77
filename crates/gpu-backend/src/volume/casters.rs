//! A mesh that casts shadow volumes.

use glam::DVec3;
use hybrid_march::Adjacency;
use scene::{Aabb, Scene};

use crate::PrepareError;
use crate::checked::{check_size, filled_buffer, prepared};

/// A mesh with its edges on the GPU, relative to the middle of its bounds: what shadow volumes are made from.
///
/// Any triangles do: open, non-manifold, duplicated, wound either way.
#[derive(Debug)]
pub struct ShadowCasters {
    /// Positions and 1.
    pub(super) positions: wgpu::Buffer,
    /// Planes of the triangles.
    pub(super) planes: wgpu::Buffer,
    pub(super) edges: wgpu::Buffer,
    pub(super) edge_count: u32,
    /// What positions are relative to; units: m.
    pub(super) middle: DVec3,
    bounds: Aabb,
}

impl ShadowCasters {
    /// Uploads a mesh with its edges; an empty one is fine.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`] if a buffer is larger than the device binds (core limits: 8 million edges),
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn upload(device: &wgpu::Device, mesh: &Adjacency) -> Result<Self, PrepareError> {
        let bounds = Aabb::around(mesh.positions().iter().copied());
        let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center().as_dvec3() };
        let relative = |index: u32| mesh.positions()[index as usize].as_dvec3() - middle;
        let positions: Vec<[f32; 4]> = (0..mesh.positions().len() as u32)
            .map(|index| relative(index).as_vec3().extend(1.0).to_array())
            .collect();
        let planes: Vec<[f32; 4]> = mesh
            .triangles()
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(relative);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                normal.extend(-normal.dot(a)).as_vec4().to_array()
            })
            .collect();
        let edges: Vec<[u32; 4]> = mesh
            .edges()
            .iter()
            .map(|edge| [edge.vertices[0], edge.vertices[1], edge.sides[0], edge.sides[1]])
            .collect();
        let longest = positions.len().max(planes.len()).max(edges.len());
        check_size(device, "the buffer of the casters' edges", 16 * longest as u64)?;
        let buffer = |label, values: &[u8]| {
            let contents = if values.is_empty() { &[0; 16] } else { values };
            filled_buffer(device, label, contents, wgpu::BufferUsages::STORAGE)
        };
        prepared(device, "upload of the casters", || Self {
            positions: buffer("caster positions", bytemuck::cast_slice(&positions)),
            planes: buffer("caster planes", bytemuck::cast_slice(&planes)),
            edges: buffer("caster edges", bytemuck::cast_slice(&edges)),
            edge_count: edges.len() as u32,
            middle,
            bounds,
        })
    }

    /// Welds and uploads all meshes of a scene.
    ///
    /// # Errors
    /// As [`ShadowCasters::upload`]; [`PrepareError::Mesh`] if the mesh has no edges that can be indexed.
    pub fn of_scene(device: &wgpu::Device, scene: &Scene) -> Result<Self, PrepareError> {
        let mesh = Adjacency::of_scene(scene).map_err(|error| PrepareError::Mesh(error.to_string()))?;
        Self::upload(device, &mesh)
    }

    /// A box around them.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Edges, those between more than two triangles counted once for each pair.
    pub fn edge_count(&self) -> u32 {
        self.edge_count
    }

    /// Memory on the device; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.positions.size() + self.planes.size() + self.edges.size()
    }
}
