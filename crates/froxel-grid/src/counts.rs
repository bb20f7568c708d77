//! What a frame of froxels cost, counted.

use std::iter::Sum;
use std::ops::{Add, AddAssign};

/// Counts of a frame over all its views; those of a GPU wrap at 2³².
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Shadow rays of the volumes of single views: all of the reference's.
    pub near_rays: u64,
    /// Shadow rays of the shared grid.
    pub grid_rays: u64,
    /// Froxels in front of the surfaces.
    pub froxels: u64,
    /// Voxels that were traced.
    pub voxels: u64,
    /// Bricks in use.
    pub bricks: u64,
    /// Reads of voxels whose brick found no room, which count as lit.
    pub missed: u64,
    /// Pairs of a froxel and a light that shines on it that its voxel had no room for, which count as dark.
    pub dropped: u64,
    /// Froxels whose radiance or density was negative or not finite, and was replaced by 0.
    pub not_finite: u64,
}

impl Counts {
    /// All shadow rays.
    pub fn rays(&self) -> u64 {
        self.near_rays + self.grid_rays
    }
}

impl Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            near_rays: self.near_rays + other.near_rays,
            grid_rays: self.grid_rays + other.grid_rays,
            froxels: self.froxels + other.froxels,
            voxels: self.voxels + other.voxels,
            bricks: self.bricks + other.bricks,
            missed: self.missed + other.missed,
            dropped: self.dropped + other.dropped,
            not_finite: self.not_finite + other.not_finite,
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), Add::add)
    }
}
