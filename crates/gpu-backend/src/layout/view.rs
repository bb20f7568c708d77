//! A view and its medium, as the shaders read them. Twin: `View` in `shaders/shared/view.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use media_math::Lobe;
use scene::{Camera, Density, Medium};

/// Length of a ray without end; the shaders know no infinity.
pub(crate) const ENDLESS: f32 = 1e30;

/// `View` of the shaders; vectors of world axes start at the eye.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct ViewUniform {
    pub(crate) forward: [f32; 3],
    pub(crate) max_distance: f32,
    pub(crate) right: [f32; 3],
    pub(crate) scale_x: f32,
    pub(crate) up: [f32; 3],
    pub(crate) scale_y: f32,
    pub(crate) offset: [f32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) sigma_s: [f32; 3],
    pub(crate) least_extinction: f32,
    pub(crate) sigma_t: [f32; 3],
    /// Nothing, which a driver does not know: see `lobe_count` of the shaders.
    pub(crate) first_lobe: u32,
    pub(crate) emission: [f32; 3],
    pub(crate) height_y0: f32,
    pub(crate) bounds_min: [f32; 3],
    pub(crate) height_scale: f32,
    pub(crate) bounds_max: [f32; 3],
    pub(crate) grid_step: f32,
    pub(crate) grid_min: [f32; 3],
    pub(crate) _pad0: f32,
    pub(crate) grid_max: [f32; 3],
    pub(crate) _pad1: f32,
    pub(crate) lobes: [[f32; 4]; 4],
}

/// An image on the plane of depth 1 in front of a camera: pixels, or tiles of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImagePlane {
    /// Tangent at the upper left corner.
    pub(crate) offset: (f64, f64),
    /// Tangent per pixel, to the right and (negative) downwards.
    pub(crate) scale: (f64, f64),
    /// Columns and rows.
    pub(crate) size: (u32, u32),
}

impl ImagePlane {
    /// The image of a camera with `size` pixels.
    pub(crate) fn new(camera: &Camera, size: (u32, u32)) -> Self {
        let half = (0.5 * f64::from(camera.fov_y)).tan();
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let aside = half * width / height;
        Self { offset: (-aside, half), scale: (2.0 * aside / width, -2.0 * half / height), size }
    }

    /// The same image with pixels `side` times as wide; the last ones may stick out of it.
    pub(crate) fn coarser(&self, side: u32) -> Self {
        let factor = f64::from(side);
        Self {
            offset: self.offset,
            scale: (self.scale.0 * factor, self.scale.1 * factor),
            size: (self.size.0.div_ceil(side), self.size.1.div_ceil(side)),
        }
    }
}

/// Steps per cell side when a way through a density grid is summed, as in `scene::Medium::optical_path`.
const STEPS_PER_CELL: f64 = 4.0;

impl ViewUniform {
    /// A view of an image through `medium`; rays that hit nothing go `max_distance` metres.
    pub(crate) fn new(camera: &Camera, image: &ImagePlane, max_distance: f64, medium: &Medium) -> Self {
        let eye = camera.position.as_dvec3();
        let relative = |p: Vec3| (p.as_dvec3() - eye).as_vec3().to_array();
        let mut uniform = Self {
            forward: camera.forward.to_array(),
            max_distance: (max_distance as f32).min(ENDLESS),
            right: camera.right.to_array(),
            scale_x: image.scale.0 as f32,
            up: camera.up.to_array(),
            scale_y: image.scale.1 as f32,
            offset: [image.offset.0 as f32, image.offset.1 as f32],
            size: image.size.into(),
            sigma_s: medium.coefficients.sigma_s(),
            sigma_t: medium.coefficients.sigma_t(),
            emission: medium.emission,
            ..Self::zeroed()
        };
        let attenuated = uniform.sigma_t.into_iter().filter(|&sigma_t| sigma_t > 0.0);
        uniform.least_extinction = attenuated.fold(ENDLESS, f32::min);
        if let Some(bounds) = &medium.bounds {
            (uniform.bounds_min, uniform.bounds_max) = (relative(bounds.min), relative(bounds.max));
        }
        match &medium.density {
            None => {}
            Some(Density::Height { y0, scale }) => {
                uniform.height_y0 = (f64::from(*y0) - eye.y) as f32;
                uniform.height_scale = *scale;
            }
            Some(Density::Grid(grid)) => {
                (uniform.grid_min, uniform.grid_max) = (relative(grid.bounds.min), relative(grid.bounds.max));
                uniform.grid_step = (grid.cell() / STEPS_PER_CELL) as f32;
            }
        }
        let count = medium.phase.lobes().len() as f32;
        for (slot, (weight, lobe)) in uniform.lobes.iter_mut().zip(medium.phase.lobes()) {
            let (kind, g) = match *lobe {
                Lobe::Isotropic => (0.0, 0.0),
                Lobe::Rayleigh => (1.0, 0.0),
                Lobe::HenyeyGreenstein { g } => (2.0, g),
                Lobe::HoffmanPreethamMie { g } => (3.0, g),
            };
            *slot = [*weight, kind, g, count];
        }
        uniform
    }
}

/// The unit vectors of a camera, to express world vectors in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CameraAxes {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

impl CameraAxes {
    pub(crate) fn new(camera: &Camera) -> Self {
        Self { right: camera.right.as_dvec3(), up: camera.up.as_dvec3(), forward: camera.forward.as_dvec3() }
    }

    /// Products with the three axes.
    pub(crate) fn components(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.forward))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct("scatter/march", "View");
        assert_eq!(span as usize, size_of::<ViewUniform>());
        let ours = offsets!(ViewUniform: forward, max_distance, right, scale_x, up, scale_y, offset, size, sigma_s,
            least_extinction, sigma_t, first_lobe, emission, height_y0, bounds_min, height_scale, bounds_max,
            grid_step, grid_min, _pad0, grid_max, _pad1, lobes);
        assert_eq!(fields, ours);
    }

    #[test]
    fn the_corner_ray_by_hand() {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, std::f32::consts::FRAC_PI_2).unwrap();
        let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
        let view = ViewUniform::new(&camera, &ImagePlane::new(&camera, (200, 100)), f64::INFINITY, &medium);
        let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert!(close(view.offset[0], -2.0) && close(view.offset[1], 1.0));
        assert!(close(view.offset[0] + 200.0 * view.scale_x, 2.0) && close(view.scale_y, -0.02));
        assert_eq!((view.max_distance, view.first_lobe, view.lobes[0][3]), (ENDLESS, 0, 1.0));
    }
}
