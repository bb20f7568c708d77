//! wip
mod aabb;
#[cfg(feature = "bvh")]
mod bvh;
mod camera;
mod cone;
mod error;
#[cfg(feature = "gltf")]
pub mod import;
mod light;
mod medium;
mod medium_path;
mod mesh;
#[cfg(feature = "procedural")]
pub mod procedural;
mod ray;
mod refusal;
#[expect(clippy::module_inception, reason = "the type and its file share the crate's name")]
mod scene;
mod visibility;

pub use aabb::Aabb;
#[cfg(feature = "bvh")]
pub use bvh::{Bvh, BvhVisibility, Hit, PlaneRegion, Triangle};
pub use camera::Camera;
pub use error::SceneError;
pub use light::{DirectionalLight, Light, LightId, LightTexture, PointLight, SpotLight, TextureFilter};
pub use medium::{AirlightModel, Density, DensityGrid, Medium, RgbMedium};
pub use mesh::Mesh;
pub use ray::{DRay, Interval, Ray};
pub use refusal::Refusal;
pub use scene::{Material, Scene};
pub use visibility::{LitIntervals, Unoccluded, Visibility};
