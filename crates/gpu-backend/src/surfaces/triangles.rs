//! What the surfaces of a scene are, on the GPU. Twin: `SurfaceTriangle` in `shaders/frame/surfaces.wgsl`.

use bytemuck::{Pod, Zeroable};
use scene::{Material, Triangle};

use crate::PrepareError;
use crate::checked::{check_size, filled_buffer, prepared};

const WHAT: &str = "the buffer of the surfaces' triangles";

/// A triangle as light sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SurfaceTriangle {
    normal: [f32; 3],
    _pad0: f32,
    base_color: [f32; 3],
    _pad1: f32,
}

impl SurfaceTriangle {
    /// A triangle with a unit normal, of either side, and a diffuse reflectance (linear RGB).
    pub const fn new(normal: [f32; 3], base_color: [f32; 3]) -> Self {
        Self { normal, _pad0: 0.0, base_color, _pad1: 0.0 }
    }

    /// The triangles of a hierarchy with their materials, in their order; one without a material is white.
    pub fn of_scene(triangles: &[Triangle], materials: &[Material]) -> Vec<Self> {
        let of = |triangle: &Triangle| {
            let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
            let color = materials.get(triangle.material as usize).map_or([1.0; 3], |m| m.base_color);
            Self::new(normal, color)
        };
        triangles.iter().map(of).collect()
    }
}

/// The triangles of a scene in a buffer.
#[derive(Debug, Clone)]
pub struct SurfaceTriangles {
    pub(super) buffer: wgpu::Buffer,
}

impl SurfaceTriangles {
    /// Uploads triangles; a visibility buffer refers to them by their place.
    ///
    /// # Errors
    /// [`PrepareError`] if they are more than the device can bind, or the device is lost.
    pub fn upload(device: &wgpu::Device, triangles: &[SurfaceTriangle]) -> Result<Self, PrepareError> {
        check_size(device, WHAT, size_of_val(triangles) as u64)?;
        // a binding has to hold something
        let nothing = [SurfaceTriangle::zeroed()];
        let contents = if triangles.is_empty() { &nothing[..] } else { triangles };
        let buffer = prepared(device, WHAT, || {
            let bytes = bytemuck::cast_slice(contents);
            filled_buffer(device, "surface triangles", bytes, wgpu::BufferUsages::STORAGE)
        })?;
        Ok(Self { buffer })
    }

    /// Memory on the device; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};
    use glam::Vec3;

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("frame/surfaces", "SurfaceTriangle");
        assert_eq!(span as usize, size_of::<SurfaceTriangle>());
        assert_eq!(fields, offsets!(SurfaceTriangle: normal, _pad0, base_color, _pad1));
    }

    #[test]
    fn a_triangle_by_hand() {
        let corners = [Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y];
        let red = Material { base_color: [1.0, 0.0, 0.0], ..Material::default() };
        let triangles = [0, 1].map(|material| Triangle { corners, material });
        let z = [0.0, 0.0, 1.0];
        let expected = [SurfaceTriangle::new(z, [1.0, 0.0, 0.0]), SurfaceTriangle::new(z, [1.0; 3])];
        assert_eq!(SurfaceTriangle::of_scene(&triangles, &[red]), expected);
    }
}
