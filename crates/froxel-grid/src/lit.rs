//! What a lit froxel holds.

use glam::Vec3;

/// Light and medium in one froxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lit {
    /// Light that its medium sends towards the eye, by metre; units: W/(m³·sr).
    pub source: Vec3,
    /// Density of the medium, a factor on its coefficients; −1 where the froxel lies behind all that is seen, and has
    /// no value.
    pub density: f32,
}

impl Lit {
    /// A froxel that is not needed.
    pub const NONE: Self = Self { source: Vec3::ZERO, density: -1.0 };

    /// Whether the froxel has a value.
    pub fn is_some(&self) -> bool {
        self.density >= 0.0
    }
}
