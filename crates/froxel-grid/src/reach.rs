//! How far froxels are needed: no farther than what is seen through them.

use crate::layout::FroxelView;
use crate::{Counts, View, parallel};

/// By tile, row-major: the largest distance at which a ray ends in it or in one of the eight tiles around it, at most
/// `range`; units: m.
///
/// A pixel reads the four nearest columns of froxels, so that those next to it must reach as far.
pub(crate) fn reach(view: &View<'_>, layout: &FroxelView, range: f32) -> Vec<f32> {
    let (columns, rows) = layout.tiles();
    let (columns, rows, tile) = (columns as usize, rows as usize, layout.tile as usize);
    let (width, height) = (view.size.0 as usize, view.size.1 as usize);
    let mut farthest = vec![0.0_f32; columns * rows];
    parallel::rows(&mut farthest, columns, |row, tiles| {
        for y in row * tile..((row + 1) * tile).min(height) {
            for (x, &end) in view.ends[y * width..(y + 1) * width].iter().enumerate() {
                let tile = &mut tiles[x / tile];
                *tile = tile.max(end.min(range));
            }
        }
        Counts::default()
    });
    let mut reach = vec![0.0_f32; columns * rows];
    parallel::rows(&mut reach, columns, |row, tiles| {
        for (column, tile) in tiles.iter_mut().enumerate() {
            for y in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
                for x in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                    *tile = tile.max(farthest[y * columns + x]);
                }
            }
        }
        Counts::default()
    });
    reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scene::Camera;

    #[test]
    fn neighbours_are_reached_too() {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.8).unwrap();
        let size = (20, 12);
        let mut ends = vec![1.0; 240];
        ends[2 * 20 + 1] = 5.0;
        ends[11 * 20 + 19] = f32::INFINITY;
        let view = View { camera: &camera, size, ends: &ends };
        let layout = FroxelView::new(&camera, size, 4);
        let got = reach(&view, &layout, 9.0);
        assert_eq!(got, [5.0, 5.0, 1.0, 1.0, 1.0, 5.0, 5.0, 1.0, 9.0, 9.0, 1.0, 1.0, 1.0, 9.0, 9.0]);
    }
}
