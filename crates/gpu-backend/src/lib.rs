//! Volumetric shadows on wgpu.
//!
//! So far the crate holds the ground that passes will stand on: a headless device ([`GpuContext`]), the shader library
//! with its imports ([`shader`]), the airlight integral in WGSL with a probe that evaluates it over arrays
//! ([`AirlightProbe`]), and shadow rays through a hierarchy on the GPU ([`GpuBvh`], [`OcclusionProbe`]).
//!
//! ```no_run
//! use gpu_backend::{AirlightProbe, GpuContext, Problem};
//!
//! let gpu = GpuContext::headless(None)?;
//! let probe = AirlightProbe::new(&gpu)?;
//! let problem = Problem { sigma_s: 0.05, sigma_t: 0.07, intensity: 100.0, x_foot: 3.0, h: 4.0, g: 0.0 };
//! let radiance = probe.evaluate(&[(problem, vec![[1.0, 8.0]])])?;
//! assert!(radiance[0] > 0.0);
//! # Ok::<(), gpu_backend::GpuError>(())
//! ```
//!
//! # Conventions
//!
//! Only core WebGPU features and limits are asked for. Nothing here panics on a missing adapter, a lost device or a
//! buffer that is too large: those are [`GpuError`]s.

mod bvh;
mod context;
mod error;
mod guarded;
mod probe;
pub mod shader;

pub use bvh::{GpuBvh, OcclusionProbe, ShadowRay, Traced};
pub use context::{GpuContext, software_or_hardware};
pub use error::GpuError;
pub use probe::{AirlightProbe, Problem};
pub use wgpu;
