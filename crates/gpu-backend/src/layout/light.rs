//! A light as a view sees it, as the shaders read it. Twin: `Light` in `shaders/shared/light.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use scene::{Aabb, Camera, Light, TextureFilter};
use shadowmap::{Projection, ProjectionKind};

use super::view::{CameraAxes, ImagePlane};

/// `Light` of the shaders; vectors in the camera's basis from the eye.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct LightUniform {
    pub(crate) to_light: [f32; 3],
    pub(crate) cos_outer: f32,
    pub(crate) axis: [f32; 3],
    pub(crate) cos_inner: f32,
    pub(crate) right: [f32; 3],
    pub(crate) tan_outer: f32,
    pub(crate) top: [f32; 3],
    pub(crate) nearest_texel: u32,
    pub(crate) power: [f32; 3],
    pub(crate) map_height: f32,
    pub(crate) center: [f32; 3],
    pub(crate) radius: f32,
    pub(crate) pixel: [f32; 4],
    pub(crate) image: [f32; 3],
    pub(crate) map_width: f32,
    pub(crate) world: [f32; 3],
    pub(crate) map_top: u32,
    pub(crate) first_sample: u32,
    pub(crate) end_sample: u32,
    pub(crate) samples: u32,
    pub(crate) kernel: u32,
    pub(crate) variance: [f32; 4],
    pub(crate) outside: u32,
    pub(crate) adds: u32,
    pub(crate) face_scale: u32,
    pub(crate) refine: u32,
    pub(crate) eye: [f32; 3],
    pub(crate) lit_samples: u32,
    pub(crate) table_end: f32,
    pub(crate) _pad0: f32,
    pub(crate) _pad1: f32,
    pub(crate) _pad2: f32,
    pub(crate) rows: [[f32; 4]; 4],
}

/// Share of the way to a light that must be depth for its image to be of use.
const LEAST_DEPTH: f64 = 0.05;

/// A camera with its image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Basis {
    eye: DVec3,
    axes: CameraAxes,
    /// World vectors as sums of the axes.
    sums: DMat3,
    /// Tangent at the image's upper left corner, and per pixel.
    offset: (f64, f64),
    scale: (f64, f64),
}

impl Basis {
    pub(crate) fn new(camera: &Camera, image: &ImagePlane) -> Self {
        let axes = CameraAxes::new(camera);
        Self {
            eye: camera.position.as_dvec3(),
            axes,
            sums: DMat3::from_cols(axes.right, axes.up, axes.forward).inverse(),
            offset: image.offset,
            scale: image.scale,
        }
    }

    /// A world vector in the camera's basis.
    pub(crate) fn vector(&self, v: DVec3) -> [f32; 3] {
        self.axes.components(v).as_vec3().to_array()
    }

    /// A world point in the camera's basis, from the eye; units: m.
    pub(crate) fn point(&self, p: DVec3) -> [f32; 3] {
        self.vector(p - self.eye)
    }

    /// Coefficients of world · `axis` + `offset` over the tangent vector, and its value at the eye.
    fn row(&self, axis: DVec3, offset: f64) -> [f32; 4] {
        self.axes.components(axis).extend(axis.dot(self.eye) + offset).as_vec4().to_array()
    }
}

impl LightUniform {
    /// The light alone: no map, no occluders, no march.
    pub(crate) fn new(basis: &Basis, light: &Light) -> Self {
        let eye = basis.eye.as_vec3().to_array();
        let mut uniform = Self { radius: -1.0, eye, ..Self::zeroed() };
        match light {
            Light::Point(light) => {
                uniform.power = light.intensity.to_array();
                uniform.place(basis, light.position.as_dvec3());
            }
            Light::Spot(light) => {
                uniform.power = light.intensity.to_array();
                uniform.place(basis, light.position.as_dvec3());
                uniform.axis = basis.vector(light.direction.as_dvec3());
                uniform.right = basis.vector(light.right.as_dvec3());
                uniform.top = basis.vector(light.right.as_dvec3().cross(light.direction.as_dvec3()));
                let (inner, outer) = (f64::from(light.inner), f64::from(light.outer));
                (uniform.cos_inner, uniform.cos_outer) = (inner.cos() as f32, outer.cos() as f32);
                uniform.tan_outer = outer.tan() as f32;
                let nearest =
                    light.texture.as_ref().is_some_and(|texture| texture.filter == TextureFilter::Nearest);
                uniform.nearest_texel = u32::from(nearest);
            }
            Light::Directional(light) => {
                let axis = light.direction.as_dvec3().normalize();
                uniform.power = light.irradiance.to_array();
                uniform.axis = basis.vector(axis);
                uniform.world = (-axis).as_vec3().to_array();
            }
        }
        uniform
    }

    fn place(&mut self, basis: &Basis, position: DVec3) {
        let to = position - basis.eye;
        self.to_light = basis.vector(to);
        self.world = to.as_vec3().to_array();
        let sum = basis.sums * to;
        if sum.z.abs() > LEAST_DEPTH * to.length() {
            let image = DVec3::new(sum.x / sum.z, sum.y / sum.z, 1.0);
            self.image = image.as_vec3().to_array();
            let pixel =
                [(image.x - basis.offset.0) / basis.scale.0, (image.y - basis.offset.1) / basis.scale.1];
            let rounded = pixel.map(|p| p as f32);
            let rest = [0, 1].map(|i| (pixel[i] - f64::from(rounded[i])) as f32);
            self.pixel = [rounded[0], rounded[1], rest[0], rest[1]];
        }
    }

    /// With occluders inside `bounds`.
    pub(crate) fn with_occluders(mut self, basis: &Basis, bounds: &Aabb) -> Self {
        if !bounds.is_empty() {
            self.center = basis.vector(bounds.center().as_dvec3() - basis.eye);
            self.radius = (0.5 * f64::from(bounds.diagonal()) * 1.0001 + 1e-12) as f32;
        }
        self
    }

    /// With a map of `size` texels.
    pub(crate) fn with_map(mut self, basis: &Basis, projection: &Projection, size: (u32, u32)) -> Self {
        (self.map_width, self.map_height) = (size.0 as f32, size.1 as f32);
        let face = &projection.faces()[0];
        let row = |axis: DVec3| basis.row(axis, -axis.dot(face.origin));
        self.rows = match projection.kind() {
            ProjectionKind::Cube => [row(DVec3::X), row(DVec3::Y), row(DVec3::Z), [0.0; 4]],
            ProjectionKind::Perspective | ProjectionKind::Orthographic => {
                let w = if face.perspective { row(face.forward) } else { [0.0, 0.0, 0.0, 1.0] };
                [row(face.right / face.half.x), row(face.down / face.half.y), w, row(face.forward)]
            }
        };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};
    use glam::Vec3;
    use scene::PointLight;

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("scatter/march", "Light");
        assert_eq!(span as usize, size_of::<LightUniform>());
        let ours = offsets!(LightUniform: to_light, cos_outer, axis, cos_inner, right, tan_outer, top, nearest_texel,
            power, map_height, center, radius, pixel, image, map_width, world, map_top, first_sample, end_sample,
            samples, kernel, variance, outside, adds, face_scale, refine, eye, lit_samples, table_end, _pad0, _pad1, _pad2, rows);
        assert_eq!(fields, ours);
    }

    #[test]
    fn a_light_straight_ahead_is_seen_in_the_middle() {
        let camera = Camera::look_at(Vec3::ONE, Vec3::new(1.0, 1.0, -9.0), Vec3::Y, 0.8).unwrap();
        let basis = Basis::new(&camera, &ImagePlane::new(&camera, (200, 100)));
        let light = Light::Point(PointLight::new(Vec3::new(1.0, 1.0, -4.0), Vec3::ONE).unwrap());
        let uniform = LightUniform::new(&basis, &light);
        assert_eq!((uniform.to_light, uniform.image), ([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]));
        assert!((uniform.pixel[0] - 100.0).abs() < 1e-4 && (uniform.pixel[1] - 50.0).abs() < 1e-4);
    }
}
