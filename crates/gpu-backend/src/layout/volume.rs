//! A shadow volume as a view sees it. Twin: `Volume` in `shaders/shared/volume.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use scene::{Camera, Light};

use super::view::{CameraAxes, ImagePlane};

/// `Volume` of the shaders; vectors in the camera's basis from the eye, unless marked otherwise.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct VolumeUniform {
    right: [f32; 3],
    scale_x: f32,
    up: [f32; 3],
    scale_y: f32,
    forward: [f32; 3],
    near: f32,
    eye: [f32; 3],
    margin: f32,
    rest: [f32; 3],
    directional: u32,
    light: [f32; 3],
    most_inverse: f32,
    offset: [f32; 2],
    size: [u32; 2],
}

impl VolumeUniform {
    /// The volume of `light` as `camera` sees it, of a mesh around `middle` (world, m); nothing nearer than `near` m is
    /// seen. Faces are moved apart by `margin` for each metre from a local light, or by that many metres in a
    /// directional light.
    pub(crate) fn new(
        camera: &Camera,
        image: &ImagePlane,
        light: &Light,
        middle: DVec3,
        near: f64,
        margin: f64,
    ) -> Self {
        let axes = CameraAxes::new(camera);
        let eye = camera.position.as_dvec3();
        let from_middle = eye - middle;
        let rounded = from_middle.as_vec3();
        let (light, directional) = match light {
            Light::Point(light) => (axes.components(light.position.as_dvec3() - eye), 0),
            Light::Spot(light) => (axes.components(light.position.as_dvec3() - eye), 0),
            Light::Directional(light) => (axes.components(light.direction.as_dvec3().normalize()), 1),
        };
        Self {
            right: camera.right.to_array(),
            scale_x: image.scale.0 as f32,
            up: camera.up.to_array(),
            scale_y: image.scale.1 as f32,
            forward: camera.forward.to_array(),
            near: near as f32,
            eye: rounded.to_array(),
            margin: margin as f32,
            rest: (from_middle - rounded.as_dvec3()).as_vec3().to_array(),
            directional,
            light: light.as_vec3().to_array(),
            most_inverse: (1.0 / near) as f32,
            offset: [image.offset.0 as f32, image.offset.1 as f32],
            size: image.size.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("volume/tiles", "Volume");
        assert_eq!(span as usize, size_of::<VolumeUniform>());
        let ours = offsets!(VolumeUniform: right, scale_x, up, scale_y, forward, near, eye, margin, rest, directional,
            light, most_inverse, offset, size);
        assert_eq!(fields, ours);
    }
}
