//! Evaluates the airlight integral on the GPU over arrays of problems: for tests, and for `eval`.
//!
//! Twin of `shaders/probe/airlight.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::checked::{check_size, created, filled_buffer, prepared, read_buffer};
use crate::{CreateError, GpuContext, GpuError, PrepareError, shader};

const PASS: &str = "probe/airlight";

/// Threads of a workgroup, as in the shader.
const WORKGROUP: u32 = 64;

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
pub struct AirlightProbe<'a> {
    gpu: &'a GpuContext,
    pipeline: wgpu::ComputePipeline,
}

impl<'a> AirlightProbe<'a> {
    /// Compiles the probe.
    ///
    /// # Errors
    /// [`CreateError`] if the shader does not compile on this device.
    pub fn new(gpu: &'a GpuContext) -> Result<Self, CreateError> {
        let source = shader::assemble(PASS)?;
        let pipeline = created(&gpu.device, PASS, || {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(PASS),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(PASS),
                layout: None,
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        })?;
        Ok(Self { gpu, pipeline })
    }

    /// Airlight of each problem over its lit intervals ([x₀, x₁] in m); units: W/(m²·sr).
    ///
    /// Relative error at most 2·10⁻⁵·max(1, τ/20) with τ = σ_t(x₀ + d₀) where the result is a normal number; subnormal
    /// results may come back as 0.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`] if the arrays exceed the device's limits, [`GpuError`] if wgpu refuses the work or the
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
        let size = (size_of::<f32>() * problems.len()) as u64;
        for (what, needed) in [
            ("the problems' buffer", size_of_val(packed.as_slice()) as u64),
            ("the intervals' buffer", size_of_val(intervals.as_slice()) as u64),
        ] {
            check_size(&self.gpu.device, what, needed)?;
        }
        let groups = (problems.len() as u32).div_ceil(WORKGROUP);
        let most = self.gpu.device.limits().max_compute_workgroups_per_dimension;
        if groups > most {
            let (needed, limit) = (u64::from(groups), u64::from(most));
            return Err(
                PrepareError::TooLarge { what: "the dispatch", needed, limit, unit: "workgroups" }.into()
            );
        }
        let device = &self.gpu.device;
        let readback = prepared(device, PASS, || {
            let storage =
                |label, contents: &[u8]| filled_buffer(device, label, contents, wgpu::BufferUsages::STORAGE);
            let buffer = |label, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let inputs = storage("probe problems", bytemuck::cast_slice(&packed));
            let lit = storage("probe intervals", bytemuck::cast_slice(&intervals));
            let results = buffer("probe results", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
            let readback =
                buffer("probe readback", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
            let entries = [&inputs, &lit, &results].map(wgpu::Buffer::as_entire_binding);
            let mut binding = 0..;
            let entries = entries
                .map(|resource| wgpu::BindGroupEntry { binding: binding.next().unwrap_or(0), resource });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(PASS),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            let mut encoder =
                device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(PASS) });
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(PASS),
                    timestamp_writes: None,
                });
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(groups, 1, 1);
            }
            encoder.copy_buffer_to_buffer(&results, 0, &readback, 0, size);
            self.gpu.queue.submit([encoder.finish()]);
            readback
        })?;
        Ok(read_buffer(device, &readback, size, PASS)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let text = shader::assemble(PASS).unwrap();
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, 1, 1]);
        let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Problem")).unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("Problem is a struct") };
        assert_eq!(*span as usize, size_of::<GpuProblem>());
        let offsets: Vec<(&str, u32)> =
            members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset)).collect();
        let of = |field: usize| field as u32;
        let expected = [
            ("sigma_s", of(std::mem::offset_of!(GpuProblem, sigma_s))),
            ("sigma_t", of(std::mem::offset_of!(GpuProblem, sigma_t))),
            ("intensity", of(std::mem::offset_of!(GpuProblem, intensity))),
            ("x_foot", of(std::mem::offset_of!(GpuProblem, x_foot))),
            ("h", of(std::mem::offset_of!(GpuProblem, h))),
            ("g", of(std::mem::offset_of!(GpuProblem, g))),
            ("first", of(std::mem::offset_of!(GpuProblem, first))),
            ("count", of(std::mem::offset_of!(GpuProblem, count))),
        ];
        assert_eq!(offsets, expected);
    }
}
