//! The draw that puts airlight over the host's picture. Twin of `shaders/frame/composite.wgsl`.

use crate::CreateError;
use crate::pass::draw_pipeline;
use crate::pipelines::Pipelines;

const PASS: &str = "frame/composite";

/// The render pass that the fog is drawn into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompositeTarget {
    /// Format of the picture; linear values, blendable.
    pub format: wgpu::TextureFormat,
    /// Format of the pass's depth attachment, if it has one; it is neither read nor written.
    pub depth_format: Option<wgpu::TextureFormat>,
    /// Samples a pixel of the pass.
    pub sample_count: u32,
}

impl CompositeTarget {
    /// A picture alone, one sample a pixel.
    pub fn picture(format: wgpu::TextureFormat) -> Self {
        Self { format, depth_format: None, sample_count: 1 }
    }
}

/// Which medium a composite is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct CompositeVariant {
    pub(super) bounded: bool,
    pub(super) density: u8,
    /// Whether this draws the transmittance of each channel.
    pub(super) attenuates: bool,
    /// Whether it adds airlight to a picture that another draw has attenuated.
    pub(super) adds: bool,
}

/// A pipeline that draws one triangle into the target.
pub(super) fn pipeline(
    pipelines: &Pipelines,
    layout: &wgpu::BindGroupLayout,
    target: &CompositeTarget,
    variant: CompositeVariant,
) -> Result<wgpu::RenderPipeline, CreateError> {
    let flag = |value: bool| f64::from(u8::from(value));
    let constants = [
        ("BOUNDED", flag(variant.bounded)),
        ("DENSITY", f64::from(variant.density)),
        ("ATTENUATES", flag(variant.attenuates)),
    ];
    let (source_factor, target_factor) = match (variant.attenuates, variant.adds) {
        (true, _) => (wgpu::BlendFactor::Zero, wgpu::BlendFactor::Src),
        (false, true) => (wgpu::BlendFactor::One, wgpu::BlendFactor::One),
        (false, false) => (wgpu::BlendFactor::One, wgpu::BlendFactor::SrcAlpha),
    };
    let part = |src_factor, dst_factor| wgpu::BlendComponent {
        src_factor,
        dst_factor,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = wgpu::BlendState {
        color: part(source_factor, target_factor),
        // the host's alpha stays
        alpha: part(wgpu::BlendFactor::Zero, wgpu::BlendFactor::One),
    };
    draw_pipeline(pipelines, format!("{PASS} {target:?} {variant:?}"), PASS, layout, |module, layout| {
        let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        pipelines.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(PASS),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: target.depth_format.map(|format| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: target.sample_count, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fs_main"),
                compilation_options: options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: target.format,
                    blend: Some(blend),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}
