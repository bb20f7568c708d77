//! Depth as a camera sees it.

use scene::Camera;
use shadowmap::{DEFAULT_NEAR, DepthOrder};

use super::eye::{Eye, face_of};
use super::{DepthDrawer, Triangles, depth_texture};
use crate::checked::prepared;
use crate::map::check_side;
use crate::{PrepareError, SceneDepth};

/// A depth texture for a view: Depth32Float, reversed, far plane infinitely far.
#[derive(Debug)]
pub struct DrawnDepth {
    texture: wgpu::Texture,
}

impl DrawnDepth {
    /// Makes the texture of a view of `size` (columns, rows); nothing is drawn yet.
    ///
    /// # Errors
    /// [`PrepareError::EmptyView`] without pixels, [`PrepareError::TooLarge`] beyond the device's limits,
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn new(device: &wgpu::Device, size: (u32, u32)) -> Result<Self, PrepareError> {
        if size.0 == 0 || size.1 == 0 {
            return Err(PrepareError::EmptyView { view: 0 });
        }
        check_side(device, "a view's side", size, "pixels")?;
        let texture =
            prepared(device, "a view's depth", || depth_texture(device, "drawn depth of a view", size, 1))?;
        Ok(Self { texture })
    }

    /// The texture; it may be tested against in later passes of the same camera.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// What a [`View`](crate::View) is given.
    pub fn scene_depth(&self) -> SceneDepth<'_> {
        SceneDepth::Buffer {
            texture: &self.texture,
            order: DepthOrder::Reversed,
            near: DEFAULT_NEAR,
            far: f32::INFINITY,
        }
    }
}

impl DepthDrawer {
    /// Encodes the pass that draws what `camera` sees, from [`DEFAULT_NEAR`] on.
    ///
    /// # Errors
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn draw_view(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        triangles: &Triangles,
        camera: &Camera,
        depth: &DrawnDepth,
    ) -> Result<(), PrepareError> {
        let size = (depth.texture.width(), depth.texture.height());
        let face = face_of(camera, size);
        let eye = Eye::new(&face, triangles.middle, size, DEFAULT_NEAR, f32::INFINITY);
        prepared(device, "a view's depth", || {
            let target = depth.texture.create_view(&wgpu::TextureViewDescriptor::default());
            self.encode(device, encoder, triangles, &eye, &target, "depth of a view");
        })
    }
}
