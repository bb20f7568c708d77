//! Depth of triangles as lights and cameras see them, drawn on the GPU.
//!
//! For a renderer without shadow maps or a depth pass of its own. Twin of `shaders/map/depth.wgsl`; the same map on the
//! CPU is [`DepthMap::draw`](shadowmap::DepthMap::draw).

mod eye;
mod map;
mod triangles;
mod view;

pub use map::DrawnMap;
pub use triangles::Triangles;
pub use view::DrawnDepth;

use eye::Eye;

use crate::checked::{created, filled_buffer};
use crate::pass::uniform;
use crate::{CreateError, shader};

const PASS: &str = "map/depth";

/// Format of what is drawn.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The pipeline that draws depth: reversed z, both sides of every triangle.
///
/// Nothing here submits: passes go into the host's encoder.
#[derive(Debug)]
pub struct DepthDrawer {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl DepthDrawer {
    /// Compiles the pipeline.
    ///
    /// # Errors
    /// [`CreateError`] if the shader does not compile on this device, or the device is lost.
    pub fn new(device: &wgpu::Device) -> Result<Self, CreateError> {
        let source = shader::assemble(PASS)?;
        created(device, PASS, || {
            let mut entry = uniform(0);
            entry.visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(PASS),
                entries: &[entry],
            });
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(PASS),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            let pipeline = pipeline(device, &layout, &module);
            Self { layout, pipeline }
        })
    }

    /// Encodes a pass that clears `target` and draws the triangles into it as `eye` sees them.
    fn encode(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        triangles: &Triangles,
        eye: &Eye,
        target: &wgpu::TextureView,
        label: &str,
    ) {
        let buffer = filled_buffer(device, label, bytemuck::bytes_of(eye), wgpu::BufferUsages::UNIFORM);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &self.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: target,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        if triangles.count > 0 {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_vertex_buffer(0, triangles.buffer.slice(..));
            pass.draw(0..3, 0..triangles.count);
        }
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(PASS),
        bind_group_layouts: &[Some(layout)],
        ..Default::default()
    });
    // one triangle an instance: every corner knows the other two
    let corners = wgpu::VertexBufferLayout {
        array_stride: triangles::STRIDE,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3],
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(PASS),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vs_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(corners)],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("fs_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A depth texture with a layer a face.
fn depth_texture(device: &wgpu::Device, label: &str, size: (u32, u32), layers: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
