//! The shared shadow grid: which voxels a frame traces, and what froxels read (sections 3.1.1 and 3.1.3).

use std::collections::HashSet;

use glam::{UVec3, Vec3};
use scene::Aabb;

use crate::needs::{bits, stand_in};
use crate::store::{Place, Store};
use crate::strongest::bit_of;
use crate::volume::{Setup, Volume};
use crate::{BRICK, Counts, FroxelError, GridReads, Near, SharedGrid, Update, parallel};

/// The grid, kept from frame to frame.
#[derive(Debug)]
pub(crate) struct Grid {
    settings: SharedGrid,
    /// The box of its lattice.
    bounds: Aabb,
    /// Slices from the viewer on that need no grid, and those from there on that read the finer one.
    near_slices: u32,
    fine_slices: u32,
    pub(crate) store: Store,
    /// Whether it has been traced.
    begun: bool,
}

/// What a froxel read for one light.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Read {
    /// How much of the light arrives, in [0, 1].
    pub(crate) visibility: f32,
    /// Reads for which there was no brick.
    pub(crate) missed: u32,
    /// Whether a voxel had no room for the light.
    pub(crate) dropped: bool,
}

impl Grid {
    /// An empty grid over the casters' box.
    pub(crate) fn new(
        froxels: &crate::Froxels,
        settings: &SharedGrid,
        casters: &Aabb,
    ) -> Result<Self, FroxelError> {
        let lattice = settings.lattice(casters)?;
        let mut lattices = vec![lattice];
        if let Near::FineGrid { ratio, .. } = settings.near {
            lattices.push(lattice.finer(ratio));
        }
        Ok(Self {
            settings: *settings,
            bounds: settings.bounds(casters),
            near_slices: froxels.near_volume().1,
            fine_slices: froxels.fine_slices(),
            store: Store::new(lattices, settings.memory)?,
            begun: false,
        })
    }

    /// Whether it is that of the casters' box.
    pub(crate) fn covers(&self, casters: &Aabb) -> bool {
        self.bounds == self.settings.bounds(casters)
    }

    /// Calls `visit` for every voxel that a froxel of slice `k` reads at `point`, with its weight.
    fn for_each_read(&self, index: u32, k: u32, point: Vec3, mut visit: impl FnMut(Place, f32)) {
        let level = usize::from(k < self.fine_slices);
        let lattice = &self.store.lattices[level];
        let redirect = |voxel: UVec3| match self.settings.update {
            Update::Marked { alternate: true } => lattice.alternate(voxel, index),
            _ => voxel,
        };
        match self.settings.reads {
            GridReads::Nearest => visit((level, redirect(lattice.voxel(point))), 1.0),
            GridReads::Trilinear => {
                let (ends, share) = lattice.around(point);
                for corner in 0..8_usize {
                    let side = [corner & 1, corner >> 1 & 1, corner >> 2];
                    let voxel = UVec3::new(ends[side[0]].x, ends[side[1]].y, ends[side[2]].z);
                    let along = |axis: usize| if side[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
                    let weight = along(0) * along(1) * along(2);
                    if weight > 0.0 {
                        visit((level, redirect(voxel)), weight);
                    }
                }
            }
        }
    }

    /// Calls `visit` for every pair of a voxel and a light that a row of froxels reads.
    fn for_each_in_row(
        &self,
        setup: &Setup<'_>,
        volume: &Volume,
        [y, k]: [u32; 2],
        mut visit: impl FnMut(Place, usize),
    ) {
        for x in 0..volume.dims()[0] {
            let rays = volume.needs_of([x, y, k]).rays;
            if rays == 0 {
                continue;
            }
            let point = setup.point(&volume.layout, [x, y, k], 1);
            for light in bits(rays) {
                let at = stand_in(&self.bounds, point, &setup.frame.lights[light]);
                self.for_each_read(setup.index, k, at, |place, _| visit(place, light));
            }
        }
    }

    /// Rows of froxels that read the grid, over all views: view, row, slice.
    fn rows(&self, volumes: &[Volume]) -> Vec<(usize, [u32; 2])> {
        let mut all = Vec::new();
        for (view, volume) in volumes.iter().enumerate() {
            let [_, rows, slices] = volume.dims();
            for k in self.near_slices..slices {
                all.extend((0..rows).map(|y| (view, [y, k])));
            }
        }
        all
    }

    /// Traces what this frame's froxels read, or all that is in sight.
    pub(crate) fn update(&mut self, setup: &Setup<'_>, volumes: &[Volume]) -> Counts {
        // voxels out of sight, or not in turn, keep what they have
        let keeps = matches!(self.settings.update, Update::InFrustums { .. }) && self.begun;
        self.store.begin(!keeps);
        self.begun = true;
        match self.settings.update {
            Update::Marked { .. } => self.mark_read(setup, volumes),
            Update::InFrustums { alternate } => self.mark_seen(setup, volumes, alternate && keeps),
        }
        let mut counts = self.trace(setup);
        counts.bricks = self.store.bricks() as u64;
        counts
    }

    /// Marks the bits that froxels will read.
    fn mark_read(&mut self, setup: &Setup<'_>, volumes: &[Volume]) {
        let rows = self.rows(volumes);
        if self.store.is_sparse() {
            // what each row wants first, so that room is given in the same order on any number of threads
            let mut wanted: Vec<Vec<Place>> = vec![Vec::new(); rows.len()];
            parallel::rows(&mut wanted, 1, |i, wanted| {
                let mut seen = HashSet::new();
                let (view, row) = rows[i];
                self.for_each_in_row(setup, &volumes[view], row, |(level, voxel), light| {
                    let brick = (level, voxel / BRICK);
                    if !seen.contains(&brick) && self.bit(setup, (level, voxel), light).is_some() {
                        seen.insert(brick);
                        wanted[0].push(brick);
                    }
                });
                Counts::default()
            });
            self.store.allocate(wanted.into_iter().flatten());
        }
        parallel::each(rows.len(), |i| {
            let (view, row) = rows[i];
            self.for_each_in_row(setup, &volumes[view], row, |place, light| {
                if let Some(bit) = self.bit(setup, place, light) {
                    self.store.mark(place, bit);
                }
            });
        });
    }

    /// Marks all bits of voxels in sight, of every other layer if they take turns.
    fn mark_seen(&self, setup: &Setup<'_>, volumes: &[Volume], turns: bool) {
        let lattice = self.store.lattices[0];
        let range = setup.froxels.range;
        let count = setup.frame.lights.len().min(self.settings.lights.bits() as usize);
        let all = (1_u64 << count).wrapping_sub(1) as u32;
        parallel::each(lattice.dims.z as usize, |z| {
            let z = z as u32;
            if turns && z & 1 != setup.index & 1 {
                return;
            }
            for y in 0..lattice.dims.y {
                for x in 0..lattice.dims.x {
                    let voxel = UVec3::new(x, y, z);
                    let center = lattice.center(voxel);
                    if volumes.iter().any(|volume| volume.layout.sees(center, range)) {
                        self.store.mark((0, voxel), all);
                    }
                }
            }
        });
    }

    /// One shadow ray for each marked bit.
    fn trace(&mut self, setup: &Setup<'_>) -> Counts {
        const CHUNK: usize = 512;
        let mut masks = std::mem::take(&mut self.store.masks);
        let counts = parallel::rows(&mut masks, CHUNK, |chunk, masks| {
            let mut counts = Counts::default();
            for (i, mask) in masks.iter_mut().enumerate() {
                let index = chunk * CHUNK + i;
                let marked = self.store.marked(index);
                if marked == 0 {
                    continue;
                }
                let center = self.center(self.store.place(index));
                counts.voxels += 1;
                *mask = 0;
                for (bit, light) in bits(setup.strongest.chosen(center)).enumerate() {
                    if marked >> bit & 1 == 1 {
                        counts.grid_rays += 1;
                        *mask |= u32::from(setup.traces(center, light)) << bit;
                    }
                }
            }
            counts
        });
        self.store.masks = masks;
        counts
    }

    /// The bit of a light in a voxel's mask; `None` where it has no room.
    fn bit(&self, setup: &Setup<'_>, place: Place, light: usize) -> Option<u32> {
        bit_of(setup.strongest.chosen(self.center(place)), light)
    }

    fn center(&self, (level, voxel): Place) -> Vec3 {
        self.store.lattices[level].center(voxel)
    }

    /// How much of a light arrives at a froxel of slice `k` that samples at `point`.
    pub(crate) fn read(&self, setup: &Setup<'_>, k: u32, point: Vec3, light: usize) -> Read {
        let at = stand_in(&self.bounds, point, &setup.frame.lights[light]);
        let mut read = Read::default();
        self.for_each_read(setup.index, k, at, |place, weight| {
            let Some(bit) = self.bit(setup, place, light) else {
                read.dropped = true;
                return;
            };
            let Some(index) = self.store.index(place) else {
                read.missed += 1;
                read.visibility += weight;
                return;
            };
            debug_assert!(
                matches!(self.settings.update, Update::InFrustums { .. })
                    || self.store.marked(index) & bit != 0,
                "a read of what was not marked"
            );
            if self.store.masks[index] & bit != 0 {
                read.visibility += weight;
            }
        });
        read
    }
}
