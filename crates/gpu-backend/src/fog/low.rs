//! Scattering at a lower resolution than the picture's. Twin of `shaders/frame/{downsample,upsample}.wgsl`; the same on
//! the CPU is `hybrid_march::LowResolution`.

use bytemuck::{Pod, Zeroable};

use super::targets::Targets;
use crate::CreateError;
use crate::checked::filled_buffer;
use crate::pass::{ComputePass, Dispatch, compute_pipeline, storage_texture, texture, uniform};
use crate::pipelines::Pipelines;

/// Most pixels along the side of a block, as in `hybrid_march::LowResolution`.
pub(crate) const MOST_SCALE: u32 = 64;

/// `Blocks` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Blocks {
    scale: u32,
    refines: u32,
    _pad1: u32,
    _pad2: u32,
}

/// The passes that go to blocks of pixels and back.
#[derive(Debug)]
pub(crate) struct LowPasses {
    down: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    up: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
}

impl LowPasses {
    pub(super) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let flat = wgpu::TextureViewDimension::D2;
        let ends = |binding| storage_texture(binding, wgpu::TextureFormat::R32Float, flat);
        let pass = |name: &'static str, entries: &[wgpu::BindGroupLayoutEntry]| {
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries });
            let pipeline = compute_pipeline(pipelines, name, &[&layout], &[])?;
            Ok::<_, CreateError>((layout, pipeline))
        };
        let both = [uniform(0), uniform(1), texture(2, flat)];
        let [view, blocks, full] = both;
        let output = storage_texture(7, wgpu::TextureFormat::Rgba32Float, flat);
        let low = [3, 4, 5, 6].map(|binding| texture(binding, flat));
        Ok(Self {
            down: pass("frame/downsample", &[view, blocks, full, ends(3), ends(4)])?,
            up: pass("frame/upsample", &[view, blocks, full, low[0], low[1], low[2], low[3], output])?,
        })
    }

    /// Finds where the blocks' rays end in both layers.
    pub(super) fn down(
        &self,
        device: &wgpu::Device,
        view: &wgpu::Buffer,
        scale: u32,
        full: &Targets,
        low: &[Targets],
    ) -> ComputePass {
        let blocks = uniform_of(device, scale, false);
        let views: Vec<_> = std::iter::once(full).chain(low).map(|t| view_of(&t.ray_ends)).collect();
        ComputePass {
            label: "downsample".into(),
            pipeline: self.down.1.clone(),
            groups: vec![group(device, &self.down.0, [view, &blocks], &views)],
            dispatch: over_blocks(low),
        }
    }

    /// Spreads both layers' airlight, in the textures of number `result`, over the picture's first airlight texture, and
    /// says of pixels at depth edges whether they are to be computed anew.
    pub(super) fn up(
        &self,
        device: &wgpu::Device,
        view: &wgpu::Buffer,
        scale: u32,
        full: &Targets,
        low: &[Targets],
        result: usize,
        refines: bool,
    ) -> ComputePass {
        let blocks = uniform_of(device, scale, refines);
        let ends = std::iter::once(full).chain(low).map(|targets| view_of(&targets.ray_ends));
        let layers = low.iter().filter_map(|targets| targets.airlight[result].as_ref()).map(view_of);
        let output = full.airlight[0].iter().map(view_of);
        let views: Vec<_> = ends.chain(layers).chain(output).collect();
        ComputePass {
            label: "upsample".into(),
            pipeline: self.up.1.clone(),
            groups: vec![group(device, &self.up.0, [view, &blocks], &views)],
            dispatch: over_blocks(low),
        }
    }
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn uniform_of(device: &wgpu::Device, scale: u32, refines: bool) -> wgpu::Buffer {
    let blocks = Blocks { scale, refines: refines.into(), ..Blocks::zeroed() };
    filled_buffer(device, "blocks", bytemuck::bytes_of(&blocks), wgpu::BufferUsages::UNIFORM)
}

fn over_blocks(low: &[Targets]) -> Dispatch {
    let (width, height) = low.first().map_or((1, 1), |targets| targets.size);
    Dispatch::Groups([width.div_ceil(8), height.div_ceil(8), 1])
}

/// Uniforms, then textures, at the bindings from 0 on.
fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    uniforms: [&wgpu::Buffer; 2],
    textures: &[wgpu::TextureView],
) -> wgpu::BindGroup {
    let textures = textures.iter().map(wgpu::BindingResource::TextureView);
    let resources = uniforms.into_iter().map(wgpu::Buffer::as_entire_binding).chain(textures);
    let entries: Vec<_> =
        resources.zip(0..).map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scattering resolution"),
        layout,
        entries: &entries,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        for pass in ["frame/downsample", "frame/upsample"] {
            let (fields, span) = wgsl_struct(pass, "Blocks");
            assert_eq!(span as usize, size_of::<Blocks>());
            assert_eq!(fields, offsets!(Blocks: scale, refines, _pad1, _pad2));
        }
    }
}
