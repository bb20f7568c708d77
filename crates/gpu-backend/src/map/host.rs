//! Maps from depth buffers that a host's renderer draws, converted on the GPU. Twin of `shaders/map/heights.wgsl`.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use shadowmap::{Bias, DepthEncoding, DepthOrder, Projection, ProjectionKind};

use super::{NOTHING, ShadowMap};
use crate::checked::filled_buffer;
use crate::pass::{ComputePass, Dispatch, compute_pipeline, depth_texture, storage_texture, uniform};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError};

const PASS: &str = "map/heights";

/// A depth texture that a host's renderer draws, and the convention of its values.
///
/// The texture has a depth format and `TEXTURE_BINDING` usage, one sample a texel, and one layer a face: 1, or the 6
/// of a cube in the order of cube textures. It may be compared with in the host's own shaders as well.
#[derive(Debug, Clone, Copy)]
pub struct HostDepth<'a> {
    /// The texture.
    pub texture: &'a wgpu::Texture,
    /// Which end of [0, 1] is near.
    pub order: DepthOrder,
    /// Near plane of the matrix that draws it; units: m.
    pub near: f32,
    /// Far plane; units: m; may be infinite in perspective.
    pub far: f32,
}

/// `Convention` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Convention {
    scale: f32,
    offset: f32,
    far: f32,
    nothing: f32,
    bias: f32,
    flat: u32,
    _pad: [u32; 2],
}

/// What a map is converted from.
#[derive(Debug)]
pub(crate) struct HostSource {
    view: wgpu::TextureView,
    convention: Convention,
}

/// 1/depth (perspective) or −depth (orthographic) as scale·d + offset of the device depth d.
pub(crate) fn height_of_device(order: DepthOrder, near: f32, far: f32, flat: bool) -> (f64, f64) {
    let (n, f) = (f64::from(near), f64::from(far));
    // at the near end and at the far end
    let (near_height, far_height) = if flat { (-n, -f) } else { (1.0 / n, 1.0 / f) };
    match order {
        DepthOrder::Forward => (far_height - near_height, near_height),
        DepthOrder::Reversed => (near_height - far_height, far_height),
    }
}

/// Checks that a texture can be read as depth.
pub(crate) fn check_depth_texture(
    what: &'static str,
    texture: &wgpu::Texture,
    layers: u32,
) -> Result<(), PrepareError> {
    let wrong =
        |got: String, wanted: &str| Err(PrepareError::Texture { what, got, wanted: wanted.to_owned() });
    if !texture.format().has_depth_aspect() {
        return wrong(format!("of format {:?}", texture.format()), "of a depth format");
    }
    if !texture.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING) {
        return wrong(format!("of usage {:?}", texture.usage()), "made with TEXTURE_BINDING");
    }
    if texture.sample_count() != 1 {
        return wrong(format!("of {} samples a texel", texture.sample_count()), "of one sample a texel");
    }
    if texture.depth_or_array_layers() < layers {
        return wrong(
            format!("of {} layers", texture.depth_or_array_layers()),
            if layers == 6 { "of 6 layers" } else { "of 1 layer" },
        );
    }
    Ok(())
}

impl ShadowMap {
    /// The map of a depth texture that the host draws; it is read again by every frame that is prepared with it after
    /// [`ShadowMap::touch`], and by the first.
    ///
    /// # Errors
    /// [`PrepareError::Texture`] if the texture cannot be read as depth, [`PrepareError::Map`] if no depth lies between
    /// the planes, else as [`ShadowMap::upload`].
    pub fn from_host(
        device: &wgpu::Device,
        depth: HostDepth<'_>,
        projection: Projection,
        bias: Bias,
    ) -> Result<Self, PrepareError> {
        let source = HostSource::new(depth, &projection, bias)?;
        let mut map = Self::empty(device, projection, (depth.texture.width(), depth.texture.height()))?;
        map.host = Some(Arc::new(source));
        Ok(map)
    }

    /// The same map for a light that sees through another projection of the same kind, or of another depth texture of
    /// the same size; it is read again by the next frame.
    ///
    /// # Errors
    /// [`PrepareError::Texture`] if the texture has another size or the projection another kind, else as
    /// [`ShadowMap::from_host`].
    pub fn update_host(
        &mut self,
        depth: HostDepth<'_>,
        projection: Projection,
        bias: Bias,
    ) -> Result<(), PrepareError> {
        self.check_same((depth.texture.width(), depth.texture.height()), &projection)?;
        self.host = Some(Arc::new(HostSource::new(depth, &projection, bias)?));
        self.projection = projection;
        self.touch();
        Ok(())
    }
}

impl HostSource {
    fn new(depth: HostDepth<'_>, projection: &Projection, bias: Bias) -> Result<Self, PrepareError> {
        let HostDepth { texture, order, near, far } = depth;
        let flat = projection.kind() == ProjectionKind::Orthographic;
        let faces = projection.faces().len() as u32;
        check_depth_texture("the shadow map's depth texture", texture, faces)?;
        DepthEncoding::Device { order, near, far }.check(projection)?;
        let (scale, offset) = height_of_device(order, near, far, flat);
        let convention = Convention {
            scale: scale as f32,
            offset: offset as f32,
            far: if order == DepthOrder::Forward { 1.0 } else { 0.0 },
            nothing: if flat { NOTHING } else { 0.0 },
            bias: bias.in_medium() as f32,
            flat: u32::from(flat),
            _pad: [0; 2],
        };
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("host shadow map"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            aspect: wgpu::TextureAspect::DepthOnly,
            array_layer_count: Some(faces),
            mip_level_count: Some(1),
            ..Default::default()
        });
        Ok(Self { view, convention })
    }
}

/// The pipeline that converts a host's maps.
#[derive(Debug)]
pub(crate) struct HostConverter {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl HostConverter {
    pub(crate) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let array = wgpu::TextureViewDimension::D2Array;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(PASS),
            entries: &[
                depth_texture(0, array),
                storage_texture(1, wgpu::TextureFormat::R32Float, array),
                uniform(2),
            ],
        });
        let pipeline = compute_pipeline(pipelines, PASS, &[&layout], &[])?;
        Ok(Self { layout, pipeline })
    }

    /// The pass that reads the host's depth into the heights of `map`.
    pub(crate) fn pass(&self, device: &wgpu::Device, map: &ShadowMap, source: &HostSource) -> ComputePass {
        let convention = filled_buffer(
            device,
            "depth convention",
            bytemuck::bytes_of(&source.convention),
            wgpu::BufferUsages::UNIFORM,
        );
        let heights = map.heights.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(PASS),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&source.view),
                },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&heights) },
                wgpu::BindGroupEntry { binding: 2, resource: convention.as_entire_binding() },
            ],
        });
        let (width, height) = map.size;
        ComputePass {
            label: "map heights".into(),
            pipeline: self.pipeline.clone(),
            groups: vec![group],
            dispatch: Dispatch::Groups([
                width.div_ceil(8),
                height.div_ceil(8),
                map.projection.faces().len() as u32,
            ]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct(PASS, "Convention");
        assert_eq!(span as usize, size_of::<Convention>());
        assert_eq!(fields, offsets!(Convention: scale, offset, far, nothing, bias, flat, _pad));
    }

    #[test]
    fn device_depths_become_heights() {
        // near 1, far 4: forward depth of 2 m is 4·1/(2·3) = 2/3
        let (scale, offset) = height_of_device(DepthOrder::Forward, 1.0, 4.0, false);
        assert!((scale * 2.0 / 3.0 + offset - 0.5).abs() < 1e-12);
        // reversed, far infinite: n/z
        let (scale, offset) = height_of_device(DepthOrder::Reversed, 0.5, f32::INFINITY, false);
        assert!((scale * 0.25 + offset - 0.5).abs() < 1e-12);
        let (scale, offset) = height_of_device(DepthOrder::Forward, 1.0, 5.0, true);
        assert!((scale * 0.25 + offset + 2.0).abs() < 1e-12);
    }
}
