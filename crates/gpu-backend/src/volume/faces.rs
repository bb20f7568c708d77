//! The frontmost and backmost side faces of a shadow volume in a view. Twin of `shaders/volume/{tiles,resolve,faces,
//! face_depths,merge}.wgsl`.

use scene::{Camera, Light};

use super::silhouette::{DISPATCH_AT, DRAW_AT};
use super::{Faces, ShadowVolume, compute};
use crate::checked::{check_size, filled_buffer, prepared};
use crate::layout::{ImagePlane, VolumeUniform};
use crate::pass::{
    Call, ComputePass, Dispatch, Draw, DrawPass, DrawTarget, Step, bind, compute_pipeline, depth_texture,
    draw_pipeline, drawn, storage, storage_texture, storage_written, uniform,
};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError};

/// Share of the casters' diagonal that faces nearer to the eye are not told apart in.
const NEAR: f64 = 1e-5;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What faces are found for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceTarget<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) light: &'a Light,
    pub(crate) faces: Faces,
    /// The image with a tile a texel.
    pub(crate) image: ImagePlane,
    /// How far faces are moved apart in tiles; see [`VolumeUniform::new`].
    pub(crate) margin: f64,
}

/// Pipelines of the passes.
#[derive(Debug)]
pub(crate) struct FacePasses {
    tiles: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    resolve: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    draw_layout: wgpu::BindGroupLayout,
    drawn: Drawn,
}

/// How faces are drawn for each pixel.
#[derive(Debug)]
enum Drawn {
    /// Greatest values are kept by blending.
    Blended(wgpu::RenderPipeline),
    /// The frontmost and the backmost are kept by depth tests and merged.
    Tested {
        front: wgpu::RenderPipeline,
        back: wgpu::RenderPipeline,
        merge: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    },
}

impl FacePasses {
    pub(super) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let flat = wgpu::TextureViewDimension::D2;
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let pass = |name: &'static str, entries: &[wgpu::BindGroupLayoutEntry]| {
            let layout = layout(name, entries);
            let pipeline = compute_pipeline(pipelines, name, &[&layout], &[])?;
            Ok::<_, CreateError>((layout, pipeline))
        };
        let tiles =
            pass("volume/tiles", &[uniform(0), storage(1), storage(2), storage(3), storage_written(4)])?;
        let resolve = pass("volume/resolve", &[storage(0), storage_texture(1, FORMAT, flat)])?;
        let draw_layout = layout("volume/faces", &[drawn(uniform(0)), drawn(storage(1)), drawn(storage(3))]);
        let how = if device.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
            Drawn::Blended(faces_pipeline(pipelines, &draw_layout, "volume/faces", None)?)
        } else {
            let tested =
                |compare| faces_pipeline(pipelines, &draw_layout, "volume/face_depths", Some(compare));
            Drawn::Tested {
                front: tested(wgpu::CompareFunction::Greater)?,
                back: tested(wgpu::CompareFunction::Less)?,
                merge: pass(
                    "volume/merge",
                    &[
                        uniform(0),
                        depth_texture(1, flat),
                        depth_texture(2, flat),
                        storage_texture(3, FORMAT, flat),
                    ],
                )?,
            }
        };
        Ok(Self { tiles, resolve, draw_layout, drawn: how })
    }

    pub(super) fn steps(
        &self,
        device: &wgpu::Device,
        volume: &ShadowVolume,
        target: &FaceTarget<'_>,
    ) -> Result<(Vec<Step>, wgpu::Texture), PrepareError> {
        let size = target.image.size;
        check_size(device, "the faces of a view", 8 * u64::from(size.0) * u64::from(size.1))?;
        let bounds = volume.casters.bounds();
        let near = (NEAR * f64::from(bounds.diagonal())).max(1e-30);
        prepared(device, "the faces of a view", || {
            let texture = image(device, "shadow volume faces", FORMAT, size);
            let margin = if target.faces == Faces::Pixels { 0.0 } else { target.margin };
            let uniform = VolumeUniform::new(
                target.camera,
                &target.image,
                target.light,
                volume.casters.middle,
                near,
                margin,
            );
            let uniform = filled_buffer(
                device,
                "shadow volume",
                bytemuck::bytes_of(&uniform),
                wgpu::BufferUsages::UNIFORM,
            );
            let steps = match target.faces {
                Faces::Tiles(_) => self.walk(device, volume, &uniform, &texture),
                Faces::Pixels => self.draw(device, volume, &uniform, &texture),
            };
            (steps, texture)
        })
    }

    /// Tile by tile, in compute.
    fn walk(
        &self,
        device: &wgpu::Device,
        volume: &ShadowVolume,
        uniform: &wgpu::Buffer,
        texture: &wgpu::Texture,
    ) -> Vec<Step> {
        let tiles = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tiles of a shadow volume"),
            size: 8 * u64::from(texture.width()) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let buffers = [uniform, &volume.casters.positions, &volume.head, &volume.found, &tiles];
        let walked = buffers.map(wgpu::Buffer::as_entire_binding);
        let resolved = [tiles.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
        vec![
            Step::Clear(tiles.clone()),
            compute(ComputePass {
                label: "shadow volume, tiles".into(),
                pipeline: self.tiles.1.clone(),
                groups: vec![bind(device, "shadow volume", &self.tiles.0, walked)],
                dispatch: Dispatch::Indirect(volume.head.clone(), DISPATCH_AT),
            }),
            compute(ComputePass {
                label: "shadow volume, faces".into(),
                pipeline: self.resolve.1.clone(),
                groups: vec![bind(device, "shadow volume", &self.resolve.0, resolved)],
                dispatch: over(texture),
            }),
        ]
    }

    /// Pixel by pixel, by the rasteriser.
    fn draw(
        &self,
        device: &wgpu::Device,
        volume: &ShadowVolume,
        uniform: &wgpu::Buffer,
        texture: &wgpu::Texture,
    ) -> Vec<Step> {
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group_of = || {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("shadow volume"),
                layout: &self.draw_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: volume.casters.positions.as_entire_binding(),
                    },
                    wgpu::BindGroupEntry { binding: 3, resource: volume.found.as_entire_binding() },
                ],
            })
        };
        let draw = |label: &str, pipeline: &wgpu::RenderPipeline, target| {
            let call = Call::Indirect(volume.head.clone(), DRAW_AT);
            let draw = Draw { pipeline: pipeline.clone(), group: group_of(), call };
            Step::Draw(DrawPass { label: label.into(), target, draws: vec![draw] })
        };
        match &self.drawn {
            Drawn::Blended(pipeline) => {
                // 1/z of 0 is no face; its negative is never greater than a face's
                let nothing = wgpu::Color { r: 0.0, g: -1e30, b: 0.0, a: 0.0 };
                vec![draw("shadow volume, faces", pipeline, DrawTarget::Color(view(texture), nothing))]
            }
            Drawn::Tested { front, back, merge } => {
                let size = (texture.width(), texture.height());
                let depths = [(); 2].map(|()| view(&image(device, "shadow volume depth", DEPTH, size)));
                let merged = [
                    uniform.as_entire_binding(),
                    wgpu::BindingResource::TextureView(&depths[0]),
                    wgpu::BindingResource::TextureView(&depths[1]),
                    wgpu::BindingResource::TextureView(&view(texture)),
                ];
                let merged = bind(device, "shadow volume", &merge.0, merged);
                let [near, far] = depths;
                vec![
                    draw("shadow volume, front faces", front, DrawTarget::Depth(near, 0.0)),
                    draw("shadow volume, back faces", back, DrawTarget::Depth(far, 1.0)),
                    compute(ComputePass {
                        label: "shadow volume, merge".into(),
                        pipeline: merge.1.clone(),
                        groups: vec![merged],
                        dispatch: over(texture),
                    }),
                ]
            }
        }
    }
}

/// One thread a texel, in groups of 8 × 8.
fn over(texture: &wgpu::Texture) -> Dispatch {
    Dispatch::Groups([texture.width().div_ceil(8), texture.height().div_ceil(8), 1])
}

fn image(device: &wgpu::Device, label: &str, format: wgpu::TextureFormat, size: (u32, u32)) -> wgpu::Texture {
    use wgpu::TextureUsages as Usage;
    let written = if format == DEPTH { Usage::empty() } else { Usage::STORAGE_BINDING | Usage::COPY_SRC };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: Usage::TEXTURE_BINDING | Usage::RENDER_ATTACHMENT | written,
        view_formats: &[],
    })
}

/// The draw of all faces: into a texture by greatest values, or with a depth test.
fn faces_pipeline(
    pipelines: &Pipelines,
    layout: &wgpu::BindGroupLayout,
    pass: &'static str,
    compare: Option<wgpu::CompareFunction>,
) -> Result<wgpu::RenderPipeline, CreateError> {
    let greatest = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Max,
    };
    let color = wgpu::ColorTargetState {
        format: FORMAT,
        blend: Some(wgpu::BlendState { color: greatest, alpha: greatest }),
        write_mask: wgpu::ColorWrites::ALL,
    };
    let targets = if compare.is_none() { vec![Some(color)] } else { Vec::new() };
    draw_pipeline(pipelines, format!("{pass} {compare:?}"), pass, layout, |module, layout| {
        pipelines.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(pass),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: compare.map(|compare| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}
