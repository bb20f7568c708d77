//! Ray-marched volumetric shadows, after Wyman and Ramsey, *Interactive Volumetric Shadows in Participating Media
//! with Single-Scattering*, 2008.
//!
//! [`Hybrid`] marches a view ray only between the frontmost and the backmost face of each light's shadow volume, and
//! evaluates airlight in closed form over what it finds lit. What it needs is made in steps, each of use by itself:
//!
//! | step | type |
//! | --- | --- |
//! | a mesh, welded, with its edges: any triangles, open, non-manifold, duplicated, wound either way | [`Adjacency`] |
//! | the edges between which light and shadow meet, for one light | [`Silhouette`] |
//! | their extrusion away from the light, and its outermost faces on a ray | [`ShadowVolume`] |
//! | the same for all pixels of a view, or conservatively for tiles of them | [`FaceBounds`] |
//! | the march between them, boundaries bisected | [`Hybrid`] |
//! | spots with pictures: three segments, mipmapped or blurred pictures | [`TexturedMarch`], [`LightMips`] |
//! | airlight for blocks of pixels, and the way back by depth | [`LowResolution`] |
//! | airlight where the picture changes, down to a target error, for any technique | [`Adaptive`] |
//! | simpler occluders in place of complex ones | [`bounding_box`], [`cluster`], [`near_viewer`] |
//!
//! [`BruteForce`] is the baseline: the march that asks for visibility at every step of a light's whole extent, for every
//! medium and light of the vocabulary.
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use hybrid_march::{Adjacency, Hybrid, Occluders, ShadowVolume};
//! use scene::{Aabb, AirlightModel, DRay, Interval, Light, LightId, Medium, PointLight, Visibility};
//!
//! /// A square of 2 m at y = 2, below a lamp at y = 4.
//! struct Square;
//! impl Visibility for Square {
//!     fn visibility(&self, point: Vec3, _light: LightId) -> f32 {
//!         let through = point * 2.0 / (4.0 - point.y);
//!         f32::from(point.y >= 2.0 || through.x.abs() >= 1.0 || through.z.abs() >= 1.0)
//!     }
//! }
//! let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 2.0, z));
//! let mesh = Adjacency::new([[a, b, c], [a, c, d]])?;
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(10.0))?)];
//!
//! // on a view ray along X at y = 0, in shadow from x = −2 to x = 2
//! let ray = DRay { origin: DVec3::new(-9.0, 0.0, 0.0), direction: DVec3::X };
//! let faces = ShadowVolume::new(&mesh, &lights[0]).faces(&ray, Interval::new(0.0, f64::INFINITY));
//! assert!(faces.is_some_and(|f| (f.start - 7.0).abs() < 1e-6 && (f.end - 11.0).abs() < 1e-6));
//!
//! // 16 steps between the faces, boundaries bisected 6 times
//! let medium = Medium::homogeneous([0.1; 3], [0.0; 3])?;
//! let occluders = Occluders { visibility: &Square, bounds: Aabb { min: a, max: c } };
//! let hybrid = Hybrid::new(&medium, &lights, Some(occluders), 16, 6, AirlightModel::Sun)?;
//! assert!((hybrid.airlight(&ray, 20.0, &[faces]).airlight.x - 0.0068098).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adaptive;
mod adjacency;
mod brute_force;
mod extent;
mod face_bounds;
mod face_polygon;
mod hybrid;
mod light_mips;
mod piece;
mod proxy;
mod sampling;
mod shadow_volume;
mod silhouette;
mod textured;
mod upsample;

pub use adaptive::{Adaptive, AdaptiveError, AdaptiveLevel, Tile, Tiles};
pub use adjacency::{Adjacency, AdjacencyError, Edge, NO_SIDE};
pub use brute_force::{BruteForce, Marched, Occluders};
pub use extent::shadow_extent;
pub use face_bounds::FaceBounds;
pub use hybrid::Hybrid;
pub use light_mips::{Level, LightMips};
pub use proxy::{bounding_box, cluster, near_viewer};
pub use sampling::Sampling;
pub use shadow_volume::ShadowVolume;
pub use silhouette::{Silhouette, SilhouetteEdge};
pub use textured::{Placement, TexturedMarch};
pub use upsample::{LowResolution, LowResolutionError};
