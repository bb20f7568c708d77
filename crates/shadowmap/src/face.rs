//! One image plane of a projection: where a point falls on it, and where a texel lies in the world.
//!
//! A face maps a point linearly to (U, V, W, z): texel coordinates are U/W and V/W, and z is the planar depth. Along a
//! view ray all four are linear in the distance, so that every question of the exact traversal (where does the ray
//! cross this texel's border, where does it pass this depth) is the root of a linear function.

use glam::{DVec2, DVec3};
use scene::DRay;

use crate::linear::Linear;

/// An image plane: perspective (W = z) or orthographic (W = 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Where depth is 0: the light, or the middle of the orthographic plane; units: m.
    pub origin: DVec3,
    /// Unit vector along rows, towards larger columns.
    pub right: DVec3,
    /// Unit vector along columns, towards larger rows.
    pub down: DVec3,
    /// Unit vector along which depth grows.
    pub forward: DVec3,
    /// Half the extent along `right` and `down`: a tangent (1) in perspective, a length (m) in orthographic.
    pub half: DVec2,
    /// Whether rays spread from the origin.
    pub perspective: bool,
}

/// A point as a face sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPoint {
    /// Which face.
    pub face: usize,
    /// Columns from the left; texel centres lie at +0.5.
    pub u: f64,
    /// Rows from the top; texel centres lie at +0.5.
    pub v: f64,
    /// Planar depth; units: m.
    pub depth: f64,
}

/// A view ray in the coordinates of a grid: all linear in the distance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Path {
    pub(crate) u: Linear,
    pub(crate) v: Linear,
    pub(crate) w: Linear,
    /// What is compared with stored depths.
    pub(crate) depth: Linear,
}

impl Face {
    /// (U, V, W, z) of a vector: a point relative to the origin, or (`is_point` false) a direction.
    #[inline]
    fn coordinates(&self, w: DVec3, size: (u32, u32), is_point: bool) -> [f64; 4] {
        let (x, y, z) =
            (w.dot(self.right) / self.half.x, w.dot(self.down) / self.half.y, w.dot(self.forward));
        let w = match (self.perspective, is_point) {
            (true, _) => z,
            (false, true) => 1.0,
            (false, false) => 0.0,
        };
        [f64::from(size.0) * 0.5 * (w + x), f64::from(size.1) * 0.5 * (w + y), w, z]
    }

    /// Homogeneous texel coordinates (U, V, W) and planar depth of a point.
    #[inline]
    pub(crate) fn project(&self, point: DVec3, size: (u32, u32)) -> [f64; 4] {
        self.coordinates(point - self.origin, size, true)
    }

    /// The view ray in texel coordinates.
    pub(crate) fn path(&self, ray: &DRay, size: (u32, u32)) -> Path {
        let at = self.project(ray.origin, size);
        let slope = self.coordinates(ray.direction, size, false);
        let [u, v, w, depth] = [0, 1, 2, 3].map(|i| Linear::new(at[i], slope[i]));
        Path { u, v, w, depth }
    }

    /// The way light travels through texel position (`u`, `v`): from the origin plane, one metre of depth per unit.
    #[inline]
    pub(crate) fn line(&self, u: f64, v: f64, size: (u32, u32)) -> (DVec3, DVec3) {
        let x = (2.0 * u / f64::from(size.0) - 1.0) * self.half.x;
        let y = (2.0 * v / f64::from(size.1) - 1.0) * self.half.y;
        let aside = x * self.right + y * self.down;
        if self.perspective {
            (self.origin, self.forward + aside)
        } else {
            (self.origin + aside, self.forward)
        }
    }

    /// The point at texel position (`u`, `v`) and planar depth `depth`, of a map of `size` (columns, rows).
    pub fn unproject(&self, u: f64, v: f64, depth: f64, size: (u32, u32)) -> DVec3 {
        let (from, direction) = self.line(u, v, size);
        from + depth * direction
    }

    /// Light's ray through texel position (`u`, `v`).
    pub fn ray(&self, u: f64, v: f64, size: (u32, u32)) -> DRay {
        let (origin, direction) = self.line(u, v, size);
        DRay { origin, direction: direction.normalize() }
    }

    /// Depth that a plane through `point` with normal `normal` gains over one texel at most, along rows or columns;
    /// infinite where the light grazes it. Units: m per texel.
    pub(crate) fn depth_slope(&self, point: DVec3, normal: DVec3, size: (u32, u32)) -> f64 {
        let w = point - self.origin;
        let z = w.dot(self.forward);
        let n = DVec3::new(normal.dot(self.right), normal.dot(self.down), normal.dot(self.forward));
        let texel = DVec2::new(2.0 * self.half.x / f64::from(size.0), 2.0 * self.half.y / f64::from(size.1));
        // perspective: depth is c/(n · direction); orthographic: (c − n_x x − n_y y)/n_z
        let (facing, reach) = if self.perspective { (normal.dot(w) / z, z) } else { (n.z, 1.0) };
        reach * (n.x * texel.x).abs().max((n.y * texel.y).abs()) / facing.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces() -> [Face; 2] {
        [true, false].map(|perspective| Face {
            origin: DVec3::new(1.0, 2.0, 3.0),
            right: DVec3::X,
            down: DVec3::NEG_Y,
            forward: DVec3::NEG_Z,
            half: DVec2::new(0.5, 2.0),
            perspective,
        })
    }

    #[test]
    fn texels_and_points_by_hand() {
        let [perspective, orthographic] = faces();
        // middle of texel (0, 0) of 2 × 4: a quarter from the left, an eighth from the top
        let p = perspective.unproject(0.5, 0.5, 2.0, (2, 4));
        assert_eq!(p, DVec3::new(1.0 - 0.25 * 2.0, 2.0 + 1.5 * 2.0, 1.0));
        let p = orthographic.unproject(0.5, 0.5, 2.0, (2, 4));
        assert_eq!(p, DVec3::new(1.0 - 0.25, 2.0 + 1.5, 1.0));
        for face in faces() {
            let [u, v, w, z] = face.project(face.unproject(1.3, 2.7, 4.0, (2, 4)), (2, 4));
            assert!((u / w - 1.3).abs() < 1e-12 && (v / w - 2.7).abs() < 1e-12 && (z - 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn slope_of_a_tilted_plane_is_its_difference_over_a_texel() {
        let normal = DVec3::new(0.3, 0.2, 1.0).normalize();
        for face in faces() {
            let (size, at) = ((4096, 4096), face.unproject(2000.0, 1500.0, 5.0, (4096, 4096)));
            let depth = |u: f64, v: f64| {
                let (from, along) = face.line(u, v, size);
                (at - from).dot(normal) / along.dot(normal)
            };
            let du = (depth(2000.5, 1500.0) - depth(1999.5, 1500.0)).abs();
            let dv = (depth(2000.0, 1500.5) - depth(2000.0, 1499.5)).abs();
            let slope = face.depth_slope(at, normal, size);
            assert!((slope / du.max(dv) - 1.0).abs() < 1e-5, "{slope} {du} {dv}");
        }
    }
}
