//! Frames of froxel fog, one after the other, on the CPU or a GPU.

use std::time::Instant;

use froxel_grid::{
    Counts, Frame, FroxelFog, FroxelView, Froxels, GridMemory, Lit, Occluders, View, dense_bytes, near_bytes,
};
use glam::Vec3;
use gpu_backend::{GpuBvh, GpuContext, PassTime};
use scene::{AirlightModel, Bvh, BvhVisibility, Camera, Light, Medium};

use super::gpu::GpuFroxels;
use super::wrong;
use crate::failure::{Failure, Outcome};

/// What lights and shadows the fog.
#[derive(Clone, Copy)]
pub(crate) struct World<'a> {
    pub(crate) medium: &'a Medium,
    pub(crate) lights: &'a [Light],
    pub(crate) model: AirlightModel,
    /// What casts shadows; `None` where nothing does.
    pub(crate) casters: Option<Casters<'a>>,
}

/// What casts shadows.
#[derive(Clone, Copy)]
pub(crate) struct Casters<'a> {
    pub(crate) bvh: &'a Bvh,
    /// The same for a GPU, where there is one.
    pub(crate) on_gpu: Option<&'a GpuBvh>,
}

/// A view of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Eye<'a> {
    pub(crate) camera: &'a Camera,
    /// Where its rays end, by pixel; units: m.
    pub(crate) ends: &'a [f32],
}

/// What a frame took.
pub(crate) struct FrameTime {
    /// All of it: the GPU's own clock where it is one of hardware, else the wall clock; units: ms.
    pub(crate) ms: f64,
    /// Each pass on a GPU.
    pub(crate) passes: Vec<PassTime>,
}

/// Froxel fog with what it keeps from frame to frame.
pub(crate) enum Engine<'g> {
    /// The implementation of the CPU.
    Cpu(Box<CpuFroxels>),
    /// The one of a GPU.
    Gpu(Box<GpuFroxels<'g>>),
}

/// Froxel fog of the CPU with its last frame.
pub(crate) struct CpuFroxels {
    fog: FroxelFog,
    froxels: Froxels,
    pictures: Vec<Vec<Vec3>>,
    counts: Counts,
    bytes: u64,
}

impl<'g> Engine<'g> {
    /// Fails for settings that make no sense, and where the GPU cannot hold the pipelines.
    pub(crate) fn new(gpu: Option<&'g GpuContext>, froxels: Froxels) -> Outcome<Self> {
        Ok(match gpu {
            Some(gpu) => Self::Gpu(Box::new(GpuFroxels::new(gpu, froxels)?)),
            None => Self::Cpu(Box::new(CpuFroxels::new(froxels)?)),
        })
    }

    /// Renders the next frame, of all viewers at once; pictures are of `size` (width, height).
    pub(crate) fn frame(
        &mut self,
        world: &World<'_>,
        eyes: &[Eye<'_>],
        size: (u32, u32),
    ) -> Outcome<FrameTime> {
        match self {
            Self::Cpu(cpu) => cpu.frame(world, eyes, size),
            Self::Gpu(gpu) => gpu.frame(world, eyes, size),
        }
    }

    /// Forgets grid and history.
    pub(crate) fn forget(&mut self) {
        match self {
            Self::Cpu(cpu) => cpu.fog.forget(),
            Self::Gpu(gpu) => gpu.forget(),
        }
    }

    /// What the last frame counted.
    pub(crate) fn counts(&self) -> Outcome<Counts> {
        match self {
            Self::Cpu(cpu) => Ok(cpu.counts),
            Self::Gpu(gpu) => gpu.counts(),
        }
    }

    /// Airlight of a viewer in the last frame, row by row.
    pub(crate) fn picture(&self, viewer: usize) -> Outcome<Vec<Vec3>> {
        match self {
            Self::Cpu(cpu) => {
                cpu.pictures.get(viewer).cloned().ok_or_else(|| Failure::program("no such viewer"))
            }
            Self::Gpu(gpu) => gpu.picture(viewer),
        }
    }

    /// Memory of the last frame; units: bytes.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Cpu(cpu) => cpu.bytes,
            Self::Gpu(gpu) => gpu.bytes(),
        }
    }
}

impl CpuFroxels {
    fn new(froxels: Froxels) -> Outcome<Self> {
        let fog = FroxelFog::new(froxels).map_err(|error| wrong(&error))?;
        Ok(Self { fog, froxels, pictures: Vec::new(), counts: Counts::default(), bytes: 0 })
    }

    fn frame(&mut self, world: &World<'_>, eyes: &[Eye<'_>], size: (u32, u32)) -> Outcome<FrameTime> {
        let views: Vec<View<'_>> =
            eyes.iter().map(|eye| View { camera: eye.camera, size, ends: eye.ends }).collect();
        let visibility = world.casters.map(|casters| BvhVisibility::new(casters.bvh, world.lights));
        let occluders = visibility
            .as_ref()
            .zip(world.casters)
            .map(|(visibility, casters)| Occluders { visibility, bounds: casters.bvh.bounds() });
        let World { medium, lights, model, .. } = *world;
        let frame = Frame { views: &views, medium, lights, model, occluders };
        let started = Instant::now();
        let rendered = self.fog.render(&frame).map_err(|error| wrong(&error))?;
        let ms = started.elapsed().as_secs_f64() * 1e3;
        (self.pictures, self.counts) = (rendered.airlight, rendered.counts);
        self.bytes = views
            .iter()
            .map(|view| froxel_bytes(&self.froxels, view) + near_bytes(&self.froxels, size))
            .sum::<u64>()
            + self.grid_bytes();
        Ok(FrameTime { ms, passes: Vec::new() })
    }

    /// Masks of the grid, packed as on a GPU.
    fn grid_bytes(&self) -> u64 {
        let Some(grid) = self.froxels.grid() else { return 0 };
        match grid.memory {
            GridMemory::Dense => {
                self.fog.lattices().iter().map(|lattice| dense_bytes(lattice, grid.lights)).sum()
            }
            GridMemory::Bricks { .. } => brick_bytes(self.counts.bricks, grid.lights.bits()),
        }
    }
}

/// Memory of the froxels of a view: what each sends and holds, and what is accumulated up to its end. Units: bytes.
fn froxel_bytes(froxels: &Froxels, view: &View<'_>) -> u64 {
    let (columns, rows) = FroxelView::new(view.camera, view.size, froxels.tile).tiles();
    let count = u64::from(columns) * u64::from(rows) * u64::from(froxels.slices);
    count * (size_of::<Lit>() + size_of::<Vec3>()) as u64
}

/// Memory of the masks in so many bricks, of `bits` a voxel; units: bytes.
pub(crate) fn brick_bytes(bricks: u64, bits: u32) -> u64 {
    bricks * u64::from(froxel_grid::BRICK.pow(3) * bits / 8)
}
