//! Memory of the grid: masks all over the lattice, or in bricks.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::UVec3;

use crate::near::Mask;
use crate::{BRICK, FroxelError, GridMemory, Lattice};

/// Voxels of a brick.
const BRICK_VOXELS: usize = (BRICK * BRICK * BRICK) as usize;

/// Most voxels of a dense grid: 8 GiB here, where one takes two words.
const MOST_DENSE: u64 = 1 << 30;

/// A voxel of one of the grid's lattices: 0 the grid itself, 1 the finer one.
pub(crate) type Place = (usize, UVec3);

/// Masks by voxel, and the bits that were marked for tracing.
#[derive(Debug)]
pub(crate) struct Store {
    pub(crate) lattices: Vec<Lattice>,
    bricks: Option<Bricks>,
    marks: Vec<AtomicU32>,
    pub(crate) masks: Vec<u32>,
}

/// Which bricks have room, in the order of their slots.
#[derive(Debug)]
struct Bricks {
    most: usize,
    slots: HashMap<Place, usize>,
    places: Vec<Place>,
}

impl Store {
    pub(crate) fn new(lattices: Vec<Lattice>, memory: GridMemory) -> Result<Self, FroxelError> {
        let (bricks, count) = match memory {
            GridMemory::Dense => {
                let needed = lattices[0].count();
                if needed > MOST_DENSE {
                    let voxel_size = lattices[0].voxel_size;
                    return Err(FroxelError::TooManyVoxels {
                        voxel_size,
                        needed,
                        most: MOST_DENSE,
                        unit: "voxels",
                    });
                }
                (None, needed as usize)
            }
            GridMemory::Bricks { most } => {
                lattices.iter().try_for_each(Lattice::check_bricks)?;
                let bricks = Bricks { most: most as usize, slots: HashMap::new(), places: Vec::new() };
                (Some(bricks), 0)
            }
        };
        let marks = (0..count).map(|_| AtomicU32::new(0)).collect();
        Ok(Self { lattices, bricks, marks, masks: vec![0; count] })
    }

    /// Gives each brick of `wanted` that is not yet there room, as long as there is any.
    pub(crate) fn allocate(&mut self, wanted: impl Iterator<Item = Place>) {
        let Some(bricks) = &mut self.bricks else { return };
        for place in wanted {
            if bricks.places.len() < bricks.most && !bricks.slots.contains_key(&place) {
                bricks.slots.insert(place, bricks.places.len());
                bricks.places.push(place);
            }
        }
        let count = bricks.places.len() * BRICK_VOXELS;
        self.marks.resize_with(count, || AtomicU32::new(0));
        self.masks.resize(count, 0);
    }

    /// Forgets marks and bricks, and the masks too if `all`.
    pub(crate) fn begin(&mut self, all: bool) {
        if let Some(bricks) = &mut self.bricks {
            bricks.slots.clear();
            bricks.places.clear();
            self.marks.clear();
            self.masks.clear();
        }
        self.marks.iter_mut().for_each(|mark| *mark.get_mut() = 0);
        if all {
            self.masks.fill(0);
        }
    }

    /// Bricks in use.
    pub(crate) fn bricks(&self) -> usize {
        self.bricks.as_ref().map_or(0, |bricks| bricks.places.len())
    }

    /// Whether room is given to bricks.
    pub(crate) fn is_sparse(&self) -> bool {
        self.bricks.is_some()
    }

    /// Where a voxel is kept; `None` where its brick has no room.
    pub(crate) fn index(&self, (level, voxel): Place) -> Option<usize> {
        let flat = |v: UVec3, dims: UVec3| {
            let [x, y, z, nx, ny] = [v.x, v.y, v.z, dims.x, dims.y].map(|n| n as usize);
            x + nx * (y + ny * z)
        };
        match &self.bricks {
            None => Some(flat(voxel, self.lattices[level].dims)),
            Some(bricks) => {
                let slot = bricks.slots.get(&(level, voxel / BRICK))?;
                Some(slot * BRICK_VOXELS + flat(voxel % BRICK, UVec3::splat(BRICK)))
            }
        }
    }

    /// The voxel that is kept at an index.
    pub(crate) fn place(&self, index: usize) -> Place {
        let unflat = |index: usize, dims: UVec3| {
            let (nx, ny) = (dims.x as usize, dims.y as usize);
            UVec3::new((index % nx) as u32, (index / nx % ny) as u32, (index / nx / ny) as u32)
        };
        match &self.bricks {
            None => (0, unflat(index, self.lattices[0].dims)),
            Some(bricks) => {
                let (level, brick) = bricks.places[index / BRICK_VOXELS];
                (level, brick * BRICK + unflat(index % BRICK_VOXELS, UVec3::splat(BRICK)))
            }
        }
    }

    /// Marks bits of a voxel, if there is room for it.
    pub(crate) fn mark(&self, place: Place, bits: u32) {
        if let Some(index) = self.index(place) {
            self.marks[index].fetch_or(bits, Ordering::Relaxed);
        }
    }

    /// The marked bits at an index.
    pub(crate) fn marked(&self, index: usize) -> u32 {
        self.marks[index].load(Ordering::Relaxed)
    }

    /// The mask of a voxel, and what of it the last frame found; `None` where there is no memory.
    pub(crate) fn mask(&self, place: Place) -> Option<Mask> {
        let index = self.index(place)?;
        Some(Mask { lit: self.masks[index], known: self.marked(index) })
    }
}
