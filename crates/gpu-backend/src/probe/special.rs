//! Evaluates Sun et al.'s F on the GPU over arrays: for tests, and for `eval`.
//!
//! Twin of `shaders/probe/special.wgsl`.

use bytemuck::{Pod, Zeroable};

use super::ArrayPass;
use crate::{CreateError, GpuContext, GpuError};

const PASS: &str = "probe/special";

/// An interval of F's integral: ∫ e^(−u tan ξ) dξ from `v0` to `v1`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SunProblem {
    /// Optical thickness at the foot, ≥ 0.
    pub u: f32,
    /// Lower end; units: rad, in [0, π/2].
    pub v0: f32,
    /// Upper end; units: rad, in [0, π/2].
    pub v1: f32,
    /// Not read.
    pub _pad: f32,
}

/// The compiled probe.
#[derive(Debug)]
pub struct SunProbe<'a>(ArrayPass<'a>);

impl<'a> SunProbe<'a> {
    /// Compiles the probe.
    ///
    /// # Errors
    /// [`CreateError`] if the shader does not compile on this device.
    pub fn new(gpu: &'a GpuContext) -> Result<Self, CreateError> {
        ArrayPass::new(gpu, PASS).map(Self)
    }

    /// F over each interval.
    ///
    /// # Errors
    /// As [`AirlightProbe::evaluate`](crate::AirlightProbe::evaluate).
    pub fn evaluate(&self, problems: &[SunProblem]) -> Result<Vec<f32>, GpuError> {
        self.0.run(&[("the problems' buffer", bytemuck::cast_slice(problems))], problems.len())
    }
}
