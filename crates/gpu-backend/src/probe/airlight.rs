//! Evaluates the airlight integral on the GPU over arrays of problems: for tests, and for `eval`.
//!
//! Twin of `shaders/probe/airlight.wgsl`.

use bytemuck::{Pod, Zeroable};

use super::ArrayPass;
use crate::{CreateError, GpuContext, GpuError};

const PASS: &str = "probe/airlight";

/// A light, a medium and a view ray; one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Problem {
    /// Scattering coefficient; units: m⁻¹.
    pub sigma_s: f32,
    /// Extinction coefficient; units: m⁻¹.
    pub sigma_t: f32,
    /// Radiant intensity; units: W/sr.
    pub intensity: f32,
    /// Distance along the ray of the point nearest to the light; units: m.
    pub x_foot: f32,
    /// Distance of the light from the ray's line; units: m.
    pub h: f32,
    /// Henyey-Greenstein asymmetry in (−1, 1); 0 is isotropic.
    pub g: f32,
}

/// [`Problem`] as the shader reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuProblem {
    sigma_s: f32,
    sigma_t: f32,
    intensity: f32,
    x_foot: f32,
    h: f32,
    g: f32,
    first: u32,
    count: u32,
}

/// The compiled probe.
#[derive(Debug)]
pub struct AirlightProbe<'a>(ArrayPass<'a>);

impl<'a> AirlightProbe<'a> {
    /// Compiles the probe.
    ///
    /// # Errors
    /// [`CreateError`] if the shader does not compile on this device.
    pub fn new(gpu: &'a GpuContext) -> Result<Self, CreateError> {
        ArrayPass::new(gpu, PASS).map(Self)
    }

    /// Airlight of each problem over its lit intervals ([x₀, x₁] in m); units: W/(m²·sr).
    ///
    /// Relative error at most 2·10⁻⁵·max(1, τ/20) with τ = σ_t(x₀ + d₀) where the result is a normal number; subnormal
    /// results may come back as 0.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`](crate::PrepareError::TooLarge) if the arrays exceed the device's limits, [`GpuError`] if wgpu refuses the work or the
    /// device is lost.
    pub fn evaluate(&self, problems: &[(Problem, Vec<[f32; 2]>)]) -> Result<Vec<f32>, GpuError> {
        if problems.is_empty() {
            return Ok(Vec::new());
        }
        let mut intervals: Vec<[f32; 2]> = Vec::new();
        let mut packed = Vec::with_capacity(problems.len());
        for (p, lit) in problems {
            let first = intervals.len() as u32;
            intervals.extend(lit);
            let Problem { sigma_s, sigma_t, intensity, x_foot, h, g } = *p;
            packed.push(GpuProblem {
                sigma_s,
                sigma_t,
                intensity,
                x_foot,
                h,
                g,
                first,
                count: lit.len() as u32,
            });
        }
        if intervals.is_empty() {
            // a binding has to hold something
            intervals.push([0.0; 2]);
        }
        self.0.run(
            &[
                ("the problems' buffer", bytemuck::cast_slice(&packed)),
                ("the intervals' buffer", bytemuck::cast_slice(&intervals)),
            ],
            problems.len(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let (fields, span) = wgsl_struct(PASS, "Problem");
        assert_eq!(span as usize, size_of::<GpuProblem>());
        let ours = offsets!(GpuProblem: sigma_s, sigma_t, intensity, x_foot, h, g, first, count);
        assert_eq!(fields, ours);
    }
}
