//! Shadow volumes on the GPU: the casters' edges, their silhouette for each light, and for each view the frontmost and
//! backmost side face of every pixel or tile of pixels.
//!
//! A light that stands still keeps its silhouette. Twins of `shaders/volume/`; the same on the CPU is in `hybrid-march`.

mod casters;
mod faces;
mod silhouette;

pub use casters::ShadowCasters;
pub(crate) use faces::{FacePasses, FaceTarget};
pub use silhouette::ShadowVolume;
pub(crate) use silhouette::{Key, key_of};

use crate::pass::{ComputePass, Step};
use crate::pipelines::Pipelines;
use crate::{CreateError, PrepareError};

/// For how many pixels the frontmost and backmost faces of a shadow volume are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Faces {
    /// For each pixel, at its centre: the outermost boundaries of shadow are those of the geometry. One draw of all
    /// faces, or two where float32 does not blend.
    Pixels,
    /// For tiles of so many pixels a side, conservatively: nothing is missed, at a small part of the cost.
    Tiles(u32),
}

impl Faces {
    /// The same for an image whose pixels are `scale` pixels wide: tiles shrink as their pixels grow, but not below
    /// what pays, since there are fewer pixels to save steps in.
    pub(crate) fn at_scale(self, scale: u32) -> Self {
        match self {
            Self::Pixels => Self::Pixels,
            Self::Tiles(side) => Self::Tiles((side / scale).max(side.min(8)).max(1)),
        }
    }

    /// Pixels along the side of what faces are found for.
    pub(crate) fn side(self) -> u32 {
        match self {
            Self::Pixels => 1,
            Self::Tiles(side) => side.max(1),
        }
    }
}

/// What a technique that uses shadow volumes needs on a device.
#[derive(Debug)]
pub(crate) struct VolumePasses {
    silhouette: silhouette::SilhouettePass,
    faces: FacePasses,
}

impl VolumePasses {
    pub(crate) fn new(pipelines: &Pipelines) -> Result<Self, CreateError> {
        Ok(Self {
            silhouette: silhouette::SilhouettePass::new(pipelines)?,
            faces: FacePasses::new(pipelines)?,
        })
    }

    /// The steps that find the silhouette for a light.
    pub(crate) fn silhouette(
        &self,
        device: &wgpu::Device,
        volume: &ShadowVolume,
        light: &scene::Light,
    ) -> Vec<Step> {
        self.silhouette.steps(device, volume, light)
    }

    /// The steps that find a view's faces, and the texture that they are left in.
    pub(crate) fn faces(
        &self,
        device: &wgpu::Device,
        volume: &ShadowVolume,
        target: &FaceTarget<'_>,
    ) -> Result<(Vec<Step>, wgpu::Texture), PrepareError> {
        self.faces.steps(device, volume, target)
    }
}

/// A pass over as many threads of groups of 64 as a mesh has edges.
pub(crate) fn spread(groups: u32) -> [u32; 3] {
    const WIDEST: u32 = 32_768;
    [groups.clamp(1, WIDEST), groups.div_ceil(WIDEST).max(1), 1]
}

/// A step of a pass.
fn compute(pass: ComputePass) -> Step {
    Step::Compute(pass)
}
