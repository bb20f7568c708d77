//! The pass that reads a host's depth buffer. Twin of `shaders/frame/ray_ends.wgsl`.

use bytemuck::{Pod, Zeroable};
use shadowmap::DepthOrder;

use crate::CreateError;
use crate::checked::filled_buffer;
use crate::map::height_of_device;
use crate::pass::{ComputePass, Dispatch, compute_pipeline, depth_texture, storage_texture, uniform};
use crate::pipelines::Pipelines;

const PASS: &str = "frame/ray_ends";

/// `Convention` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Convention {
    scale: f32,
    offset: f32,
    far: f32,
    _pad: f32,
}

/// The pipeline.
#[derive(Debug)]
pub(super) struct RayEnds {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl RayEnds {
    pub(super) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let flat = wgpu::TextureViewDimension::D2;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(PASS),
            entries: &[
                uniform(0),
                depth_texture(1, flat),
                storage_texture(2, wgpu::TextureFormat::R32Float, flat),
                uniform(3),
            ],
        });
        let pipeline = compute_pipeline(pipelines, PASS, &[&layout], &[])?;
        Ok(Self { layout, pipeline })
    }

    /// The pass over a depth texture with these planes, for the view whose uniform is given.
    pub(super) fn pass(
        &self,
        device: &wgpu::Device,
        view: wgpu::BindingResource<'_>,
        depth: &wgpu::Texture,
        (order, near, far): (DepthOrder, f32, f32),
        ray_ends: &wgpu::Texture,
    ) -> ComputePass {
        let (scale, offset) = height_of_device(order, near, far, false);
        let nothing = if order == DepthOrder::Forward { 1.0 } else { 0.0 };
        let convention = Convention { scale: scale as f32, offset: offset as f32, far: nothing, _pad: 0.0 };
        let convention = filled_buffer(
            device,
            "depth convention",
            bytemuck::bytes_of(&convention),
            wgpu::BufferUsages::UNIFORM,
        );
        let depths = depth.create_view(&wgpu::TextureViewDescriptor {
            aspect: wgpu::TextureAspect::DepthOnly,
            dimension: Some(wgpu::TextureViewDimension::D2),
            array_layer_count: Some(1),
            mip_level_count: Some(1),
            ..Default::default()
        });
        let ends = ray_ends.create_view(&wgpu::TextureViewDescriptor::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(PASS),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: view },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&depths) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&ends) },
                wgpu::BindGroupEntry { binding: 3, resource: convention.as_entire_binding() },
            ],
        });
        ComputePass {
            label: "ray ends".into(),
            pipeline: self.pipeline.clone(),
            groups: vec![group],
            dispatch: Dispatch::Groups([ray_ends.width().div_ceil(8), ray_ends.height().div_ceil(8), 1]),
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
        assert_eq!(fields, offsets!(Convention: scale, offset, far, _pad));
    }
}
