//! What every compute pass is made of: layout entries, pipelines specialised by constants, encoding.

use crate::checked::created;
use crate::{CreateError, shader};

/// A dispatch that is ready to be encoded.
#[derive(Debug, Clone)]
pub(crate) struct ComputePass {
    pub(crate) label: String,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) groups: Vec<wgpu::BindGroup>,
    pub(crate) workgroups: [u32; 3],
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
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

/// A compute pipeline of a shader of the library, with its override constants.
pub(crate) fn compute_pipeline(
    device: &wgpu::Device,
    pass: &str,
    layouts: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, CreateError> {
    let layouts: Vec<_> = layouts.iter().map(|&layout| Some(layout)).collect();
    pipeline(device, pass, Some(&layouts), constants)
}

/// A compute pipeline with the bind groups that its shader declares.
pub(crate) fn probe_pipeline(
    device: &wgpu::Device,
    pass: &str,
) -> Result<wgpu::ComputePipeline, CreateError> {
    pipeline(device, pass, None, &[])
}

fn pipeline(
    device: &wgpu::Device,
    pass: &str,
    layouts: Option<&[Option<&wgpu::BindGroupLayout>]>,
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, CreateError> {
    let source = shader::assemble(pass)?;
    created(device, pass, || {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(pass),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = layouts.map(|layouts| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(pass),
                bind_group_layouts: layouts,
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
