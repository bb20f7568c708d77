//! Froxels with ray-traced shadows, and the shadow grid that views share (Stojanovic et al. 2023), on the GPU.
//!
//! Twins of `shaders/froxel/`; the same on the CPU, and the settings of both, are in `froxel-grid`.

mod frame;
mod layout;
mod memory;
mod passes;
mod record;

use std::sync::Arc;

use froxel_grid::Counts;
use scene::{Aabb, AirlightModel, Light, LightTexture, Medium};

pub(crate) use frame::{FroxelContext, FroxelTarget};
use memory::{GridBuffers, ViewVolumes, buffer};
use passes::Passes;

use crate::checked::{created, read_words};
use crate::{CreateError, ReadError};

/// Words of the buffer of counts.
const COUNTS: u64 = 8;

/// What froxels keep from frame to frame.
#[derive(Debug)]
pub(crate) struct FroxelState {
    passes: Passes,
    /// Farthest rays' ends by tile.
    reaches: Option<wgpu::Buffer>,
    /// Masks of the views' own volumes.
    near: Option<wgpu::Buffer>,
    grid: Option<GridBuffers>,
    views: Vec<ViewVolumes>,
    counts: wgpu::Buffer,
    pictures: Option<(Vec<Arc<LightTexture>>, wgpu::Buffer)>,
    /// Frames since all was forgotten.
    frames: u32,
    /// Whether the grid holds anything.
    grid_begun: bool,
    known: Option<Known>,
    /// Stands in for buffers that a frame lacks.
    nothing: wgpu::Buffer,
}

/// What makes a history wrong where it changes.
#[derive(Debug, Clone, PartialEq)]
struct Known {
    lights: Vec<Light>,
    medium: Medium,
    model: AirlightModel,
    casters: Option<Aabb>,
    hierarchy: Option<wgpu::Buffer>,
    views: usize,
}

impl FroxelState {
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, CreateError> {
        let passes = Passes::new(device)?;
        let (counts, nothing) = created(device, "froxels", || {
            (buffer(device, "froxel counts", 4 * COUNTS), buffer(device, "nothing", 16))
        })?;
        Ok(Self {
            passes,
            reaches: None,
            near: None,
            grid: None,
            views: Vec::new(),
            counts,
            pictures: None,
            frames: 0,
            grid_begun: false,
            known: None,
            nothing,
        })
    }

    /// Forgets the history and what the grid holds.
    pub(crate) fn forget(&mut self) {
        (self.frames, self.grid_begun, self.known) = (0, false, None);
        for view in &mut self.views {
            view.frames = 0;
        }
    }

    /// Counts of the last frame that was submitted; submits a copy and waits for it.
    pub(crate) fn read_counts(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Counts, ReadError> {
        let words = read_words(device, queue, &self.counts, "the counts of a frame of froxels")?;
        let [near_rays, grid_rays, froxels, voxels, bricks, missed, dropped, not_finite] =
            std::array::from_fn(|index| words.get(index).map_or(0, |&word| u64::from(word)));
        // the blocks of dense voxels with marks are counted in the same place
        let bricks = if self.grid.as_ref().is_some_and(|grid| grid.bricks > 0) { bricks } else { 0 };
        Ok(Counts { near_rays, grid_rays, froxels, voxels, bricks, missed, dropped, not_finite })
    }

    /// Masks of the views' own volumes, view after view, in the words that the shaders pack them in.
    pub(crate) fn read_near_masks(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<u32>, ReadError> {
        let near = self.near.as_ref().ok_or(ReadError::Nothing("volume of a view's own shadows"))?;
        read_words(device, queue, near, "the masks of a view's froxels")
    }

    /// Masks of the shared grid, and the key of the brick in each place where there are bricks.
    pub(crate) fn read_grid(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<(Vec<u32>, Vec<u32>), ReadError> {
        let grid = self.grid.as_ref().ok_or(ReadError::Nothing("shadow grid"))?;
        let what = "the shadow grid";
        let mut masks = read_words(device, queue, &grid.masks[0], what)?;
        if grid.masks[1].size() > 16 {
            masks.extend(read_words(device, queue, &grid.masks[1], what)?);
        }
        Ok((masks, read_words(device, queue, &grid.keys, what)?))
    }

    /// Memory; units: bytes.
    fn bytes(&self) -> u64 {
        let buffers = [&self.reaches, &self.near].into_iter().flatten().map(wgpu::Buffer::size).sum::<u64>();
        let pictures = self.pictures.as_ref().map_or(0, |(_, buffer)| buffer.size());
        buffers
            + pictures
            + self.grid.as_ref().map_or(0, GridBuffers::bytes)
            + self.views.iter().map(ViewVolumes::bytes).sum::<u64>()
    }
}
