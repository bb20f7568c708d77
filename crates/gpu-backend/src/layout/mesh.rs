//! A map's frame as a view sees it, for the surface that is extruded from it. Twin: `Mesh` in
//! `shaders/shared/light_mesh.wgsl`.

use bytemuck::{Pod, Zeroable};
use shadowmap::{Projection, ProjectionKind};

use super::Basis;

/// `Mesh` of the shaders; vectors in the camera's basis from the eye.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct MeshUniform {
    origin: [f32; 3],
    far: f32,
    right: [f32; 3],
    mirrored: u32,
    down: [f32; 3],
    _pad0: u32,
    forward: [f32; 3],
    _pad1: f32,
}

impl MeshUniform {
    /// The frame of a projection; nothing in an orthographic map is farther than `far` m.
    pub(crate) fn new(basis: &Basis, projection: &Projection, far: f32) -> Self {
        let face = &projection.faces()[0];
        Self {
            origin: basis.point(face.origin),
            far,
            right: basis.vector(face.right * face.half.x),
            // images of cube textures are seen from outside
            mirrored: u32::from(projection.kind() == ProjectionKind::Cube),
            down: basis.vector(face.down * face.half.y),
            _pad0: 0,
            forward: basis.vector(face.forward),
            _pad1: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("lightvolume/grid", "Mesh");
        assert_eq!(span as usize, size_of::<MeshUniform>());
        let ours = offsets!(MeshUniform: origin, far, right, mirrored, down, _pad0, forward, _pad1);
        assert_eq!(fields, ours);
    }
}
