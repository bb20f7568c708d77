//! What the froxel passes read, as Rust writes it. Twins of the structs in `shaders/shared/{froxel,froxel_which}.wgsl`.

use bytemuck::{Pod, Zeroable};
use froxel_grid::{FroxelView, MAX_LIGHTS};
use glam::{Vec2, Vec3};
use scene::Light;

/// Most views of a frame of froxels.
pub(super) const MAX_VIEWS: usize = 256;

/// A corner of a box without end; the shaders know no infinity.
pub(super) const FAR_CORNER: f32 = 3e37;

/// `FroxelLight` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct LightUniform {
    pub(super) position: [f32; 3],
    pub(super) kind: u32,
    pub(super) axis: [f32; 3],
    pub(super) cos_outer: f32,
    pub(super) power: [f32; 3],
    pub(super) cos_inner: f32,
    pub(super) right: [f32; 3],
    pub(super) tan_outer: f32,
    pub(super) top: [f32; 3],
    pub(super) first_texel: u32,
    pub(super) picture: [u32; 2],
    pub(super) nearest_texel: u32,
    pub(super) is_shadowed: u32,
}

impl LightUniform {
    /// A light without its picture.
    pub(super) fn new(light: &Light, is_shadowed: bool) -> Self {
        // rounded once, as on the CPU
        let cosine = |angle: f32| f64::from(angle).cos() as f32;
        let mut uniform = Self { is_shadowed: u32::from(is_shadowed), ..Self::zeroed() };
        match light {
            Light::Point(point) => {
                (uniform.position, uniform.power) = (point.position.to_array(), point.intensity.to_array());
            }
            Light::Spot(spot) => {
                uniform.kind = 1;
                (uniform.position, uniform.power) = (spot.position.to_array(), spot.intensity.to_array());
                (uniform.axis, uniform.right) = (spot.direction.to_array(), spot.right.to_array());
                uniform.top = spot.top().to_array();
                (uniform.cos_inner, uniform.cos_outer) = (cosine(spot.inner), cosine(spot.outer));
                uniform.tan_outer = spot.outer.tan();
            }
            Light::Directional(sun) => {
                uniform.kind = 2;
                (uniform.position, uniform.power) = ((-sun.direction).to_array(), sun.irradiance.to_array());
            }
        }
        uniform
    }
}

/// `FroxelFrame` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct FrameUniform {
    pub(super) box_min: [f32; 3],
    pub(super) light_count: u32,
    pub(super) box_max: [f32; 3],
    pub(super) view_count: u32,
    pub(super) grid_min: [f32; 3],
    pub(super) parity: u32,
    pub(super) grid_max: [f32; 3],
    pub(super) everything: u32,
    pub(super) medium_min: [f32; 3],
    pub(super) slices: u32,
    pub(super) medium_max: [f32; 3],
    pub(super) near_slices: u32,
    pub(super) dims: [u32; 3],
    pub(super) voxel_size: f32,
    pub(super) tile: u32,
    pub(super) near_side: u32,
    pub(super) fine_slices: u32,
    pub(super) ratio: u32,
    pub(super) range: f32,
    pub(super) growth: f32,
    pub(super) curve: f32,
    pub(super) jitter: f32,
    pub(super) bricks: u32,
    pub(super) blocks: u32,
    /// Nothing, which a driver does not know: see `light_at` of the shaders.
    pub(super) first_light: u32,
    pub(super) _pad1: u32,
    pub(super) sigma_t: [f32; 3],
    pub(super) _pad2: u32,
    pub(super) starts: [[f32; 4]; 257],
    pub(super) lights: [LightUniform; MAX_LIGHTS],
}

/// `FroxelView` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct ViewUniform {
    pub(super) eye: [f32; 3],
    pub(super) first_tile: u32,
    pub(super) right: [f32; 3],
    pub(super) first_word: u32,
    pub(super) up: [f32; 3],
    pub(super) _pad0: u32,
    pub(super) forward: [f32; 3],
    pub(super) _pad1: u32,
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    pub(super) size: [u32; 2],
    pub(super) tiles: [u32; 2],
}

impl ViewUniform {
    pub(super) fn new(view: &FroxelView, first_tile: u32, first_word: u32) -> Self {
        let [right, up, forward] = view.axes.map(|axis: Vec3| axis.to_array());
        let pair = |v: Vec2| v.to_array();
        Self {
            eye: view.eye.to_array(),
            first_tile,
            right,
            first_word,
            up,
            _pad0: 0,
            forward,
            _pad1: 0,
            scale: pair(view.scale),
            offset: pair(view.offset),
            size: view.size.into(),
            tiles: view.tiles().into(),
        }
    }
}

/// `FroxelWhich` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct WhichUniform {
    pub(super) view: u32,
    pub(super) _pad0: u32,
    pub(super) newest: f32,
    pub(super) _pad1: u32,
    pub(super) before: ViewUniform,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shaders_read_what_rust_writes() {
        let struct_of = |name| wgsl_struct("froxel/lighting", name);
        let (fields, span) = struct_of("FroxelLight");
        assert_eq!(span as usize, size_of::<LightUniform>());
        let expected = offsets!(LightUniform: position, kind, axis, cos_outer, power, cos_inner, right, tan_outer, top,
            first_texel, picture, nearest_texel, is_shadowed);
        assert_eq!(fields, expected);
        let (fields, span) = struct_of("FroxelFrame");
        assert_eq!(span as usize, size_of::<FrameUniform>());
        let expected = offsets!(FrameUniform: box_min, light_count, box_max, view_count, grid_min, parity, grid_max, everything, medium_min, slices, medium_max,
            near_slices, dims, voxel_size, tile, near_side, fine_slices, ratio, range, growth, curve, jitter, bricks, blocks, first_light, _pad1, sigma_t, _pad2, starts, lights);
        assert_eq!(fields, expected);
        let (fields, span) = struct_of("FroxelView");
        assert_eq!(span as usize, size_of::<ViewUniform>());
        let expected = offsets!(ViewUniform: eye, first_tile, right, first_word, up, _pad0, forward, _pad1, scale, offset,
            size, tiles);
        assert_eq!(fields, expected);
        let (fields, span) = struct_of("FroxelWhich");
        assert_eq!(span as usize, size_of::<WhichUniform>());
        assert_eq!(fields, offsets!(WhichUniform: view, _pad0, newest, _pad1, before));
        let (_, span) = struct_of("FroxelViews");
        assert_eq!(span as usize, MAX_VIEWS * size_of::<ViewUniform>());
    }
}
