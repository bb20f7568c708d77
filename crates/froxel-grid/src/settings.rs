//! How froxels are laid out, and where their shadows come from: plain values, the same for CPU and GPU.

use crate::FroxelError;

/// Most slices of a froxel volume.
pub const MAX_SLICES: u32 = 256;

/// Most lights of a frame.
pub const MAX_LIGHTS: usize = 32;

/// Voxels along the side of a brick.
pub const BRICK: u32 = 8;

/// Most bricks along an axis of the scene: their place is a key of ten bits an axis.
pub const MAX_BRICKS: u32 = 1023;

/// A froxel volume for each view (Hillaire 2015), and the shadows in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Froxels {
    /// Pixels along the side of a froxel.
    pub tile: u32,
    /// Slices in depth, 1 to [`MAX_SLICES`].
    pub slices: u32,
    /// Distance along the view ray at which the last slice ends; units: m.
    pub range: f32,
    /// Slice *k* of *n* begins at range·(e^(curve·k/n) − 1)/(e^curve − 1): 0 makes all equally deep.
    pub curve: f32,
    /// Where shadows come from.
    pub shadows: Shadowing,
    /// Jitter and accumulation over frames; without it every frame stands alone.
    pub temporal: Option<Temporal>,
}

impl Froxels {
    /// The reference: 8 × 8 pixels, 128 slices, each froxel with shadow rays of its own, up to `range` metres.
    pub fn new(range: f32) -> Self {
        Self { tile: 8, slices: 128, range, curve: 2.0, shadows: Shadowing::Traced, temporal: None }
    }

    /// The same with shadows from a shared grid.
    #[must_use]
    pub fn with_grid(self, grid: SharedGrid) -> Self {
        Self { shadows: Shadowing::Shared(grid), ..self }
    }

    /// The shared grid, if there is one.
    pub fn grid(&self) -> Option<&SharedGrid> {
        match &self.shadows {
            Shadowing::Traced => None,
            Shadowing::Shared(grid) => Some(grid),
        }
    }

    /// The volumes whose shadows are traced for one view alone: froxels along the side of one of theirs, and slices.
    /// That of the reference has a ray for every froxel.
    pub fn near_volume(&self) -> (u32, u32) {
        match self.grid().map(|grid| grid.near) {
            None => (1, self.slices),
            Some(Near::Frustum { side, slices }) => (side, slices.min(self.slices)),
            Some(Near::Grid | Near::FineGrid { .. }) => (1, 0),
        }
    }

    /// Slices whose shadows are in the finer of two grids.
    pub fn fine_slices(&self) -> u32 {
        match self.grid().map(|grid| grid.near) {
            Some(Near::FineGrid { slices, .. }) => slices.min(self.slices),
            _ => 0,
        }
    }

    /// # Errors
    /// [`FroxelError`] names the value that makes no sense.
    pub fn check(&self) -> Result<(), FroxelError> {
        let bad = |name, value: f64, needed| Err(FroxelError::Setting { name, value, needed });
        if self.tile == 0 {
            return bad("tile", 0.0, "at least 1 pixel");
        }
        if !(1..=MAX_SLICES).contains(&self.slices) {
            return bad("slices", self.slices.into(), "1 to 256");
        }
        if !(self.range.is_finite() && self.range > 0.0) {
            return bad("range", self.range.into(), "positive and finite, in metres");
        }
        if !(0.0..=20.0).contains(&self.curve) {
            return bad("curve", self.curve.into(), "0 to 20");
        }
        if let Some(temporal) = self.temporal
            && temporal.frames == 0
        {
            return bad("temporal frames", 0.0, "at least 1");
        }
        let Some(grid) = self.grid() else { return Ok(()) };
        if !(grid.voxel_size.is_finite() && grid.voxel_size > 0.0) {
            return bad("voxel size", grid.voxel_size.into(), "positive and finite, in metres");
        }
        match grid.near {
            Near::Frustum { side: 0, .. } => {
                return bad("side of the shadow frustum", 0.0, "at least 1 froxel");
            }
            Near::FineGrid { ratio, .. } if ratio < 2 => {
                return bad("ratio of the two grids", ratio.into(), "at least 2");
            }
            Near::FineGrid { .. } if !matches!(grid.memory, GridMemory::Bricks { .. }) => {
                return bad("ratio of the two grids", 2.0, "used with bricks");
            }
            _ => {}
        }
        match (grid.memory, grid.update) {
            (GridMemory::Bricks { most: 0 }, _) => bad("bricks", 0.0, "at least 1"),
            (GridMemory::Bricks { .. }, Update::InFrustums { .. }) => {
                bad("bricks", f64::NAN, "used with marked voxels: what no froxel reads has no brick")
            }
            _ => Ok(()),
        }
    }
}

/// Where the shadows of froxels come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shadowing {
    /// A shadow ray from every froxel to every light that shines on it: the reference.
    Traced,
    /// The shared shadow grid.
    Shared(SharedGrid),
}

/// Shadows in voxels of the world, shared by all views (Stojanovic et al. 2023, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedGrid {
    /// Side of a voxel; units: m.
    pub voxel_size: f32,
    /// What the froxels next to a viewer read.
    pub near: Near,
    /// Which voxels a frame traces.
    pub update: Update,
    /// Where voxels are kept.
    pub memory: GridMemory,
    /// How froxels read them.
    pub reads: GridReads,
    /// Lights of a voxel.
    pub lights: MaskWidth,
}

impl SharedGrid {
    /// The paper's scheme: a frustum of 16 × 16 pixels over a third of 128 slices, every voxel in sight traced every
    /// other frame, nearest voxel.
    pub fn paper(voxel_size: f32) -> Self {
        Self {
            voxel_size,
            near: Near::Frustum { side: 2, slices: 43 },
            update: Update::InFrustums { alternate: true },
            memory: GridMemory::Dense,
            reads: GridReads::Nearest,
            lights: MaskWidth::Eight,
        }
    }

    /// The same frustum, and only voxels that some froxel will read.
    pub fn marked(voxel_size: f32) -> Self {
        Self { update: Update::Marked { alternate: false }, ..Self::paper(voxel_size) }
    }
}

/// What the froxels next to a viewer read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Near {
    /// The grid, as all others.
    Grid,
    /// A frustum of the viewer's own (section 3.1.2).
    Frustum {
        /// Froxels along the side of one of its cells.
        side: u32,
        /// Slices from the viewer on.
        slices: u32,
    },
    /// A second shared grid with finer voxels (section 5.2); needs [`GridMemory::Bricks`].
    FineGrid {
        /// Voxels along the side of a voxel of the other.
        ratio: u32,
        /// Slices from the viewer on.
        slices: u32,
    },
}

/// Which voxels a frame traces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update {
    /// Every voxel whose centre some view has in its frustum, to every light (section 3.1.1).
    InFrustums {
        /// Whether only every other layer in z is traced, in turns; the rest keeps what it has.
        alternate: bool,
    },
    /// Those that some froxel will read, to the lights that shine on it.
    Marked {
        /// Whether froxels read only every other layer in z, in turns.
        alternate: bool,
    },
}

/// Where voxels are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridMemory {
    /// All over the casters' box.
    Dense,
    /// In bricks of [`BRICK`]³ voxels, where froxels read.
    Bricks {
        /// Room for so many; froxels for which there is none are lit, and counted.
        most: u32,
    },
}

/// How froxels read voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridReads {
    /// The voxel that the froxel's sample lies in.
    Nearest,
    /// Eight voxels, weighted by distance.
    ///
    /// The paper interpolates radiance that it evaluates at the eight centres. All of it but visibility is known at the
    /// froxel itself, so that visibility alone is interpolated here: less work, and no blur of the light's falloff.
    Trilinear,
}

/// Lights for which a voxel has room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskWidth {
    /// 8: one byte a voxel, as in the paper.
    Eight,
    /// 16.
    Sixteen,
    /// 32.
    ThirtyTwo,
}

impl MaskWidth {
    /// The number of lights.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// The smallest that has room for `lights`.
    pub const fn of(lights: usize) -> Self {
        match lights {
            0..=8 => Self::Eight,
            9..=16 => Self::Sixteen,
            _ => Self::ThirtyTwo,
        }
    }
}

/// Jitter and accumulation over frames (Hillaire 2015).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Temporal {
    /// A froxel is the mean of so many frames; once there are more, the newest counts for 1/frames.
    pub frames: u32,
    /// Whether the history is kept where lights, medium or casters have changed. Forgotten, there is no ghost, and
    /// nothing is smoothed while they move.
    pub keeps_changed: bool,
}

impl Default for Temporal {
    fn default() -> Self {
        Self { frames: 16, keeps_changed: false }
    }
}

impl Temporal {
    /// Where in its slice frame `index` samples a froxel, in (0, 1): a golden-ratio sequence that begins in the middle.
    pub fn jitter(index: u32) -> f32 {
        (0.5 + f64::from(index) * 0.618_033_988_749_894_9).fract() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_named() {
        assert!(Froxels::new(10.0).check().is_ok());
        assert!(Froxels::new(10.0).with_grid(SharedGrid::paper(0.5)).check().is_ok());
        let named = |froxels: Froxels| froxels.check().unwrap_err().to_string();
        assert!(named(Froxels::new(f32::NAN)).contains("range"));
        assert!(named(Froxels { tile: 0, ..Froxels::new(1.0) }).contains("tile"));
        assert!(named(Froxels { slices: 257, ..Froxels::new(1.0) }).contains("slices"));
        assert!(named(Froxels::new(1.0).with_grid(SharedGrid::paper(0.0))).contains("voxel size"));
        let bricks = SharedGrid { memory: GridMemory::Bricks { most: 1 }, ..SharedGrid::paper(1.0) };
        assert!(named(Froxels::new(1.0).with_grid(bricks)).contains("bricks"));
    }

    #[test]
    fn jitter_begins_in_the_middle_and_spreads() {
        assert_eq!(Temporal::jitter(0), 0.5);
        let mut places: Vec<f32> = (0..16).map(Temporal::jitter).collect();
        places.sort_by(f32::total_cmp);
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] < 0.12), "{places:?}");
    }
}
