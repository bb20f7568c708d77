//! What every compute pass is made of: layout entries, pipelines specialised by constants, encoding.

use crate::checked::created;
use crate::pipelines::Pipelines;
use crate::timing::PassTimer;
use crate::{CreateError, shader};

/// What a frame is encoded from, in order.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    /// A dispatch.
    Compute(ComputePass),
    /// A draw.
    Draw(DrawPass),
    /// Fills a buffer with zeros.
    Clear(wgpu::Buffer),
    /// Copies all of a buffer to the beginning of another.
    Copy { from: wgpu::Buffer, to: wgpu::Buffer },
    /// Copies a buffer into all of a texture, row by row.
    CopyToTexture { from: wgpu::Buffer, bytes_per_row: u32, to: wgpu::Texture },
}

impl Step {
    /// The name of a pass; what is none has no name and no time.
    pub(crate) fn label(&self) -> Option<&str> {
        match self {
            Self::Compute(pass) => Some(&pass.label),
            Self::Draw(pass) => Some(&pass.label),
            Self::Clear(_) | Self::Copy { .. } | Self::CopyToTexture { .. } => None,
        }
    }

    /// Encodes the step; `index` is that of the pass among the passes that `timer` times.
    fn encode(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&PassTimer>, index: u32) {
        match self {
            Self::Compute(pass) => pass.encode(encoder, timer.map(|timer| timer.writes(index))),
            Self::Draw(pass) => pass.encode(encoder, timer.map(|timer| timer.draw_writes(index))),
            Self::Clear(buffer) => encoder.clear_buffer(buffer, 0, None),
            Self::CopyToTexture { from, bytes_per_row, to } => encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer: from,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(*bytes_per_row),
                        rows_per_image: None,
                    },
                },
                to.as_image_copy(),
                to.size(),
            ),
            Self::Copy { from, to } => encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size()),
        }
    }
}

/// Encodes steps in order, the passes among them with their stamps.
pub(crate) fn encode_all(steps: &[Step], encoder: &mut wgpu::CommandEncoder, timer: Option<&PassTimer>) {
    let mut index = 0;
    for step in steps {
        step.encode(encoder, timer, index);
        index += u32::from(step.label().is_some());
    }
}

/// How many groups of threads a dispatch has.
#[derive(Debug, Clone)]
pub(crate) enum Dispatch {
    /// So many along each axis.
    Groups([u32; 3]),
    /// As many as three words of a buffer say, from this byte on.
    Indirect(wgpu::Buffer, u64),
}

/// A dispatch that is ready to be encoded.
#[derive(Debug, Clone)]
pub(crate) struct ComputePass {
    pub(crate) label: String,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) groups: Vec<wgpu::BindGroup>,
    pub(crate) dispatch: Dispatch,
}

impl ComputePass {
    /// Encodes the dispatch as a pass of its own.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&self.label), timestamp_writes });
        pass.set_pipeline(&self.pipeline);
        for (group, index) in self.groups.iter().zip(0..) {
            pass.set_bind_group(index, group, &[]);
        }
        match &self.dispatch {
            Dispatch::Groups([x, y, z]) => pass.dispatch_workgroups(*x, *y, *z),
            Dispatch::Indirect(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, *offset),
        }
    }
}

/// What a draw goes into, and what it holds before.
#[derive(Debug, Clone)]
pub(crate) enum DrawTarget {
    Color(wgpu::TextureView, wgpu::Color),
    Depth(wgpu::TextureView, f32),
}

/// How many vertices a draw has, and of how many instances.
#[derive(Debug, Clone)]
pub(crate) enum Call {
    /// So many of both.
    Direct { vertices: u32, instances: u32 },
    /// As four words of a buffer say, from this byte on.
    Indirect(wgpu::Buffer, u64),
    /// As five words of a buffer say, from this byte on, with indices of 32 bits from another.
    Indexed { indices: wgpu::Buffer, arguments: (wgpu::Buffer, u64) },
    /// So many indices again and again, a number added to each that differs from one draw to the next.
    Tiles { indices: wgpu::Buffer, count: u32, firsts: Vec<i32>, instances: u32 },
}

/// A draw that is ready to be encoded.
#[derive(Debug, Clone)]
pub(crate) struct Draw {
    pub(crate) pipeline: wgpu::RenderPipeline,
    pub(crate) group: wgpu::BindGroup,
    pub(crate) call: Call,
}

/// Draws into one target.
#[derive(Debug, Clone)]
pub(crate) struct DrawPass {
    pub(crate) label: String,
    pub(crate) target: DrawTarget,
    pub(crate) draws: Vec<Draw>,
}

impl DrawPass {
    /// Encodes the draws as a pass of its own.
    fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let store = wgpu::StoreOp::Store;
        let color = match &self.target {
            DrawTarget::Color(view, clear) => Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(*clear), store },
            }),
            DrawTarget::Depth(..) => None,
        };
        let depth = match &self.target {
            DrawTarget::Depth(view, clear) => Some(wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(*clear), store }),
                stencil_ops: None,
            }),
            DrawTarget::Color(..) => None,
        };
        let colors: Vec<_> = color.into_iter().map(Some).collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&self.label),
            color_attachments: &colors,
            depth_stencil_attachment: depth,
            timestamp_writes,
            ..Default::default()
        });
        for draw in &self.draws {
            pass.set_pipeline(&draw.pipeline);
            pass.set_bind_group(0, &draw.group, &[]);
            match &draw.call {
                Call::Direct { vertices, instances } => pass.draw(0..*vertices, 0..*instances),
                Call::Indirect(buffer, at) => pass.draw_indirect(buffer, *at),
                Call::Indexed { indices, arguments: (buffer, at) } => {
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed_indirect(buffer, *at);
                }
                Call::Tiles { indices, count, firsts, instances } => {
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    for first in firsts {
                        pass.draw_indexed(0..*count, *first, 0..*instances);
                    }
                }
            }
        }
    }
}

/// A group of resources, bound in turn from 0 on.
pub(crate) fn bind<const N: usize>(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource<'_>; N],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .into_iter()
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// A compute pipeline of a shader of the library, with its override constants.
pub(crate) fn compute_pipeline(
    pipelines: &Pipelines,
    pass: &str,
    layouts: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, CreateError> {
    // a pass has the same layouts wherever it is made, but for groups that a variant leaves out
    pipelines.compute(format!("{pass} {constants:?} {}", layouts.len()), || {
        pipeline(pipelines.device(), pass, shader::assemble(pass)?, Some(layouts), constants)
    })
}

/// The same of a scattering pass over the pixels of a list.
pub(crate) fn listed_pipeline(
    pipelines: &Pipelines,
    pass: &str,
    layouts: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, CreateError> {
    pipelines.compute(format!("listed {pass} {constants:?} {}", layouts.len()), || {
        pipeline(pipelines.device(), pass, shader::assemble_listed(pass)?, Some(layouts), constants)
    })
}

/// A render pipeline of a shader of the library with one bind group; `name` tells it from others of the same shader, and
/// `describe` makes it of the module and the layout.
pub(crate) fn draw_pipeline(
    pipelines: &Pipelines,
    name: String,
    pass: &str,
    layout: &wgpu::BindGroupLayout,
    describe: impl FnOnce(&wgpu::ShaderModule, &wgpu::PipelineLayout) -> wgpu::RenderPipeline,
) -> Result<wgpu::RenderPipeline, CreateError> {
    let device = pipelines.device();
    pipelines.drawing(name, || {
        let source = shader::assemble(pass)?;
        created(device, pass, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(pass),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(pass),
                bind_group_layouts: &[Some(layout)],
                ..Default::default()
            });
            describe(&module, &layout)
        })
    })
}

/// A compute pipeline with the bind groups that its shader declares.
pub(crate) fn probe_pipeline(
    device: &wgpu::Device,
    pass: &str,
) -> Result<wgpu::ComputePipeline, CreateError> {
    pipeline(device, pass, shader::assemble(pass)?, None, &[])
}

fn pipeline(
    device: &wgpu::Device,
    pass: &str,
    source: String,
    layouts: Option<&[&wgpu::BindGroupLayout]>,
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, CreateError> {
    created(device, pass, || {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(pass),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = layouts.map(|layouts| {
            let layouts: Vec<_> = layouts.iter().map(|&layout| Some(layout)).collect();
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(pass),
                bind_group_layouts: &layouts,
                ..Default::default()
            })
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(pass),
            layout: layout.as_ref(),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        })
    })
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    let visibility = wgpu::ShaderStages::COMPUTE;
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// A float texture that is read texel by texel.
pub(crate) fn texture(binding: u32, dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: dimension,
            multisampled: false,
        },
    )
}

/// A float texture that is filtered.
pub(crate) fn filtered_texture(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    )
}

/// A sampler that filters.
pub(crate) fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(binding, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering))
}

/// A depth texture.
pub(crate) fn depth_texture(
    binding: u32,
    dimension: wgpu::TextureViewDimension,
) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: dimension,
            multisampled: false,
        },
    )
}

/// A texture that is written.
pub(crate) fn storage_texture(
    binding: u32,
    format: wgpu::TextureFormat,
    dimension: wgpu::TextureViewDimension,
) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: dimension,
        },
    )
}

/// A uniform buffer.
pub(crate) fn uniform(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    )
}

/// A buffer that is read.
pub(crate) fn storage(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    )
}

/// A buffer that is read and written.
pub(crate) fn storage_written(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    )
}

/// The same entry for a draw that reads it; fragments alone write.
pub(crate) fn drawn(entry: wgpu::BindGroupLayoutEntry) -> wgpu::BindGroupLayoutEntry {
    let writes = matches!(
        entry.ty,
        wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { read_only: false }, .. }
    );
    let visibility = if writes { wgpu::ShaderStages::FRAGMENT } else { wgpu::ShaderStages::VERTEX_FRAGMENT };
    wgpu::BindGroupLayoutEntry { visibility, ..entry }
}
