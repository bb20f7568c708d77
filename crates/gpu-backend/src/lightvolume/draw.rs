//! The draws of a light volume's surface: one that notes the crossings of view rays, and one that sums the terms of those for
//! which there was no room. Twin of `shaders/lightvolume/{grid,indexed_grid,leaf_surface,mesh,walls,seams,gate,settle}.wgsl`.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use shadowmap::ProjectionKind;

use super::tessellation::DRAW_AT;
use super::{Leaves, LightMesh, Tessellation, TessellationPasses};
use crate::checked::{created, filled_buffer, prepared};
use crate::layout::{GRID_TILE, LightUniform, MeshUniform, row_bits};
use crate::pass::{
    Call, ComputePass, Dispatch, Draw, DrawPass, DrawTarget, Step, bind, compute_pipeline, draw_pipeline,
    drawn, storage, storage_texture, storage_written, texture, uniform,
};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError, ShadowMap};

/// What is drawn into where float32 blends.
const BLENDED: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// What is drawn into, and nothing written, where it does not: a render pass has to have a target.
const UNUSED: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// A part of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Part {
    /// All cells of the map.
    Grid,
    /// The same by indices.
    IndexedGrid,
    /// Triangles made beforehand, with their walls.
    Mesh,
    /// Leaves of a tessellation, with their walls.
    Leaves,
    /// What closes a single image.
    Walls,
    /// What joins the images of a cube.
    Seams,
}

impl Part {
    const fn file(self) -> &'static str {
        match self {
            Self::Grid => "lightvolume/grid",
            Self::IndexedGrid => "lightvolume/indexed_grid",
            Self::Mesh => "lightvolume/mesh",
            Self::Leaves => "lightvolume/leaf_surface",
            Self::Walls => "lightvolume/walls",
            Self::Seams => "lightvolume/seams",
        }
    }
}

/// The constants that a light's draws are specialised by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct VolumeVariant {
    /// 0 point, 1 spot, 2 directional.
    pub(crate) light: u8,
    pub(crate) achromatic: bool,
    pub(crate) isotropic: bool,
}

/// What a light volume is drawn for.
#[derive(Debug)]
pub(crate) struct VolumeTarget<'a> {
    pub(crate) variant: VolumeVariant,
    pub(crate) map: &'a ShadowMap,
    pub(crate) tessellation: Tessellation,
    /// The leaves of an adaptive tessellation.
    pub(crate) leaves: Option<&'a Leaves>,
    pub(crate) mesh: MeshUniform,
    pub(crate) light: &'a LightUniform,
    pub(crate) view: &'a wgpu::Buffer,
    pub(crate) size: (u32, u32),
    pub(crate) ray_ends: &'a wgpu::TextureView,
    /// Where float32 does not blend, the unshadowed airlight of the view.
    pub(crate) unshadowed: &'a wgpu::TextureView,
    /// A texture of one texel.
    pub(crate) stand_in: &'a wgpu::TextureView,
    /// What the sums are left in, rgba32float.
    pub(crate) sums: &'a wgpu::Texture,
    /// What crossings are noted in.
    pub(crate) kept: &'a wgpu::Buffer,
    pub(crate) label: &'a str,
}

/// What a technique that draws light volumes needs on a device.
#[derive(Debug)]
pub(crate) struct LightVolumePasses {
    pub(crate) tessellation: TessellationPasses,
    blends: bool,
    layout: wgpu::BindGroupLayout,
    /// For each part and light the one that notes crossings, and the one that sums them.
    pipelines: HashMap<(Part, VolumeVariant, bool), wgpu::RenderPipeline>,
    gate: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    settle: (wgpu::BindGroupLayout, wgpu::ComputePipeline),
    /// What the tiles of indexed grids have in common, of the width of map that was drawn last.
    tile: Mutex<Option<(u32, wgpu::Buffer)>>,
    /// Stands in for leaves and sums.
    spare: [wgpu::Buffer; 2],
}

impl LightVolumePasses {
    pub(crate) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        let device = pipelines.device();
        let (flat, array) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D2Array);
        let entries = [
            uniform(0),
            texture(1, flat),
            uniform(2),
            texture(3, array),
            uniform(4),
            storage(5),
            storage_written(6),
            texture(7, flat),
            texture(8, flat),
            storage_written(9),
            storage_written(10),
        ]
        .map(drawn);
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let pass = |name: &'static str, entries: &[wgpu::BindGroupLayoutEntry]| {
            let layout = layout(name, entries);
            let pipeline = compute_pipeline(pipelines, name, &[&layout], &[])?;
            Ok::<_, CreateError>((layout, pipeline))
        };
        let gate = pass("lightvolume/gate", &[storage(0), storage(1), storage_written(2), uniform(3)])?;
        let settle = pass("lightvolume/settle", &[storage(0), storage_texture(1, BLENDED, flat)])?;
        let spare = created(device, "light volumes", || {
            [(); 2].map(|()| {
                filled_buffer(device, "light volume stand-in", &[0; 16], wgpu::BufferUsages::STORAGE)
            })
        })?;
        Ok(Self {
            tessellation: TessellationPasses::new(pipelines)?,
            blends: device.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
            layout: layout("light volume", &entries),
            pipelines: HashMap::new(),
            gate,
            settle,
            tile: Mutex::new(None),
            spare,
        })
    }

    /// Whether sums are blended; otherwise they are shares of the unshadowed airlight in fixed point.
    pub(crate) fn blends(&self) -> bool {
        self.blends
    }

    /// Makes the pipelines of a light's draws.
    pub(crate) fn reserve(
        &mut self,
        pipelines: &Pipelines,
        variant: VolumeVariant,
        tessellation: Tessellation,
    ) -> Result<(), CreateError> {
        let (notes, sums) = match tessellation {
            Tessellation::Grid => (Part::Grid, Part::Grid),
            // tiles are many draws, whose arguments no pass writes
            Tessellation::IndexedGrid => (Part::IndexedGrid, Part::Grid),
            Tessellation::Adaptive { .. } => (Part::Leaves, Part::Leaves),
            Tessellation::Mesh => (Part::Mesh, Part::Mesh),
        };
        let closing = match (variant.light, notes) {
            (0, _) => Some(Part::Seams),
            (_, Part::Leaves | Part::Mesh) => None,
            _ => Some(Part::Walls),
        };
        let of_both = closing.into_iter().flat_map(|part| [(part, false), (part, true)]);
        // without any crossings that are kept the sums are drawn as the notes would be
        for (part, sums) in [(notes, false), (notes, true), (sums, true)].into_iter().chain(of_both) {
            if !self.pipelines.contains_key(&(part, variant, sums)) {
                let pipeline = self.pipeline(pipelines, part, variant, sums)?;
                self.pipelines.insert((part, variant, sums), pipeline);
            }
        }
        Ok(())
    }

    /// The steps that note the crossings of a light's volume with the rays of a view, and sum those that are not kept.
    pub(crate) fn steps(&self, device: &wgpu::Device, to: &VolumeTarget<'_>) -> Vec<Step> {
        let mut steps = Vec::new();
        let buffer = |label, size, usage| {
            let usage = usage | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let pixels = u64::from(to.size.0) * u64::from(to.size.1);
        let none = wgpu::BufferUsages::empty();
        let fixed = (!self.blends).then(|| buffer("light volume sums", 12 * pixels, none));
        let overflow = buffer("light volume overflow", 16, none);
        steps.extend(fixed.clone().map(Step::Clear));
        steps.extend([Step::Clear(to.kept.clone()), Step::Clear(overflow.clone())]);
        let group = self.group(device, to, fixed.as_ref().unwrap_or(&self.spare[1]), &overflow);
        let calls = self.calls(device, to);
        let draws = |calls: Vec<(Part, Call)>, sums: bool| {
            let draw = |(part, call)| {
                let pipeline = self.pipelines.get(&(part, to.variant, sums))?.clone();
                Some(Draw { pipeline, group: group.clone(), call })
            };
            calls.into_iter().filter_map(draw).collect()
        };
        let pass = |what: &str, target: &wgpu::Texture, draws| {
            let target = DrawTarget::Color(view_of(target), wgpu::Color::TRANSPARENT);
            Step::Draw(DrawPass { label: format!("{}, {what}", to.label), target, draws })
        };
        let unused = unused_target(device, to.size);
        let sums = if self.blends { to.sums } else { &unused };
        if to.mesh.pool() == 0 {
            steps.push(pass("surface", sums, draws(calls, true)));
        } else {
            let (gate, gated) = self.gated(device, to, &calls, &overflow);
            steps.push(pass("surface", &unused, draws(calls, false)));
            steps.push(gate);
            steps.push(pass("surface, sums", sums, draws(gated, true)));
        }
        steps.extend(fixed.map(|fixed| self.settled(device, to, &fixed)));
        steps
    }

    /// The step that says how much of a surface is drawn again, and those draws.
    fn gated(
        &self,
        device: &wgpu::Device,
        to: &VolumeTarget<'_>,
        calls: &[(Part, Call)],
        overflow: &wgpu::Buffer,
    ) -> (Step, Vec<(Part, Call)>) {
        let arguments = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("light volume arguments"),
            size: 40,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
            mapped_at_creation: false,
        });
        let (columns, rows) = to.map.size();
        let cells = 6 * columns.saturating_sub(1) * rows.saturating_sub(1);
        let mut wanted = [[0_u32; 4]; 2];
        let mut gated = Vec::new();
        for ((part, call), (wanted, at)) in calls.iter().zip(wanted.iter_mut().zip([0, 20])) {
            let at = (arguments.clone(), at);
            let (part, call) = match call {
                Call::Indexed { indices, .. } => {
                    *wanted = [0, 1, 1, 0];
                    (*part, Call::Indexed { indices: indices.clone(), arguments: at })
                }
                Call::Tiles { instances, .. } => {
                    *wanted = [cells, *instances, 0, 0];
                    (Part::Grid, Call::Indirect(at.0, at.1))
                }
                Call::Direct { vertices, instances } => {
                    *wanted = [*vertices, *instances, 0, 0];
                    (*part, Call::Indirect(at.0, at.1))
                }
                Call::Indirect(..) => continue,
            };
            gated.push((part, call));
        }
        let uniform = filled_buffer(
            device,
            "light volume draws",
            bytemuck::cast_slice(&wanted),
            wgpu::BufferUsages::UNIFORM,
        );
        let head = to.leaves.map_or(&self.spare[0], |leaves| &leaves.head);
        let group = bind(
            device,
            "light volume",
            &self.gate.0,
            [overflow, head, &arguments, &uniform].map(wgpu::Buffer::as_entire_binding),
        );
        let step = Step::Compute(ComputePass {
            label: format!("{}, gate", to.label),
            pipeline: self.gate.1.clone(),
            groups: vec![group],
            dispatch: Dispatch::Groups([1, 1, 1]),
        });
        (step, gated)
    }

    /// The step that makes numbers of sums in fixed point.
    fn settled(&self, device: &wgpu::Device, to: &VolumeTarget<'_>, fixed: &wgpu::Buffer) -> Step {
        let sums = view_of(to.sums);
        let resources = [fixed.as_entire_binding(), wgpu::BindingResource::TextureView(&sums)];
        Step::Compute(ComputePass {
            label: format!("{}, sums", to.label),
            pipeline: self.settle.1.clone(),
            groups: vec![bind(device, "light volume", &self.settle.0, resources)],
            dispatch: Dispatch::Groups([to.size.0.div_ceil(8), to.size.1.div_ceil(8), 1]),
        })
    }

    /// Which parts of a surface there are, and how many vertices they have.
    fn calls(&self, device: &wgpu::Device, to: &VolumeTarget<'_>) -> Vec<(Part, Call)> {
        let (columns, rows) = to.map.size();
        let (columns, rows) = (columns.saturating_sub(1), rows.saturating_sub(1));
        let faces = to.map.projection().faces().len() as u32;
        let cube = to.map.projection().kind() == ProjectionKind::Cube;
        let mut calls = Vec::new();
        if columns > 0 && rows > 0 {
            match (to.tessellation, to.leaves) {
                (Tessellation::Adaptive { .. }, Some(leaves)) => {
                    let arguments = (leaves.head.clone(), DRAW_AT);
                    calls.push((Part::Leaves, Call::Indexed { indices: leaves.indices.clone(), arguments }));
                }
                (Tessellation::IndexedGrid, _) => {
                    let indices = self.tile_indices(device, to.map.size());
                    let firsts = tile_firsts(to.map.size());
                    let count = 6 * GRID_TILE * GRID_TILE;
                    calls.push((Part::IndexedGrid, Call::Tiles { indices, count, firsts, instances: faces }));
                }
                (Tessellation::Mesh, _) => {
                    let vertices = 3 * to.map.mesh().map_or(0, LightMesh::triangle_count);
                    calls.push((Part::Mesh, Call::Direct { vertices, instances: 1 }));
                }
                _ => {
                    calls.push((Part::Grid, Call::Direct { vertices: 6 * columns * rows, instances: faces }));
                }
            }
            if !cube && to.leaves.is_none() && to.tessellation != Tessellation::Mesh {
                calls.push((Part::Walls, Call::Direct { vertices: 6 * (columns + rows), instances: 1 }));
            }
        }
        if cube {
            calls.push((Part::Seams, Call::Direct { vertices: 72 * columns + 24, instances: 1 }));
        }
        calls
    }

    /// The indices of a tile of an indexed grid, for maps of this width.
    fn tile_indices(&self, device: &wgpu::Device, size: (u32, u32)) -> wgpu::Buffer {
        let bits = row_bits(size);
        let mut tile = self.tile.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, indices)) = tile.as_ref()
            && *made == bits
        {
            return indices.clone();
        }
        let index = |x: u32, y: u32, second: u32| 2 * ((y << bits) + x) + second;
        let mut list = Vec::with_capacity(6 * (GRID_TILE * GRID_TILE) as usize);
        for y in 0..GRID_TILE {
            for x in 0..GRID_TILE {
                list.extend([index(x, y, 0), index(x + 1, y, 0), index(x, y + 1, 0)]);
                list.extend([index(x + 1, y + 1, 1), index(x, y + 1, 0), index(x + 1, y, 0)]);
            }
        }
        let bytes = bytemuck::cast_slice(&list);
        let indices = filled_buffer(device, "light volume indices", bytes, wgpu::BufferUsages::INDEX);
        *tile = Some((bits, indices.clone()));
        indices
    }

    fn group(
        &self,
        device: &wgpu::Device,
        to: &VolumeTarget<'_>,
        sums: &wgpu::Buffer,
        overflow: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let uniform = |label, bytes: &[u8]| filled_buffer(device, label, bytes, wgpu::BufferUsages::UNIFORM);
        let light = uniform("light volume light", bytemuck::bytes_of(to.light));
        let mesh = uniform("light volume frame", bytemuck::bytes_of(&to.mesh));
        let heights = to.map.heights().create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let leaves = match (to.leaves, to.map.mesh()) {
            (Some(leaves), _) => &leaves.leaves,
            (None, Some(mesh)) if to.tessellation == Tessellation::Mesh => &mesh.vertices,
            _ => &self.spare[0],
        };
        let view = wgpu::BindingResource::TextureView;
        let resources = [
            to.view.as_entire_binding(),
            view(to.ray_ends),
            light.as_entire_binding(),
            view(&heights),
            mesh.as_entire_binding(),
            leaves.as_entire_binding(),
            sums.as_entire_binding(),
            view(to.unshadowed),
            view(to.stand_in),
            to.kept.as_entire_binding(),
            overflow.as_entire_binding(),
        ];
        bind(device, "light volume", &self.layout, resources)
    }

    fn pipeline(
        &self,
        pipelines: &Pipelines,
        part: Part,
        variant: VolumeVariant,
        sums: bool,
    ) -> Result<wgpu::RenderPipeline, CreateError> {
        let flag = |value: bool| f64::from(u8::from(value));
        let constants = [
            ("LIGHT", f64::from(variant.light)),
            ("ACHROMATIC", flag(variant.achromatic)),
            ("ISOTROPIC", flag(variant.isotropic)),
            ("FIXED", flag(!self.blends)),
            ("SUMS", flag(sums)),
        ];
        let vertex_constants = [constants[0]];
        let sum = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let target = if self.blends && sums {
            wgpu::ColorTargetState {
                format: BLENDED,
                blend: Some(wgpu::BlendState { color: sum, alpha: sum }),
                write_mask: wgpu::ColorWrites::ALL,
            }
        } else {
            wgpu::ColorTargetState { format: UNUSED, blend: None, write_mask: wgpu::ColorWrites::empty() }
        };
        draw_pipeline(
            pipelines,
            format!("{} {constants:?}", part.file()),
            part.file(),
            &self.layout,
            |module, layout| {
                let options =
                    |constants| wgpu::PipelineCompilationOptions { constants, ..Default::default() };
                pipelines.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(part.file()),
                    layout: Some(layout),
                    vertex: wgpu::VertexState {
                        module,
                        entry_point: Some("vs_main"),
                        compilation_options: options(&vertex_constants),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: None,
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module,
                        entry_point: Some("fs_main"),
                        compilation_options: options(&constants),
                        targets: &[Some(target)],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            },
        )
    }
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// First index of each tile of an indexed grid.
fn tile_firsts(size: (u32, u32)) -> Vec<i32> {
    let tiles = |nodes: u32| (0..nodes - 1).step_by(GRID_TILE as usize);
    let first = |(x, y): (u32, u32)| (2 * ((y << row_bits(size)) + x)) as i32;
    tiles(size.1).flat_map(|y| tiles(size.0).map(move |x| (x, y))).map(first).collect()
}

/// A target of which nothing is written.
fn unused_target(device: &wgpu::Device, size: (u32, u32)) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("light volume, no target"),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: UNUSED,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// Crossings of a view for which there is room, where `wanted` of each pixel are wanted on average.
pub(crate) fn fitting(device: &wgpu::Device, size: (u32, u32), wanted: u32) -> u32 {
    let limits = device.limits();
    let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let pixels = u64::from(size.0) * u64::from(size.1);
    let fit = (most / 8).saturating_sub(pixels + 1);
    (pixels * u64::from(wanted)).min(fit).min(1 << 30) as u32
}

/// Memory of the crossings of a view; units: bytes.
pub(crate) fn kept_bytes(device: &wgpu::Device, size: (u32, u32), wanted: u32) -> u64 {
    let pixels = u64::from(size.0) * u64::from(size.1);
    8 + 8 * (pixels + u64::from(fitting(device, size, wanted)))
}

/// A texture for the sums of a view.
pub(crate) fn sums_texture(device: &wgpu::Device, size: (u32, u32)) -> Result<wgpu::Texture, PrepareError> {
    use wgpu::TextureUsages as Usage;
    prepared(device, "the sums of a light volume", || {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some("light volume sums"),
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: BLENDED,
            usage: Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING | Usage::STORAGE_BINDING,
            view_formats: &[],
        })
    })
}
