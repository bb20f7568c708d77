//! Froxels of the frame before, found again from where the camera is now (section 3.1.3; Hillaire 2015).

use glam::Vec3;

use crate::volume::Volume;
use crate::{Counts, FroxelView, Lit, Slices, parallel};

/// Least share of the eight froxels around a point that must have a value.
const LEAST_WEIGHT: f32 = 0.5;

/// A view's froxels after a frame, and of how many frames they are the mean.
#[derive(Debug)]
pub(crate) struct History {
    pub(crate) layout: FroxelView,
    pub(crate) lit: Vec<Lit>,
    pub(crate) frames: u32,
}

impl History {
    /// What was at a point: trilinear between tile centres and the middles of slices, over the froxels that have a
    /// value. `None` outside of the view, and where too few have one.
    fn at(&self, slices: &Slices, point: Vec3) -> Option<Lit> {
        let (pixel, distance) = self.layout.project(point)?;
        let size = Vec3::new(
            self.layout.size.0 as f32,
            self.layout.size.1 as f32,
            slices.starts[slices.count() as usize],
        );
        let place = Vec3::new(pixel.x, pixel.y, distance);
        if !(place.cmpge(Vec3::ZERO).all() && place.cmple(size).all()) {
            return None;
        }
        let (k, share) = slices.position(distance);
        let (columns, rows) = self.layout.tiles();
        let dims = [columns, rows, slices.count()];
        let tile = self.layout.tile as f32;
        let at = Vec3::new(pixel.x / tile - 0.5, pixel.y / tile - 0.5, k as f32 + share - 0.5);
        let (low, f) = (at.floor(), at - at.floor());
        let mut sum = Lit { source: Vec3::ZERO, density: 0.0 };
        let mut weights = 0.0;
        for corner in 0..8_usize {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let along = |axis: usize| if side[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
            let weight = along(0) * along(1) * along(2);
            let index = |axis: usize| {
                let i = low[axis] + side[axis] as f32;
                (i >= 0.0 && i < dims[axis] as f32).then_some(i as usize)
            };
            let (Some(x), Some(y), Some(z)) = (index(0), index(1), index(2)) else { continue };
            let lit = self.lit[x + columns as usize * (y + rows as usize * z)];
            if lit.is_some() && weight > 0.0 {
                sum.source += weight * lit.source;
                sum.density += weight * lit.density;
                weights += weight;
            }
        }
        let mean = Lit { source: sum.source / weights, density: sum.density / weights };
        (weights >= LEAST_WEIGHT).then_some(mean)
    }

    /// Blends what was into a frame's froxels, whose own share is `share`.
    pub(crate) fn blend(&self, slices: &Slices, volume: &Volume, share: f32, lit: &mut [Lit]) {
        let [columns, rows, _] = volume.dims();
        parallel::rows(lit, columns as usize, |index, row| {
            let (k, y) = (index as u32 / rows, index as u32 % rows);
            for (x, lit) in (0..columns).zip(row) {
                if !lit.is_some() {
                    continue;
                }
                // its middle, wherever it sampled, so that nothing drifts along the ray
                let middle = volume.layout.eye + slices.distance(k, 0.5) * volume.layout.direction(x, y, 1);
                if let Some(before) = self.at(slices, middle) {
                    lit.source = before.source + share * (lit.source - before.source);
                    lit.density = before.density + share * (lit.density - before.density);
                }
            }
            Counts::default()
        });
    }
}
