//! Depth as a light sees it: the faces of a shadow map.

use scene::Aabb;
use shadowmap::{Bias, DepthOrder, Face, Projection, ProjectionKind};

use super::{DepthDrawer, Eye, Triangles, depth_texture};
use crate::checked::prepared;
use crate::map::check_side;
use crate::{HostDepth, PrepareError, ShadowMap};

/// A shadow map whose depth is drawn on the GPU.
#[derive(Debug)]
pub struct DrawnMap {
    depth: wgpu::Texture,
    map: ShadowMap,
    bias: Bias,
    /// Near and far; units: m.
    planes: (f32, f32),
}

impl DrawnMap {
    /// Makes the map of `size` texels a face for a light that sees through `projection` what lies within `bounds`;
    /// nothing is drawn yet.
    ///
    /// # Errors
    /// As [`ShadowMap::from_host`].
    pub fn new(
        device: &wgpu::Device,
        projection: Projection,
        size: (u32, u32),
        bounds: &Aabb,
        bias: Bias,
    ) -> Result<Self, PrepareError> {
        check_side(device, "the shadow map's side", size, "texels")?;
        if size.0 == 0 || size.1 == 0 {
            return Err(shadowmap::ShadowMapError::Size { width: size.0, height: size.1 }.into());
        }
        let faces = projection.faces().len() as u32;
        let depth = prepared(device, "the shadow map", || {
            depth_texture(device, "drawn depth of a light", size, faces)
        })?;
        let host = host_depth(&depth, &projection, bounds);
        let planes = (host.near, host.far);
        let map = ShadowMap::from_host(device, host, projection, bias)?;
        Ok(Self { depth, map, bias, planes })
    }

    /// What a [`Lamp`](crate::Lamp) is given.
    pub fn map(&self) -> &ShadowMap {
        &self.map
    }

    /// The depth texture, a layer a face, with its convention; it may be compared with in other passes.
    pub fn depth(&self) -> HostDepth<'_> {
        let (near, far) = self.planes;
        HostDepth { texture: &self.depth, order: DepthOrder::Reversed, near, far }
    }

    /// Says where the light sees from now, and what lies within `bounds`; to be drawn again.
    ///
    /// # Errors
    /// As [`ShadowMap::update_host`].
    pub fn set_projection(&mut self, projection: Projection, bounds: &Aabb) -> Result<(), PrepareError> {
        let host = host_depth(&self.depth, &projection, bounds);
        let planes = (host.near, host.far);
        self.map.update_host(host, projection, self.bias)?;
        self.planes = planes;
        Ok(())
    }
}

impl DepthDrawer {
    /// Encodes the passes that draw what the light sees, one a face, and says to the map that it changed.
    ///
    /// The commands have to be submitted before those of [`Fog::encode`](crate::Fog::encode), or come before them in one
    /// encoder. The values are those of [`DepthMap::draw`](shadowmap::DepthMap::draw), to rounding, but for texels whose
    /// centre lies within a step of the rasteriser's grid of a triangle's edge: 1/256 of a texel on most devices, 1/16 where a
    /// device has no more than Vulkan asks for. Without perspective, what lies farther than the map's
    /// bounds is not seen.
    ///
    /// # Errors
    /// [`PrepareError::Device`] if there is no memory or the device is lost.
    pub fn draw_map(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        triangles: &Triangles,
        map: &DrawnMap,
    ) -> Result<(), PrepareError> {
        let (near, far) = map.planes;
        prepared(device, "the shadow map", || {
            for (face, layer) in map.map.projection().faces().iter().zip(0..) {
                let target = map.depth.create_view(&wgpu::TextureViewDescriptor {
                    label: Some("face of a light's depth"),
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                });
                let eye = Eye::new(face, triangles.middle, map.map.size(), near, far);
                self.encode(device, encoder, triangles, &eye, &target, "depth of a light");
            }
        })?;
        map.map.touch();
        Ok(())
    }
}

/// The convention in which a projection is drawn.
fn host_depth<'a>(texture: &'a wgpu::Texture, projection: &Projection, bounds: &Aabb) -> HostDepth<'a> {
    let (near, far) = match projection.kind() {
        ProjectionKind::Orthographic => (0.0, farthest(&projection.faces()[0], bounds)),
        ProjectionKind::Perspective | ProjectionKind::Cube => (projection.near(), f32::INFINITY),
    };
    HostDepth { texture, order: DepthOrder::Reversed, near, far }
}

/// A depth that nothing within `bounds` reaches; units: m.
fn farthest(face: &Face, bounds: &Aabb) -> f32 {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (center, arm) = (0.5 * (min + max), 0.5 * (max - min));
    let depth = (center - face.origin).dot(face.forward) + face.forward.abs().dot(arm);
    // a sixteenth more: what is at the far plane counts as nothing
    if depth > 0.0 { (1.0625 * depth) as f32 } else { 1.0 }
}
