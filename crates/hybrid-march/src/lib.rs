//! Ray-marched volumetric shadows, after Wyman and Ramsey, *Interactive Volumetric Shadows in Participating Media
//! with Single-Scattering*, 2008.
//!
//! So far the crate holds the paper's baseline: [`BruteForce`], the march that asks for visibility at every step.
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use hybrid_march::{BruteForce, Occluders};
//! use scene::{Aabb, AirlightModel, DRay, Light, LightId, Medium, PointLight, Visibility};
//!
//! /// A wall at x = 1 that shadows everything beyond it.
//! struct Wall;
//! impl Visibility for Wall {
//!     fn visibility(&self, point: Vec3, _light: LightId) -> f32 {
//!         if point.x > 1.0 { 0.0 } else { 1.0 }
//!     }
//! }
//!
//! let medium = Medium::homogeneous([0.1; 3], [0.0; 3])?;
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 1.0, 0.0), Vec3::splat(10.0))?)];
//! let bounds = Aabb { min: Vec3::new(1.0, -9.0, -9.0), max: Vec3::new(1.1, 9.0, 9.0) };
//! let march = BruteForce {
//!     medium: &medium,
//!     lights: &lights,
//!     occluders: Some(Occluders { visibility: &Wall, bounds }),
//!     samples: 64,
//!     model: AirlightModel::Sun,
//! };
//! let ray = DRay { origin: DVec3::new(-4.0, 0.0, 0.0), direction: DVec3::X };
//! assert!(march.airlight(&ray, 8.0).airlight.x > 0.0);
//! # Ok::<(), scene::SceneError>(())
//! ```

mod adjacency;
mod brute_force;
mod extent;
mod face_bounds;
mod face_polygon;
mod hybrid;
mod light_mips;
mod piece;
mod proxy;
mod shadow_volume;
mod silhouette;
mod textured;
mod upsample;

pub use adjacency::{Adjacency, AdjacencyError, Edge, NO_SIDE};
pub use brute_force::{BruteForce, Marched, Occluders};
pub use extent::shadow_extent;
pub use face_bounds::FaceBounds;
pub use hybrid::Hybrid;
pub use light_mips::{Level, LightMips};
pub use proxy::{bounding_box, cluster, near_viewer};
pub use shadow_volume::ShadowVolume;
pub use silhouette::{Silhouette, SilhouetteEdge};
pub use textured::{Placement, TexturedMarch};
pub use upsample::{LowResolution, LowResolutionError};
