//! Polygonal light volumes, after Billeter, Sintorn and Assarsson, *Real Time Volumetric Shadows using Polygonal Light
//! Volumes*, 2010 (BSA10).
//!
//! A shadow map encloses the space that its light reaches. [`LightVolume::build`] makes that space a closed mesh, for any
//! host that can draw triangles; airlight is then one term for each triangle that a view ray crosses, in any order
//! ([`SignedAirlight`]), or the integral over the pieces between the crossings in their order ([`LightVolumes`]).
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use lightvolume::{Criterion, LightVolume, LightVolumes, Options, Tessellation};
//! use scene::{DRay, Interval, Light, LightId, LitIntervals, PointLight, procedural};
//! use shadowmap::draw_maps;
//!
//! // a sphere of 1 m about (0, 1, 0), lit from above
//! let scene = procedural::generate("sphere")?;
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(50.0))?)];
//! let maps = draw_maps(&lights, &scene, 128)?;
//! let Some(map) = &maps[0] else { return Ok(()) };
//!
//! // no more triangles than keep the surface within a centimetre
//! let tessellation = Tessellation::Adaptive { criterion: Criterion::Distance, threshold: 0.01 };
//! let volume = LightVolume::build(map, &Options::new(tessellation))?;
//! volume.validate()?;
//! let cells = LightVolume::build(map, &Options::default())?;
//! assert!(4 * volume.triangles().len() < cells.triangles().len());
//!
//! // a view ray that passes below the sphere: light, the sphere's shadow, light
//! let volumes = [Some(volume)];
//! let shadows = LightVolumes::new(&volumes, &lights)?;
//! let ray = DRay { origin: DVec3::new(-6.0, -1.0, 0.0), direction: DVec3::X };
//! let mut lit = Vec::new();
//! shadows.lit_intervals(&ray, Interval::new(0.0, 12.0), LightId(0), &mut lit);
//! assert_eq!(lit.len(), 2);
//! let half = 0.5 * (lit[1].start - lit[0].end);
//! assert!((half - 5.0 / 8_f64.sqrt()).abs() < 0.05, "half of the shadow is {half} m long");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # From a map to a mesh
//!
//! | step | file | in the paper |
//! | --- | --- | --- |
//! | texel centres, moved to their depth, are the nodes of a surface | `nodes.rs` | §4, Fig. 4a–c |
//! | two triangles a cell ([`Tessellation::Static`]) | `builder.rs` | §4, Fig. 4c |
//! | an edge map, or a bound on the distance, for every quad of a quadtree | `edge_map.rs`, `distance.rs` | §4.1 |
//! | split flags, balanced: neighbours differ by one level | `hierarchy.rs` | §4.1 |
//! | sixteen ways to cut a leaf ([`STITCHES`]) | `stitch.rs` | §4.1 |
//! | walls to the light, seams between a cube's faces, skirts and a cap | `closure.rs` | §4, Fig. 4d |
//! | or Delaunay triangles of the nodes that matter most | `delaunay.rs` | – |
//! | crossings of a view ray, with their signs | `line.rs`, `ray_index.rs` | §3, Eq. 3 |
//!
//! # Conventions
//!
//! | code | meaning | unit |
//! | --- | --- | --- |
//! | `x`, `y` | column and row of a node: texel centres have integers | texels |
//! | `height` | linear over triangles, more is nearer to the light: 1/depth, or −depth without perspective | m⁻¹ or m |
//! | `depth` | planar, along the face's axis, as in [`shadowmap`] | m |
//! | `threshold`, `bound` | planar depth by which the surface may be off | m |
//! | sign | +1 where a ray leaves light, −1 where it enters it | – |
//!
//! # Watertight
//!
//! [`LightVolume::validate`] says whether a mesh is closed, oriented and conforming, and where it is not. Rays cross it by
//! questions that both triangles of an edge answer alike, so that the signs of a line's crossings sum to exactly 0 whatever
//! is rounded (`line.rs`). Crossings of a static volume are the lit pieces of
//! [`ExactShadowMap`](shadowmap::ExactShadowMap) in the linear meaning (`tests/crossings.rs`).
//!
//! # Deviations
//!
//! - What the paper calls a directional light is a spot here. A light at infinity reaches everything around its map, so
//!   that its volume encloses the shadow, down to a far plane, and the light of the whole ray is added.
//! - The far plane is not needed in perspective: infinite depths are points at infinity.
//! - The paper does not say how a Laplacian is compared; here it is in metres. It bounds nothing, not even at threshold 0,
//!   where it takes a saddle for a plane. [`Criterion::Distance`] is a bound.
//! - Crossings behind the end of a ray are not clamped to it one by one: they cancel but for one, which is added.

mod builder;
mod closure;
mod delaunay;
mod distance;
mod edge_map;
mod error;
mod hierarchy;
mod intervals;
mod lamp;
mod lights;
mod line;
mod nodes;
mod options;
mod quads;
mod ray_index;
mod signed;
mod stitch;
mod validate;
mod vertex;
mod volume;

pub use builder::Leaf;
pub use error::LightVolumeError;
pub use lights::LightVolumes;
pub use options::{Criterion, Options, Tessellation};
pub use ray_index::RayIndex;
pub use signed::{Anchor, SignedAirlight};
pub use stitch::{PLACES, STITCHES, Stitch};
pub use validate::{Defect, Place};
pub use vertex::{Vertex, VertexKind};
pub use volume::LightVolume;
