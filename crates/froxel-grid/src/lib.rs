//! Fog in froxels with ray-traced shadows, and shadows shared between viewers, after Stojanovic et al., *Efficient
//! Rendering of Participating Media for Multiple Viewpoints*, HPG 2023 (SWT23), and Hillaire, *Physically Based and
//! Unified Volumetric Rendering in Frostbite*, 2015 (Hil15).
//!
//! A froxel is a voxel of a view: a tile of pixels, a slice of distance. Each gets the light that its medium sends
//! towards the eye, and sums along the ray give the airlight of any pixel by its distance. In the reference every
//! froxel has its own shadow rays; with the shared shadow grid most of them read voxels of the world, traced once for
//! all views.
//!
//! ```
//! use froxel_grid::{Frame, FroxelFog, Froxels, Occluders, SharedGrid, View};
//! use glam::Vec3;
//! use scene::{Aabb, AirlightModel, Camera, Light, LightId, Medium, PointLight, Visibility};
//!
//! /// A square of 2 m at y = 2, below a lamp at y = 4.
//! struct Square;
//! impl Visibility for Square {
//!     fn visibility(&self, point: Vec3, _light: LightId) -> f32 {
//!         let through = point * 2.0 / (4.0 - point.y);
//!         f32::from(point.y >= 2.0 || through.x.abs() >= 1.0 || through.z.abs() >= 1.0)
//!     }
//! }
//! let bounds = Aabb { min: Vec3::new(-1.0, 2.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
//! let occluders = Some(Occluders { visibility: &Square, bounds });
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(10.0))?)];
//! let medium = Medium::homogeneous([0.1; 3], [0.0; 3])?;
//! // two viewers side by side, whose view rays hit nothing
//! let camera = |x| Camera::look_at(Vec3::new(x, 1.0, 6.0), Vec3::Y, Vec3::Y, 0.9);
//! let (left, right, ends) = (camera(-0.1)?, camera(0.1)?, [f32::INFINITY; 64 * 64]);
//! let views = [&left, &right].map(|camera| View { camera, size: (64, 64), ends: &ends });
//! let frame = Frame { views: &views, medium: &medium, lights: &lights, model: AirlightModel::Sun, occluders };
//!
//! let froxels = Froxels { tile: 4, slices: 64, ..Froxels::new(12.0) };
//! let reference = FroxelFog::new(froxels)?.render(&frame)?;
//! let shared = FroxelFog::new(froxels.with_grid(SharedGrid::marked(0.1)))?.render(&frame)?;
//! // the same picture but for the size of a voxel, with far fewer shadow rays
//! let [a, b] = [&reference, &shared].map(|fog| fog.airlight[0][32 * 64 + 32].x);
//! assert!(a > 0.0 && (a / b - 1.0).abs() < 0.05);
//! assert!(3 * shared.counts.rays() < reference.counts.rays());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A frame
//!
//! | stage | file | in the paper |
//! | --- | --- | --- |
//! | froxels before what is seen, and the rays that they need | `reach.rs`, `needs.rs`, `volume.rs` | §4.2 |
//! | 1. shared voxel update: which voxels are traced, and kept where | `grid.rs`, `store.rs`, `strongest.rs` | §3.1.1 |
//! | 2. shadow frustum update: a view's own masks | `near.rs` | §3.1.2 |
//! | 3. lighting from frustum or grid, and history | `light_up.rs`, `lighting.rs`, `history.rs` | §3.1.3, Hil15 |
//! | 4. volume ray march: front to back, and by pixel | `accumulate.rs`, `apply.rs` | §3.1.4, Hil15 |
//!
//! # Choices
//!
//! | you want | take |
//! | --- | --- |
//! | the reference | [`Froxels::new`] |
//! | the paper's scheme | [`SharedGrid::paper`] |
//! | never more rays than the reference | [`SharedGrid::marked`] |
//! | memory that follows what is seen | [`GridMemory::Bricks`] |
//! | smoother voxels | [`GridReads::Trilinear`] |
//! | a finer grid next to viewers (§5.2) | [`Near::FineGrid`] |
//! | less noise and aliasing over frames | [`Temporal`] |
//!
//! # Conventions
//!
//! Points are `f32` up to the masks, by the same operations as on a GPU, so that both trace the same rays; light is
//! summed in `f64`. Froxels and voxels are stored x fastest, then y, then slice or z. Distances are metres along the
//! view ray, never depths.
//!
//! # Deviations
//!
//! - A froxel sees the medium and its lights at its sample; a local light's 1/d² alone is averaged over the slice,
//!   and no nearer than the froxel is wide, so that a light inside a froxel does not blaze.
//! - Trilinear reads interpolate visibility instead of radiance: all else is known at the froxel.
//! - A point outside the casters' box reads the voxel where its way to the light enters the grid: nothing before that
//!   blocks it.
//! - The grid is a voxel wider than the casters' box on every side ([`SharedGrid::bounds`]).
//! - Without [`Temporal`] samples lie in the middles of slices, and every frame stands alone but for alternating
//!   voxels.
//! - As in the paper, [`Update::InFrustums`] traces voxels whose centres are in sight. Froxels at the border of a
//!   picture, and those whose way to a light enters the grid out of sight, read voxels that are not: dark until some
//!   view sees them. [`Update::Marked`] traces whatever is read.
//! - With more lights than a mask has bits, a light that was not chosen is dark in that voxel, and counted
//!   ([`Counts::dropped`]).
//! - Where there is no brick, a froxel is lit, and counted ([`Counts::missed`]).

mod accumulate;
mod apply;
mod counts;
mod error;
mod fog;
mod frame;
mod grid;
mod history;
mod layout;
mod light_up;
mod lighting;
mod lit;
mod memory;
mod near;
mod needs;
mod parallel;
mod reach;
mod settings;
mod store;
mod strongest;
mod volume;
mod voxels;

pub use counts::Counts;
pub use error::FroxelError;
pub use fog::FroxelFog;
pub use frame::{Frame, Occluders, Rendered, View};
pub use layout::{FroxelView, Slices};
pub use lit::Lit;
pub use memory::{dense_bytes, near_bytes};
pub use near::Mask;
pub use settings::{
    BRICK, Froxels, GridMemory, GridReads, MAX_BRICKS, MAX_LIGHTS, MAX_SLICES, MaskWidth, Near, Shadowing,
    SharedGrid, Temporal, Update,
};
pub use voxels::Lattice;
