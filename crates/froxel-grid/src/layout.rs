//! Where froxels are: columns of tiles, slices of distance.
//!
//! Points are `f32` throughout, by the operations of `shaders/shared/froxel.wgsl` in their order, so that CPU and GPU read
//! and trace the same voxels.

use glam::{Vec2, Vec3};
use scene::Camera;

use crate::Froxels;

/// The slices of a froxel volume.
#[derive(Debug, Clone, PartialEq)]
pub struct Slices {
    /// Distance at which each begins, and at last where the last one ends; units: m.
    pub starts: Vec<f32>,
}

impl Slices {
    /// Those of settings that have been checked.
    pub fn new(froxels: &Froxels) -> Self {
        let (range, curve) = (f64::from(froxels.range), f64::from(froxels.curve));
        let start = |k: u32| {
            let share = f64::from(k) / f64::from(froxels.slices);
            let grown = if curve == 0.0 { share } else { (curve * share).exp_m1() / curve.exp_m1() };
            (range * grown) as f32
        };
        Self { starts: (0..=froxels.slices).map(start).collect() }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Depth of slice `k`; units: m.
    pub fn depth(&self, k: u32) -> f32 {
        self.starts[k as usize + 1] - self.starts[k as usize]
    }

    /// The distance at a share of slice `k`; units: m.
    pub fn distance(&self, k: u32, share: f32) -> f32 {
        self.starts[k as usize] + share * self.depth(k)
    }

    /// The slice that a distance lies in, and at which share of it: clamped to the volume.
    pub fn position(&self, distance: f32) -> (u32, f32) {
        let after = self.starts.partition_point(|&start| start <= distance);
        let k = after.saturating_sub(1).min(self.count() as usize - 1) as u32;
        let share = (distance - self.starts[k as usize]) / self.depth(k);
        (k, share.clamp(0.0, 1.0))
    }
}

/// A view as its froxels see it: the eye, the axes of the camera, and tangents by pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FroxelView {
    /// Eye; units: m.
    pub eye: Vec3,
    /// Unit vectors to the right, to the top and into the picture.
    pub axes: [Vec3; 3],
    /// Tangents at the upper left corner.
    pub offset: Vec2,
    /// Tangents by pixel: downwards negative.
    pub scale: Vec2,
    /// Columns and rows of the picture; units: pixels.
    pub size: (u32, u32),
    /// Pixels along the side of a froxel.
    pub tile: u32,
}

impl FroxelView {
    /// A camera's picture of `size` pixels in tiles.
    pub fn new(camera: &Camera, size: (u32, u32), tile: u32) -> Self {
        let half = (0.5 * f64::from(camera.fov_y)).tan();
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let aside = half * width / height;
        Self {
            eye: camera.position,
            axes: [camera.right, camera.up, camera.forward],
            offset: Vec2::new(-aside as f32, half as f32),
            scale: Vec2::new((2.0 * aside / width) as f32, (-2.0 * half / height) as f32),
            size,
            tile,
        }
    }

    /// Columns and rows of froxels.
    pub fn tiles(&self) -> (u32, u32) {
        (self.size.0.div_ceil(self.tile), self.size.1.div_ceil(self.tile))
    }

    /// Columns and rows of cells of `side` × `side` froxels.
    pub fn cells(&self, side: u32) -> (u32, u32) {
        let (columns, rows) = self.tiles();
        (columns.div_ceil(side), rows.div_ceil(side))
    }

    /// Unit vector through the middle of a cell of `side` × `side` froxels; 1 for a froxel itself. World axes.
    pub fn direction(&self, column: u32, row: u32, side: u32) -> Vec3 {
        let width = (self.tile * side) as f32;
        let pixel = Vec2::new((column as f32 + 0.5) * width, (row as f32 + 0.5) * width);
        let tangent = pixel * self.scale + self.offset;
        let length = (tangent.x * tangent.x + tangent.y * tangent.y + 1.0).sqrt();
        let [right, up, forward] = self.axes;
        (tangent.x / length) * right + (tangent.y / length) * up + (1.0 / length) * forward
    }

    /// Side of a froxel at distance 1 straight ahead, as a share of the distance.
    pub fn tile_width(&self) -> f32 {
        self.tile as f32 * self.scale.x
    }

    /// Where a point is in the picture, in pixels, and its distance; `None` behind the eye.
    pub fn project(&self, point: Vec3) -> Option<(Vec2, f32)> {
        let from = point - self.eye;
        let [right, up, forward] = self.axes;
        let depth = from.dot(forward);
        if !(depth > 0.0) {
            return None;
        }
        let tangent = Vec2::new(from.dot(right), from.dot(up)) / depth;
        Some(((tangent - self.offset) / self.scale, from.length()))
    }

    /// Whether a point is in the picture and no farther than `range` metres.
    pub fn sees(&self, point: Vec3, range: f32) -> bool {
        self.project(point).is_some_and(|(pixel, distance)| {
            let size = Vec2::new(self.size.0 as f32, self.size.1 as f32);
            pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(size).all() && distance <= range
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn slices_there_and_back() {
        for curve in [0.0, 2.0, 6.0] {
            let slices = Slices::new(&Froxels { curve, slices: 31, ..Froxels::new(20.0) });
            assert_eq!((slices.starts[0], slices.starts[31], slices.count()), (0.0, 20.0, 31));
            for k in 0..31 {
                for share in [0.0, 0.25, 0.75] {
                    let (back, at) = slices.position(slices.distance(k, share));
                    assert!(back == k && (at - share).abs() < 1e-4, "{k} {share}: {back} {at}");
                }
            }
            assert_eq!(slices.position(-1.0), (0, 0.0));
            assert_eq!(slices.position(f32::INFINITY), (30, 1.0));
        }
    }

    #[test]
    fn directions_are_those_of_the_camera() {
        let camera =
            Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 1.0, 0.5), Vec3::Y, 0.9).unwrap();
        let view = FroxelView::new(&camera, (100, 60), 8);
        assert_eq!((view.tiles(), view.cells(2)), ((13, 8), (7, 4)));
        for (column, row, side) in [(0, 0, 1), (12, 7, 1), (3, 2, 2)] {
            let width = f64::from(8 * side);
            let pixel = DVec2::new((f64::from(column) + 0.5) * width, (f64::from(row) + 0.5) * width);
            let expected = camera.ray(pixel, (100, 60)).direction.as_vec3();
            let got = view.direction(column, row, side);
            assert!((got - expected).length() < 1e-6);
            let (back, distance) = view.project(view.eye + 7.0 * got).unwrap();
            assert!((back - pixel.as_vec2()).length() < 1e-3 && (distance - 7.0).abs() < 1e-5);
        }
        assert!(
            view.sees(view.eye + 5.0 * camera.forward, 5.1)
                && !view.sees(view.eye + 5.0 * camera.forward, 4.9)
        );
        assert!(!view.sees(view.eye - camera.forward, 5.0));
    }
}
