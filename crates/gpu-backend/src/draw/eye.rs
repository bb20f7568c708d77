//! From where depth is drawn, as the shader reads it. Twin: `Eye` of `shaders/map/depth.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use scene::Camera;
use shadowmap::Face;

/// `Eye` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Eye {
    right: [f32; 3],
    near: f32,
    down: [f32; 3],
    inverse_far: f32,
    forward: [f32; 3],
    perspective: u32,
    origin: [f32; 3],
    _pad0: f32,
    rest: [f32; 3],
    _pad1: f32,
    half: [f32; 2],
    texel: [f32; 2],
}

impl Eye {
    /// The eye of a face's image of `size` pixels; triangles are relative to `middle`. `near` counts in perspective,
    /// `far` without; units: m.
    pub(super) fn new(face: &Face, middle: DVec3, size: (u32, u32), near: f32, far: f32) -> Self {
        let from_middle = face.origin - middle;
        let origin = from_middle.as_vec3();
        let texel = 2.0 * face.half / DVec2::new(f64::from(size.0), f64::from(size.1));
        Self {
            right: face.right.as_vec3().to_array(),
            near,
            down: face.down.as_vec3().to_array(),
            inverse_far: (1.0 / f64::from(far)) as f32,
            forward: face.forward.as_vec3().to_array(),
            perspective: u32::from(face.perspective),
            origin: origin.to_array(),
            _pad0: 0.0,
            rest: (from_middle - origin.as_dvec3()).as_vec3().to_array(),
            _pad1: 0.0,
            half: face.half.as_vec2().to_array(),
            texel: texel.as_vec2().to_array(),
        }
    }
}

/// A camera's image of `size` pixels as a face.
pub(super) fn face_of(camera: &Camera, size: (u32, u32)) -> Face {
    let half = (0.5 * f64::from(camera.fov_y)).tan();
    Face {
        origin: camera.position.as_dvec3(),
        right: camera.right.as_dvec3(),
        down: -camera.up.as_dvec3(),
        forward: camera.forward.as_dvec3(),
        half: DVec2::new(half * f64::from(size.0) / f64::from(size.1), half),
        perspective: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct(super::super::PASS, "Eye");
        assert_eq!(span as usize, size_of::<Eye>());
        let ours = offsets!(Eye: right, near, down, inverse_far, forward, perspective, origin, _pad0, rest, _pad1,
            half, texel);
        assert_eq!(fields, ours);
    }
}
