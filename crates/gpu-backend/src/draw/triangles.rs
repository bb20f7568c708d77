//! Triangles on the GPU.

use glam::{DVec3, Vec3};
use scene::{Aabb, Mesh, Scene};

use crate::PrepareError;
use crate::checked::{check_buffer, filled_buffer, prepared};

/// Bytes of a triangle.
pub(super) const STRIDE: u64 = size_of::<[Vec3; 3]>() as u64;

/// Triangles on the GPU, relative to the middle of their bounds: nothing is lost to the scene's place in the world.
#[derive(Debug)]
pub struct Triangles {
    pub(super) buffer: wgpu::Buffer,
    pub(super) count: u32,
    /// What the corners are relative to; units: m.
    pub(super) middle: DVec3,
    bounds: Aabb,
}

impl Triangles {
    /// Uploads triangles (corners in m); none is fine.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`] if they need a larger buffer than the device allows, [`PrepareError::Device`] if there
    /// is no memory or the device is lost.
    pub fn upload(device: &wgpu::Device, triangles: &[[Vec3; 3]]) -> Result<Self, PrepareError> {
        let bytes = STRIDE * triangles.len() as u64;
        check_buffer(device, "the buffer of the triangles", bytes)?;
        let bounds = Aabb::around(triangles.iter().flatten().copied());
        let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center().as_dvec3() };
        let relative: Vec<[f32; 3]> = triangles
            .iter()
            .flatten()
            .map(|corner| (corner.as_dvec3() - middle).as_vec3().to_array())
            .collect();
        let contents: &[u8] = if relative.is_empty() { &[0; 4] } else { bytemuck::cast_slice(&relative) };
        let buffer = prepared(device, "upload of the triangles", || {
            filled_buffer(device, "triangles", contents, wgpu::BufferUsages::VERTEX)
        })?;
        Ok(Self { buffer, count: triangles.len() as u32, middle, bounds })
    }

    /// Uploads all meshes of a scene.
    ///
    /// # Errors
    /// As [`Triangles::upload`].
    pub fn of_scene(device: &wgpu::Device, scene: &Scene) -> Result<Self, PrepareError> {
        let triangles: Vec<[Vec3; 3]> = scene.meshes.iter().flat_map(Mesh::corners).collect();
        Self::upload(device, &triangles)
    }

    /// A box around them.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Memory on the device; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }
}
