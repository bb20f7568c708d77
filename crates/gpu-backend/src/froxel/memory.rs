//! Buffers and textures of froxels, kept from frame to frame while they fit.

use froxel_grid::{BRICK, FroxelView, GridMemory, Lattice, MaskWidth, SharedGrid, Update};

use super::layout::ViewUniform;
use crate::PrepareError;
use crate::checked::{check_size, prepared};

/// Bytes of the first of the two buffers that masks of voxels are in: the least that every device can bind.
const FIRST_BYTES: u64 = 128 << 20;

/// Where the shared grid is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GridBuffers {
    pub(super) masks: [wgpu::Buffer; 2],
    /// Which blocks hold marks, and a list of them.
    pub(super) keys: wgpu::Buffer,
    pub(super) lattice: Lattice,
    /// Blocks of voxels: those of the lattice, or the places for bricks.
    pub(super) blocks: u32,
    /// Places for bricks; 0 where voxels are dense.
    pub(super) bricks: u32,
    bits: u32,
    marked: bool,
}

/// A buffer of zeros.
pub(super) fn buffer(device: &wgpu::Device, label: &str, bytes: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.max(16).next_multiple_of(4),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

impl GridBuffers {
    /// Buffers for a grid over a lattice.
    pub(super) fn new(
        device: &wgpu::Device,
        grid: &SharedGrid,
        lattice: Lattice,
        width: MaskWidth,
    ) -> Result<Self, PrepareError> {
        let bits = width.bits();
        let marked = matches!(grid.update, Update::Marked { .. });
        let (bytes, blocks, bricks) = match grid.memory {
            GridMemory::Dense => {
                let [x, y, z] = lattice.bricks().to_array().map(u64::from);
                let blocks = u32::try_from(x * y * z).unwrap_or(u32::MAX);
                (froxel_grid::dense_bytes(&lattice, width), blocks, 0)
            }
            GridMemory::Bricks { most } => {
                lattice.check_bricks()?;
                let places = most.max(64).next_power_of_two();
                let brick = u64::from(BRICK.pow(3)) * u64::from(bits) / 8;
                (u64::from(places) * brick, places, places)
            }
        };
        let rest = bytes.saturating_sub(FIRST_BYTES);
        let what = "the shared shadow grid";
        check_size(device, what, bytes.min(FIRST_BYTES))?;
        if check_size(device, what, rest).is_err() {
            return Err(PrepareError::TooLarge {
                what,
                needed: bytes,
                limit: 2 * FIRST_BYTES,
                unit: "bytes",
            });
        }
        let [masks0, masks1, keys] = prepared(device, what, || {
            let of = |bytes| buffer(device, "shadow grid", bytes);
            [of(bytes.min(FIRST_BYTES)), of(rest), of(if marked { 8 * u64::from(blocks) } else { 0 })]
        })?;
        Ok(Self { masks: [masks0, masks1], keys, lattice, blocks, bricks, bits, marked })
    }

    /// Whether these are the buffers that a grid needs.
    pub(super) fn fits(&self, grid: &SharedGrid, lattice: &Lattice, width: MaskWidth) -> bool {
        let bricks = match grid.memory {
            GridMemory::Dense => 0,
            GridMemory::Bricks { most } => most.max(64).next_power_of_two(),
        };
        let marked = matches!(grid.update, Update::Marked { .. });
        (self.lattice, self.bits, self.bricks, self.marked) == (*lattice, width.bits(), bricks, marked)
    }

    /// Memory; units: bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.masks.iter().chain([&self.keys]).map(wgpu::Buffer::size).sum()
    }
}

/// What one view keeps.
#[derive(Debug)]
pub(super) struct ViewVolumes {
    pub(super) tiles: (u32, u32),
    pub(super) slices: u32,
    /// Lit froxels of this frame and the one before; without a history the first alone is used.
    pub(super) lit: [Option<wgpu::Texture>; 2],
    pub(super) accumulated: wgpu::Texture,
    /// Which of the two the last frame wrote.
    pub(super) current: usize,
    /// Where the view was then.
    pub(super) before: ViewUniform,
    /// Frames in the history.
    pub(super) frames: u32,
}

impl ViewVolumes {
    pub(super) fn new(device: &wgpu::Device, view: &FroxelView, slices: u32) -> Result<Self, PrepareError> {
        let tiles = view.tiles();
        let limit = device.limits().max_texture_dimension_3d;
        let largest = tiles.0.max(tiles.1).max(slices);
        if largest > limit {
            return Err(PrepareError::TooLarge {
                what: "the side of a froxel volume",
                needed: largest.into(),
                limit: limit.into(),
                unit: "froxels",
            });
        }
        let [lit, accumulated] = prepared(device, "the froxels of a view", || {
            [
                volume(device, "lit froxels", tiles, slices),
                volume(device, "accumulated froxels", tiles, slices),
            ]
        })?;
        let before = bytemuck::Zeroable::zeroed();
        Ok(Self { tiles, slices, lit: [Some(lit), None], accumulated, current: 0, before, frames: 0 })
    }

    /// Makes the second volume, for frames that look back.
    pub(super) fn reserve_history(&mut self, device: &wgpu::Device) -> Result<(), PrepareError> {
        if self.lit.iter().any(Option::is_none) {
            let (tiles, slices) = (self.tiles, self.slices);
            let made = prepared(device, "the history of a view's froxels", || {
                volume(device, "lit froxels", tiles, slices)
            })?;
            if let Some(slot) = self.lit.iter_mut().find(|slot| slot.is_none()) {
                *slot = Some(made);
            }
        }
        Ok(())
    }

    /// Memory; units: bytes.
    pub(super) fn bytes(&self) -> u64 {
        let froxels = u64::from(self.tiles.0) * u64::from(self.tiles.1) * u64::from(self.slices);
        16 * froxels * (1 + self.lit.iter().flatten().count() as u64)
    }
}

fn volume(device: &wgpu::Device, label: &str, tiles: (u32, u32), slices: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: tiles.0, height: tiles.1, depth_or_array_layers: slices },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
