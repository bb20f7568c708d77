//! The pipelines of the froxel passes, specialised by constants, and what they bind.

use std::collections::HashMap;

use crate::CreateError;
use crate::checked::created;
use crate::pass::{compute_pipeline, storage, storage_texture, storage_written, texture, uniform};
use crate::pipelines::Pipelines;

/// A pass with what it is specialised by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Pass {
    TileEnds,
    Reach,
    Near(Masks),
    Mark(Masks, Voxels),
    Grid {
        masks: Masks,
        bricks: bool,
        marked: bool,
    },
    Lighting {
        masks: Masks,
        voxels: Voxels,
        grid: bool,
        textured: bool,
        medium: MediumKind,
        memory: Memory,
        achromatic: bool,
    },
    Accumulate {
        achromatic: bool,
    },
    Apply,
}

/// How wide masks are, whether there are more lights than that, and how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Masks {
    pub(super) bits: u32,
    pub(super) selects: bool,
    pub(super) lights: u32,
}

/// Where voxels are, and which of them are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Voxels {
    pub(super) bricks: bool,
    pub(super) alternates: bool,
    pub(super) trilinear: bool,
}

/// What lighting has to do with other frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Memory {
    None,
    /// Froxels are kept for the frame after.
    Written,
    /// And those of the frame before are there.
    Read,
}

/// What of a medium there is code for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct MediumKind {
    pub(super) bounded: bool,
    /// 0 none, 1 height, 2 grid.
    pub(super) density: u8,
    pub(super) isotropic: bool,
    pub(super) hoffman_preetham: bool,
}

impl Pass {
    fn file(self) -> &'static str {
        match self {
            Self::TileEnds => "froxel/tile_ends",
            Self::Reach => "froxel/reach",
            Self::Near(_) => "froxel/near",
            Self::Mark(..) => "froxel/mark",
            Self::Grid { .. } => "froxel/grid",
            Self::Lighting { .. } => "froxel/lighting",
            Self::Accumulate { .. } => "froxel/accumulate",
            Self::Apply => "froxel/apply",
        }
    }

    fn constants(self) -> Vec<(&'static str, f64)> {
        let flag = |value: bool| f64::from(u8::from(value));
        let of_masks = |masks: Masks| {
            [
                ("LIGHT_BITS", f64::from(masks.bits)),
                ("SELECTS", flag(masks.selects)),
                ("LIGHTS", f64::from(masks.lights)),
            ]
            .into_iter()
        };
        let of_voxels = |voxels: Voxels| {
            [
                ("BRICKS", flag(voxels.bricks)),
                ("ALTERNATES", flag(voxels.alternates)),
                ("TRILINEAR", flag(voxels.trilinear)),
            ]
        };
        match self {
            Self::TileEnds | Self::Reach | Self::Apply => Vec::new(),
            Self::Accumulate { achromatic } => vec![("ACHROMATIC", flag(achromatic))],
            Self::Near(masks) => of_masks(masks).collect(),
            Self::Mark(masks, voxels) => of_masks(masks).chain(of_voxels(voxels)).collect(),
            Self::Grid { masks, bricks, marked } => {
                of_masks(masks).chain([("BRICKS", flag(bricks)), ("MARKED", flag(marked))]).collect()
            }
            Self::Lighting { masks, voxels, grid, textured, medium, memory, achromatic } => of_masks(masks)
                .chain(of_voxels(voxels))
                .chain([
                    ("GRID", flag(grid)),
                    ("TEXTURED", flag(textured)),
                    ("ACHROMATIC", flag(achromatic)),
                    ("TEMPORAL", flag(memory != Memory::None)),
                    ("HISTORY", flag(memory == Memory::Read)),
                    ("BOUNDED", flag(medium.bounded)),
                    ("DENSITY", f64::from(medium.density)),
                    ("ISOTROPIC", flag(medium.isotropic)),
                    ("HOFFMAN_PREETHAM", flag(medium.hoffman_preetham)),
                ])
                .collect(),
        }
    }
}

/// Layouts of the groups that froxel passes bind.
#[derive(Debug)]
pub(super) struct FroxelLayouts {
    /// Group 0: the frame.
    pub(super) frame: wgpu::BindGroupLayout,
    /// Group 1: voxels; bound to passes that read none as well, so that group 2 has the same place in all.
    pub(super) grid: wgpu::BindGroupLayout,
    /// Group 2 of the passes over one view.
    pub(super) tile_ends: wgpu::BindGroupLayout,
    pub(super) lighting: wgpu::BindGroupLayout,
    pub(super) accumulate: wgpu::BindGroupLayout,
    pub(super) apply: wgpu::BindGroupLayout,
    /// Group 2 of the passes that trace: the hierarchy.
    pub(super) bvh: wgpu::BindGroupLayout,
}

/// The pipelines that frames have needed so far.
#[derive(Debug)]
pub(super) struct Passes {
    pub(super) layouts: FroxelLayouts,
    pipelines: HashMap<Pass, wgpu::ComputePipeline>,
}

impl Passes {
    pub(super) fn new(device: &wgpu::Device) -> Result<Self, CreateError> {
        let (flat, volume) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D3);
        let float = wgpu::TextureFormat::Rgba32Float;
        let group = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let layouts = created(device, "froxels", || FroxelLayouts {
            frame: group(
                "froxel frame",
                &[uniform(0), uniform(1), storage_written(2), storage_written(3), storage_written(4)],
            ),
            grid: group("froxel grid", &[storage_written(0), storage_written(1), storage_written(2)]),
            tile_ends: group("froxel tile ends", &[uniform(0), texture(1, flat)]),
            lighting: group(
                "froxel lighting",
                &[
                    uniform(0),
                    uniform(1),
                    texture(2, volume),
                    texture(3, volume),
                    storage_texture(4, float, volume),
                    storage(5),
                ],
            ),
            accumulate: group(
                "froxel march",
                &[uniform(0), texture(1, volume), storage_texture(2, float, volume)],
            ),
            apply: group(
                "froxel apply",
                &[uniform(0), texture(1, flat), texture(2, volume), storage_texture(3, float, flat)],
            ),
            bvh: group("froxel bvh", &[storage(0), storage(1)]),
        })?;
        Ok(Self { layouts, pipelines: HashMap::new() })
    }

    /// The pipeline of a pass, made where no frame has needed it before.
    pub(super) fn of(
        &mut self,
        pipelines: &Pipelines,
        pass: Pass,
    ) -> Result<wgpu::ComputePipeline, CreateError> {
        if let Some(pipeline) = self.pipelines.get(&pass) {
            return Ok(pipeline.clone());
        }
        let FroxelLayouts { frame, grid, tile_ends, lighting, accumulate, apply, bvh } = &self.layouts;
        let layouts = match pass {
            Pass::Reach => vec![frame],
            Pass::TileEnds => vec![frame, grid, tile_ends],
            Pass::Near(_) => vec![frame, grid, bvh],
            Pass::Mark(..) => vec![frame, grid],
            Pass::Grid { .. } => vec![frame, grid, bvh],
            Pass::Lighting { .. } => vec![frame, grid, lighting],
            Pass::Accumulate { .. } => vec![frame, grid, accumulate],
            Pass::Apply => vec![frame, grid, apply],
        };
        let pipeline = compute_pipeline(pipelines, pass.file(), &layouts, &pass.constants())?;
        self.pipelines.insert(pass, pipeline.clone());
        Ok(pipeline)
    }
}
