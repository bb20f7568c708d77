//! A light volume whose triangles were made on the CPU: for lights that stand still.

use ::lightvolume::{LightVolume, VertexKind};
use shadowmap::ProjectionKind;

use crate::PrepareError;
use crate::checked::{check_size, filled_buffer, prepared};

/// The triangles of a light volume on the GPU, to be drawn by [`Tessellation::Mesh`](crate::Tessellation::Mesh); heights
/// are those of the map that it was built from.
///
/// Cloning shares the buffer.
#[derive(Debug, Clone)]
pub struct LightMesh {
    /// Two words a vertex, three vertices a triangle: see `shaders/lightvolume/mesh.wgsl`.
    pub(super) vertices: wgpu::Buffer,
    triangles: u32,
    map_size: (u32, u32),
}

impl LightMesh {
    /// Uploads the triangles of a volume of one image: of a spot or a directional light.
    ///
    /// # Errors
    /// [`PrepareError::Refused`] for a cube's, [`PrepareError::TooLarge`] if the device cannot bind it,
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn upload(device: &wgpu::Device, volume: &LightVolume) -> Result<Self, PrepareError> {
        if volume.projection().kind() == ProjectionKind::Cube {
            return Err(PrepareError::Refused(scene::Refusal {
                technique: "light-volume",
                feature: "triangles made beforehand for a point light",
                instead: "an adaptive tessellation",
            }));
        }
        let words = |index: &u32| {
            let vertex = &volume.vertices()[*index as usize];
            let twice = |value: f32| (2.0 * value) as u32;
            let kind = match vertex.kind {
                VertexKind::Surface => 0,
                VertexKind::Apex => 1,
                VertexKind::Far => 2,
            };
            [twice(vertex.x) | twice(vertex.y) << 16, kind]
        };
        let soup: Vec<[u32; 2]> = volume.triangles().iter().flatten().map(words).collect();
        check_size(device, "the triangles of a light volume", 8 * soup.len() as u64)?;
        let contents = if soup.is_empty() { &[0; 16] } else { bytemuck::cast_slice(&soup) };
        let vertices = prepared(device, "the triangles of a light volume", || {
            filled_buffer(device, "light volume mesh", contents, wgpu::BufferUsages::STORAGE)
        })?;
        Ok(Self { vertices, triangles: (soup.len() / 3) as u32, map_size: volume.map_size() })
    }

    /// Triangles, walls included.
    pub fn triangle_count(&self) -> u32 {
        self.triangles
    }

    /// Memory; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.vertices.size()
    }

    pub(crate) fn map_size(&self) -> (u32, u32) {
        self.map_size
    }
}
