//! What lit surfaces are made of: a view of them, a medium and lights.

use scene::{Camera, Medium};

use super::SurfaceTriangles;
use crate::Lamp;

/// Surfaces to light.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceFrame<'a> {
    /// Where the surfaces are seen from.
    pub camera: &'a Camera,
    /// Columns and rows; units: pixels.
    pub size: (u32, u32),
    /// What each pixel sees.
    pub visible: VisibleSurfaces<'a>,
    /// What the surfaces are.
    pub triangles: &'a SurfaceTriangles,
    /// The medium that attenuates on both ways.
    pub medium: &'a Medium,
    /// The lights, [`MAX_LIGHTS`](crate::MAX_LIGHTS) at most; one with shadows casts shadow rays.
    pub lamps: &'a [Lamp<'a>],
}

/// A visibility buffer: what the view ray through each pixel's centre hits, row by row from the top.
#[derive(Debug, Clone, Copy)]
pub struct VisibleSurfaces<'a> {
    /// Distances along the rays; infinite where a ray hits nothing; units: m.
    pub distances: &'a [f32],
    /// Indices of the triangles; any that no triangle has, such as `u32::MAX`, where a ray hits nothing.
    pub triangles: &'a [u32],
}
