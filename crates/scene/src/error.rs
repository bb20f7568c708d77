//! What can be wrong with a scene.

use media_math::MediumError;
use thiserror::Error;

/// A value that makes no sense in a scene; the text names it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A camera without a view.
    #[error("camera: {0}")]
    Camera(String),
    /// A light that cannot shine.
    #[error("light: {0}")]
    Light(String),
    /// A mesh with broken positions or indices.
    #[error("mesh: {0}")]
    Mesh(String),
    /// Coefficients or a phase function without meaning.
    #[error("medium: {0}")]
    Medium(#[from] MediumError),
    /// A density without meaning.
    #[error("density: {0}")]
    Density(String),
    /// The scene has more triangles than a 32-bit index reaches.
    #[error("the scene has {0} triangles; at most 2^31 can be indexed")]
    TooManyTriangles(usize),
    /// Coordinates too large for the arithmetic of shadow rays in `f32`.
    #[error("the scene reaches {largest} m from the origin; the wide hierarchy takes at most {most} m")]
    TooWide {
        /// Largest coordinate of the scene; units: m.
        largest: f32,
        /// Largest that is taken; units: m.
        most: f32,
    },
}
