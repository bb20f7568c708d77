//! What can be wrong with a frame of froxels.

use thiserror::Error;

/// Settings or a frame that make no sense.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum FroxelError {
    /// A setting out of its range.
    #[error("froxels: {name} must be {needed}, got {value}")]
    Setting {
        /// Which.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        needed: &'static str,
    },
    /// More lights than a frame takes.
    #[error("a frame of froxels takes at most {most} lights, got {got}")]
    TooManyLights {
        /// Lights given.
        got: usize,
        /// Lights that fit.
        most: usize,
    },
    /// A view without pixels, or with another number of distances.
    #[error("view {view} of {width} x {height} pixels cannot have {got} distances")]
    View {
        /// Which view.
        view: usize,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Distances given.
        got: usize,
    },
    /// A grid with more voxels or bricks, along an axis or in all, than can be told apart or kept.
    #[error(
        "voxels of {voxel_size} m divide the scene into {needed} {unit}, of which {most} fit; take larger voxels"
    )]
    TooManyVoxels {
        /// Side of a voxel; units: m.
        voxel_size: f32,
        /// How many there would be.
        needed: u64,
        /// How many fit.
        most: u64,
        /// Of what.
        unit: &'static str,
    },
}
