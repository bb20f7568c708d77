//! Shadow maps for light in a medium: how a light sees a scene, and which parts of a view ray it reaches.
//!
//! A [`DepthMap`] holds, for every texel of a [`Projection`], how deep light goes. It comes from a renderer's depth buffer
//! ([`DepthMap::from_host`] with a [`DepthEncoding`] that names its convention), or from the rasteriser here
//! ([`DepthMap::draw`], [`draw_maps`]). It answers two questions:
//!
//! - *Does the light reach this point?* Lookups: the nearest texel or a filtered share of several
//!   ([`MapVisibility`]), moments ([`VarianceMap`], [`VarianceVisibility`]). What a march asks at every step.
//! - *Which pieces of this view ray does it reach?* The exact traversal ([`ExactShadowMap`], [`MapTraversal`]), for both
//!   meanings that a map can have ([`MapSurface`]). No step, no sampling error: the reference for every technique that is
//!   exact with respect to the map.
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use scene::{DRay, Interval, Light, LightId, LitIntervals, PointLight, procedural};
//! use shadowmap::{Bias, ExactShadowMap, MapSurface, draw_maps};
//!
//! // a sphere of 1 m about (0, 1, 0), lit from above
//! let scene = procedural::generate("sphere")?;
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(50.0))?)];
//! let maps = draw_maps(&lights, &scene, 256)?;
//! let shadows = ExactShadowMap::new(&maps, &lights, MapSurface::Linear, Bias::NONE)?;
//!
//! // a view ray that passes below the sphere
//! let ray = DRay { origin: DVec3::new(-6.0, -1.0, 0.0), direction: DVec3::X };
//! let mut lit = Vec::new();
//! shadows.lit_intervals(&ray, Interval::new(0.0, 12.0), LightId(0), &mut lit);
//! // light, the sphere's shadow, light
//! assert_eq!(lit.len(), 2);
//! let half = 0.5 * (lit[1].start - lit[0].end);
//! assert!((half - 5.0 / 8_f64.sqrt()).abs() < 0.02, "half of the shadow is {half} m long");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Projections
//!
//! | light | projection | covers | outside |
//! | --- | --- | --- | --- |
//! | spot | perspective | the square around the outer cone, as its texture does | dark: the cone ends inside |
//! | directional | orthographic | the scene's bounds and a ring of texels around them | lit: nothing is there |
//! | point | cube: +X, −X, +Y, −Y, +Z, −Z, oriented as cube textures are | everything | – |
//!
//! [`DepthMap::with_outside`] changes the last column. A spot's map that is read in the linear meaning is drawn a texel
//! wider ([`Projection::of_light_for`], [`draw_maps_for`]), so that it encloses the whole cone.
//!
//! # Conventions
//!
//! | code | meaning | unit |
//! | --- | --- | --- |
//! | `depth` | planar: along the face's axis, from the light or the orthographic plane; +∞ where nothing stops light | m |
//! | `u`, `v` | columns from the left, rows from the top; texel centres at +0.5 | texels |
//! | `size` | (columns, rows) | texels |
//! | `bias` | added to stored depths before a point is compared with them | m |
//! | `Interval` | distances from the ray's origin | m |
//!
//! Depth is planar, not radial, because a plane in the world is then linear over the texels: 1/z in perspective, z in
//! orthographic. Everything that the traversal needs to know along a ray is the root of a linear function.
//!
//! A point is lit if its depth is *at most* the stored one. Depths are stored in `f32` and computed with in `f64`.
//!
//! # Accuracy
//!
//! The traversal differs from dense lookups on the same map by no more than their step (`tests/traversal.rs`), and the
//! hierarchical from the flat walk by rounding. What a map of n texels misses of the scene falls with n
//! (`tests/convergence.rs`).
//!
//! # Features
//!
//! `parallel` (default) draws on all cores with rayon.

mod bias;
mod cells;
mod cube;
mod depth_map;
mod encoding;
mod error;
mod exact;
mod face;
mod linear;
mod lookup;
mod matrix;
mod pieces;
mod projection;
mod pyramid;
mod raster;
mod seams;
mod traversal;
mod variance;
mod visibility;
mod walk;

pub use bias::Bias;
pub use depth_map::{DepthMap, Outside};
pub use encoding::{DepthEncoding, DepthOrder};
pub use error::ShadowMapError;
pub use exact::ExactShadowMap;
pub use face::{Face, MapPoint};
pub use lookup::{Filter, Kernel, MAX_KERNEL};
pub use projection::{DEFAULT_NEAR, Projection, ProjectionKind};
pub use pyramid::MinMaxPyramid;
pub use raster::{draw_maps, draw_maps_for};
pub use traversal::{MapSurface, MapTraversal};
pub use variance::{MAX_BLUR, VarianceMap};
pub use visibility::{MapVisibility, SurfaceVisibility, VarianceVisibility};

/// Most texels along a side of a map.
pub const MAX_SIDE: u32 = 16_384;
