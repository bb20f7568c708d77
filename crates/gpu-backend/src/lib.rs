//! Volumetric shadows on wgpu.
//!
//! Two ways in. A renderer that has its own device adds fog in four calls: [`Fog::new`], then for every frame
//! [`Fog::prepare`], [`Fog::encode`] and [`Fog::composite`]; it hands over its depth buffer and its shadow maps with a type
//! that names their convention. `examples/host` is such a renderer, and `docs/guide-wgpu.md` goes through it step by step.
//! What such a renderer brings is here for one that does not: [`DepthDrawer`] draws depth, [`Surfaces`] lights what a view
//! sees. Without a renderer, [`GpuContext::headless`] opens a device and [`Fog::read_airlight`] gives the picture. Shadow
//! rays through a hierarchy are traced by [`GpuBvh`] and [`OcclusionProbe`].
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Fog, FogDescriptor, Frame, GpuContext, Lamp, Sampling, SceneDepth, Technique, View};
//! use scene::{AirlightModel, Camera, Light, Medium, PointLight};
//! use shadowmap::MapSurface;
//!
//! let Ok(gpu) = GpuContext::headless(None) else { return Ok(()) }; // no adapter
//! let mut fog = Fog::new(&gpu.device, &FogDescriptor::default())?;
//! let camera = Camera::look_at(Vec3::new(0.0, 1.0, 6.0), Vec3::ZERO, Vec3::Y, 0.8)?;
//! let light = Light::Point(PointLight::new(Vec3::new(1.0, 2.0, 0.0), Vec3::splat(50.0))?);
//! let view = View { camera: &camera, size: (64, 48), depth: SceneDepth::Nothing, max_distance: f64::INFINITY };
//! fog.prepare(&gpu.device, &gpu.queue, &Frame {
//!     views: &[view],
//!     medium: &Medium::homogeneous([0.05; 3], [0.01; 3])?,
//!     lamps: &[Lamp { light: &light, shadows: None, volume: None }],
//!     model: AirlightModel::Sun,
//!     technique: Technique::ExactShadowMap { surface: MapSurface::Step },
//!     sampling: Sampling::Pixels,
//! })?;
//! let mut encoder = gpu.device.create_command_encoder(&Default::default());
//! fog.encode(&mut encoder);
//! gpu.queue.submit([encoder.finish()]);
//! let radiance = fog.read_airlight(&gpu.device, &gpu.queue, 0)?;
//! assert!((radiance[24 * 64 + 32][0] - 0.132252).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! Only core WebGPU features and limits are required ([`required_features`], [`required_limits`]); what more is used
//! where a device has it is in [`optional_features`], and [`Capabilities`] says which path a device gets. Nothing here
//! panics on a missing adapter, a lost device or a texture that is too large: each stage has its own error type.
//! Results are radiance in W/(m²·sr), linear, three channels, row 0 at the top.

mod bvh;
mod capabilities;
mod checked;
mod context;
mod draw;
mod error;
mod fog;
mod froxel;
mod layout;
mod lightvolume;
mod map;
mod pass;
mod pipelines;
pub mod planner;
mod probe;
mod read_radiance;
pub mod shader;
mod stats;
mod surfaces;
mod timing;
mod volume;
mod write_texture;

pub use bvh::{GpuBvh, OcclusionProbe, ShadowRay, Traced};
pub use capabilities::{Capabilities, optional_features, required_features, required_limits};
pub use context::{DeviceFeatures, GpuContext, software_or_hardware};
pub use draw::{DepthDrawer, DrawnDepth, DrawnMap, Triangles};
pub use error::{ContextError, CreateError, GpuError, PrepareError, ReadError};
pub use fog::{
    Adaptive, AirlightForm, CompositeTarget, Fog, FogDescriptor, Frame, Hybrid, Lamp, LightPicture, Lookup,
    MAX_LIGHTS, Placement, Sampling, SceneDepth, Shadows, Technique, View,
};
pub use lightvolume::{Criterion, DEFAULT_MOST_LEAVES, LeafCount, LightMesh, Tessellation};
pub use map::{HostDepth, ShadowMap};
pub use pipelines::Pipelines;
pub use probe::{AirlightProbe, Problem, SunProbe, SunProblem};
pub use stats::{FrameStats, PassTime};
pub use surfaces::{SurfaceFrame, SurfaceTriangle, SurfaceTriangles, Surfaces, VisibleSurfaces};
pub use volume::{Faces, ShadowCasters, ShadowVolume};
pub use wgpu;
