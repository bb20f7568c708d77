//! Airlight of each pixel from the columns of froxels around it, by the distance at which its ray ends (section 3.1.4).

use glam::Vec3;

use crate::{Counts, FroxelView, Slices, View, parallel};

/// Airlight by pixel, row-major: bilinear between the four nearest columns, linear within a slice; units: W/(m²·sr).
///
/// `ends` has what lies before the end of each slice, as [`accumulate`](crate::accumulate::accumulate) makes it.
pub(crate) fn apply(view: &View<'_>, layout: &FroxelView, slices: &Slices, ends: &[Vec3]) -> Vec<Vec3> {
    let (columns, rows) = layout.tiles();
    let (width, count) = (view.size.0 as usize, slices.count() as usize);
    let range = slices.starts[count];
    let mut airlight = vec![Vec3::ZERO; view.ends.len()];
    let near = |pixel: usize, tiles: u32| {
        let at = ((pixel as f32 + 0.5) / layout.tile as f32 - 0.5).clamp(0.0, (tiles - 1) as f32);
        let low = at.floor();
        (low as usize, (low as usize + 1).min(tiles as usize - 1), at - low)
    };
    parallel::rows(&mut airlight, width, |y, row| {
        let (top, bottom, down) = near(y, rows);
        for (x, pixel) in row.iter_mut().enumerate() {
            let (left, right, across) = near(x, columns);
            let (k, share) = slices.position(view.ends[y * width + x].min(range));
            let before = |column: usize, row: usize| {
                let column = &ends[(column + columns as usize * row) * count..][..count];
                let start = if k == 0 { Vec3::ZERO } else { column[k as usize - 1] };
                start.lerp(column[k as usize], share)
            };
            let upper = before(left, top).lerp(before(right, top), across);
            let lower = before(left, bottom).lerp(before(right, bottom), across);
            *pixel = upper.lerp(lower, down);
        }
        Counts::default()
    });
    airlight
}
