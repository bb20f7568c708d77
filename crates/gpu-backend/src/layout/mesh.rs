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
    pool: u32,
    forward: [f32; 3],
    row_bits: u32,
}

impl MeshUniform {
    /// The frame of a projection of `size` texels; nothing in an orthographic map is farther than `far` m, and there is
    /// room for `pool` crossings.
    pub(crate) fn new(basis: &Basis, projection: &Projection, size: (u32, u32), far: f32, pool: u32) -> Self {
        let face = &projection.faces()[0];
        Self {
            origin: basis.point(face.origin),
            far,
            right: basis.vector(face.right * face.half.x),
            // images of cube textures are seen from outside
            mirrored: u32::from(projection.kind() == ProjectionKind::Cube),
            down: basis.vector(face.down * face.half.y),
            pool,
            forward: basis.vector(face.forward),
            row_bits: row_bits(size),
        }
    }

    /// Crossings for which there is room.
    pub(crate) fn pool(&self) -> u32 {
        self.pool
    }
}

/// Cells along the side of a tile of an indexed grid.
pub(crate) const GRID_TILE: u32 = 256;

/// Bits of a column's number in an indexed grid over `size` nodes: whole tiles have room.
pub(crate) fn row_bits(size: (u32, u32)) -> u32 {
    let columns = size.0.saturating_sub(1).next_multiple_of(GRID_TILE) + 1;
    columns.next_power_of_two().trailing_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("lightvolume/grid", "Mesh");
        assert_eq!(span as usize, size_of::<MeshUniform>());
        let ours = offsets!(MeshUniform: origin, far, right, mirrored, down, pool, forward, row_bits);
        assert_eq!(fields, ours);
    }
}
