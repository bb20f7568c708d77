//! Shadows that are traced for one view alone: its shadow frustum (section 3.1.2), or every froxel of the reference.

use crate::needs::bits;
use crate::strongest::{bit_of, compact};
use crate::volume::{Setup, Volume};
use crate::{Counts, parallel};

/// A mask and what of it was traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Mask {
    /// Bit *i* is set where the *i*-th light that the mask has room for arrives.
    pub lit: u32,
    /// Bits that the frame found; of the others `lit` says nothing.
    pub known: u32,
}

/// The masks of a view's cells; column fastest, then row, then slice.
#[derive(Debug, Default)]
pub(crate) struct NearMasks {
    /// Froxels along the side of a cell.
    side: u32,
    columns: u32,
    rows: u32,
    pub(crate) masks: Vec<Mask>,
}

impl NearMasks {
    pub(crate) fn trace(setup: &Setup<'_>, volume: &Volume) -> (Self, Counts) {
        let (side, slices) = setup.froxels.near_volume();
        let (columns, rows) = volume.layout.cells(side);
        let mut masks = vec![Mask::default(); columns as usize * rows as usize * slices as usize];
        let counts = parallel::rows(&mut masks, columns as usize, |index, row| {
            let (k, y) = (index as u32 / rows, index as u32 % rows);
            let mut counts = Counts::default();
            for (x, mask) in (0..columns).zip(row) {
                let needed = needs_of_cell(volume, [x, y, k], side);
                if needed == 0 {
                    continue;
                }
                let point = setup.point(&volume.layout, [x, y, k], side);
                let chosen = setup.strongest.chosen(point);
                mask.known = compact(chosen, needed);
                for light in bits(needed & chosen) {
                    let ray = setup.scout.may_be_shadowed(point, light);
                    counts.near_rays += u64::from(ray);
                    if !ray || setup.traces(point, light) {
                        mask.lit |= bit_of(chosen, light).unwrap_or(0);
                    }
                }
            }
            counts
        });
        (Self { side, columns, rows, masks }, counts)
    }

    /// The mask of a froxel's cell, and the lights that it has room for.
    pub(crate) fn read(&self, setup: &Setup<'_>, volume: &Volume, [column, row, k]: [u32; 3]) -> (Mask, u32) {
        let cell = [column / self.side, row / self.side, k];
        let chosen = setup.strongest.chosen(setup.point(&volume.layout, cell, self.side));
        let [x, y, k] = cell.map(|i| i as usize);
        (self.masks[x + self.columns as usize * (y + self.rows as usize * k)], chosen)
    }
}

/// The lights that any froxel of a cell needs a ray to.
fn needs_of_cell(volume: &Volume, [x, y, k]: [u32; 3], side: u32) -> u32 {
    let [columns, rows, _] = volume.dims();
    let mut needed = 0;
    for row in y * side..((y + 1) * side).min(rows) {
        for column in x * side..((x + 1) * side).min(columns) {
            needed |= volume.needs_of([column, row, k]).rays;
        }
    }
    needed
}
