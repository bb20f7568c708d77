//! What a frame of froxels is given.

use glam::Vec3;
use scene::{Aabb, AirlightModel, Camera, Light, Medium, Visibility};

use crate::{Counts, FroxelError, MAX_LIGHTS};

/// All views of a frame, and what they see.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// Views that share the grid.
    pub views: &'a [View<'a>],
    /// The medium, of any kind.
    pub medium: &'a Medium,
    /// At most [`MAX_LIGHTS`].
    pub lights: &'a [Light],
    /// How airlight of local lights is formed.
    pub model: AirlightModel,
    /// What casts shadows; `None` if nothing does.
    pub occluders: Option<Occluders<'a>>,
}

/// A view: where it looks from, and how far its rays go.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Columns and rows; units: pixels.
    pub size: (u32, u32),
    /// Distance along each pixel's ray at which it ends, row-major, row 0 at the top; infinite where it hits nothing.
    /// Units: m.
    pub ends: &'a [f32],
}

/// Shadows to ask for, and where their casters are.
#[derive(Clone, Copy)]
pub struct Occluders<'a> {
    /// Answers shadow rays; a light counts as lit from 0.5 on.
    pub visibility: &'a dyn Visibility,
    /// A box around all that casts shadows; units: m.
    pub bounds: Aabb,
}

impl std::fmt::Debug for Occluders<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Occluders").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Frame<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Frame")
            .field("views", &self.views.len())
            .field("lights", &self.lights.len())
            .field("occluders", &self.occluders)
            .finish_non_exhaustive()
    }
}

impl Frame<'_> {
    /// # Errors
    /// [`FroxelError::TooManyLights`] and [`FroxelError::View`].
    pub fn check(&self) -> Result<(), FroxelError> {
        if self.lights.len() > MAX_LIGHTS {
            return Err(FroxelError::TooManyLights { got: self.lights.len(), most: MAX_LIGHTS });
        }
        for (view, given) in self.views.iter().enumerate() {
            let ((width, height), got) = (given.size, given.ends.len());
            if width == 0 || height == 0 || got as u64 != u64::from(width) * u64::from(height) {
                return Err(FroxelError::View { view, width, height, got });
            }
        }
        Ok(())
    }

    /// The casters' box; `None` where nothing can cast a shadow.
    pub(crate) fn casters(&self) -> Option<Aabb> {
        self.occluders.map(|occluders| occluders.bounds).filter(|bounds| !bounds.is_empty())
    }
}

/// The pictures of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// By view and pixel, row-major: airlight up to where the pixel's ray ends, or the last slice; units: W/(m²·sr).
    pub airlight: Vec<Vec<Vec3>>,
    /// What it cost.
    pub counts: Counts,
}
