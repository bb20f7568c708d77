//! Where voxels are: a lattice over the casters' box, divided into bricks.

use glam::{UVec3, Vec3};
use scene::Aabb;

use crate::{BRICK, FroxelError, MAX_BRICKS, SharedGrid};

/// Voxels over a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// Smallest corner; units: m.
    pub min: Vec3,
    /// Side of a voxel; units: m.
    pub voxel_size: f32,
    /// Voxels along x, y and z.
    pub dims: UVec3,
}

impl Lattice {
    /// Voxels of `voxel_size` metres over `bounds`; one in an empty box.
    ///
    /// # Errors
    /// [`FroxelError::TooManyVoxels`] with 2²⁴ voxels or more along an axis, which an `f32` could not tell apart.
    pub fn new(bounds: &Aabb, voxel_size: f32) -> Result<Self, FroxelError> {
        if bounds.is_empty() {
            return Ok(Self { min: Vec3::ZERO, voxel_size, dims: UVec3::ONE });
        }
        // a hundred-thousandth of a voxel more than whole ones is rounding
        let needed =
            ((bounds.max - bounds.min).as_dvec3() / f64::from(voxel_size) - 1e-5).ceil().max_element();
        let most = 1_u64 << 24;
        if !(needed < most as f64) {
            return Err(FroxelError::TooManyVoxels {
                voxel_size,
                needed: needed as u64,
                most,
                unit: "voxels along an axis",
            });
        }
        let dims = ((bounds.max - bounds.min).as_dvec3() / f64::from(voxel_size) - 1e-5).ceil().as_uvec3();
        Ok(Self { min: bounds.min, voxel_size, dims: dims.max(UVec3::ONE) })
    }

    /// The same box with `ratio` voxels along the side of each.
    #[must_use]
    pub fn finer(&self, ratio: u32) -> Self {
        Self { voxel_size: self.voxel_size / ratio as f32, dims: self.dims * ratio, ..*self }
    }

    /// Number of voxels.
    pub fn count(&self) -> u64 {
        self.dims.to_array().map(u64::from).iter().product()
    }

    /// Bricks along x, y and z.
    pub fn bricks(&self) -> UVec3 {
        (self.dims + (BRICK - 1)) / BRICK
    }

    /// Fails where bricks have no key.
    ///
    /// # Errors
    /// [`FroxelError::TooManyVoxels`] with more than [`MAX_BRICKS`] along an axis.
    pub fn check_bricks(&self) -> Result<(), FroxelError> {
        let needed = self.bricks().max_element();
        if needed > MAX_BRICKS {
            return Err(FroxelError::TooManyVoxels {
                voxel_size: self.voxel_size,
                needed: needed.into(),
                most: MAX_BRICKS.into(),
                unit: "bricks along an axis",
            });
        }
        Ok(())
    }

    /// The voxel that a point lies in, or the next one to it.
    pub fn voxel(&self, point: Vec3) -> UVec3 {
        let at = ((point - self.min) * (1.0 / self.voxel_size)).floor();
        at.clamp(Vec3::ZERO, (self.dims - 1).as_vec3()).as_uvec3()
    }

    /// The lowest of the eight voxels around a point, and the shares of the point on the way to the others. Voxels
    /// beyond the lattice count as the next one inside.
    pub fn around(&self, point: Vec3) -> ([UVec3; 2], Vec3) {
        let last = (self.dims - 1).as_vec3();
        let at = ((point - self.min) * (1.0 / self.voxel_size) - 0.5).clamp(Vec3::ZERO, last);
        let low = at.floor();
        ([low.as_uvec3(), (low + 1.0).min(last).as_uvec3()], at - low)
    }

    /// Centre of a voxel; units: m.
    pub fn center(&self, voxel: UVec3) -> Vec3 {
        self.min + (voxel.as_vec3() + 0.5) * self.voxel_size
    }

    /// The voxel that is read in its place in a frame of every other layer in z: `parity` is that of the layers that
    /// count.
    pub fn alternate(&self, voxel: UVec3, parity: u32) -> UVec3 {
        let z = (voxel.z & !1) | (parity & 1);
        UVec3::new(voxel.x, voxel.y, z.min(self.dims.z - 1))
    }
}

impl SharedGrid {
    /// The box of the grid's lattice: that of the casters with a voxel more on every side.
    ///
    /// A voxel answers from its centre. On the faces of the casters' own box half of the centres would lie between a
    /// caster and the light, and a flat caster, in the face of its own box, would have no shadow at all.
    pub fn bounds(&self, casters: &Aabb) -> Aabb {
        if casters.is_empty() {
            return *casters;
        }
        Aabb { min: casters.min - self.voxel_size, max: casters.max + self.voxel_size }
    }

    /// The lattice over [`SharedGrid::bounds`].
    ///
    /// # Errors
    /// [`FroxelError::TooManyVoxels`] as [`Lattice::new`].
    pub fn lattice(&self, casters: &Aabb) -> Result<Lattice, FroxelError> {
        Lattice::new(&self.bounds(casters), self.voxel_size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_casters_voxels_answer_from_both_of_its_sides() {
        let square = Aabb { min: Vec3::new(-1.0, 2.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
        for voxel_size in [0.1, 0.3, 1.0, 5.0] {
            let grid = SharedGrid::paper(voxel_size);
            let (bounds, lattice) = (grid.bounds(&square), grid.lattice(&square).unwrap());
            let height = |y: f32| lattice.center(lattice.voxel(Vec3::new(0.0, y, 0.0))).y;
            assert!(height(bounds.min.y) < 2.0 && height(bounds.max.y) > 2.0, "{lattice:?}");
        }
        assert!(SharedGrid::paper(1.0).bounds(&Aabb::EMPTY).is_empty());
    }

    #[test]
    fn voxels_there_and_back() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 1.0, 3.1) };
        let lattice = Lattice::new(&bounds, 0.25).unwrap();
        assert_eq!((lattice.dims, lattice.bricks()), (UVec3::new(8, 4, 5), UVec3::ONE));
        let voxel = UVec3::new(3, 2, 4);
        assert_eq!(lattice.voxel(lattice.center(voxel)), voxel);
        assert_eq!(lattice.voxel(Vec3::splat(-100.0)), UVec3::ZERO);
        assert_eq!(lattice.voxel(Vec3::splat(100.0)), lattice.dims - 1);
        let ([low, high], share) = lattice.around(lattice.center(voxel) + Vec3::new(0.125, 0.0, 0.0));
        assert_eq!((low, high.x), (voxel, 4));
        assert!((share.x - 0.5).abs() < 1e-5);
        assert_eq!(lattice.alternate(voxel, 1).z, 4);
        assert_eq!(lattice.alternate(UVec3::new(0, 0, 2), 1).z, 3);
        assert_eq!(lattice.finer(2).dims, lattice.dims * 2);
    }

    #[test]
    fn a_hundred_metres_of_thirds() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(100.0) };
        assert_eq!(Lattice::new(&bounds, 1.0 / 3.0).unwrap().dims, UVec3::splat(300));
        assert!(Lattice::new(&bounds, 1e-6).is_err());
        assert!(Lattice::new(&bounds, 0.01).unwrap().check_bricks().is_err());
        assert_eq!(Lattice::new(&Aabb::EMPTY, 1.0).unwrap().count(), 1);
    }
}
