//! Shared functions of the shaders, evaluated over arrays.

mod airlight;
mod special;

pub use airlight::{AirlightProbe, Problem};
pub use special::{SunProbe, SunProblem};

use crate::checked::{check_size, filled_buffer, prepared, read_buffer};
use crate::pass::probe_pipeline;
use crate::{CreateError, GpuContext, GpuError, PrepareError};

/// Threads of a workgroup, as in the shaders.
const WORKGROUP: u32 = 64;

/// A shader that reads storage buffers and writes one number a thread to the last.
#[derive(Debug)]
struct ArrayPass<'a> {
    gpu: &'a GpuContext,
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
}

impl<'a> ArrayPass<'a> {
    fn new(gpu: &'a GpuContext, name: &'static str) -> Result<Self, CreateError> {
        let pipeline = probe_pipeline(&gpu.device, name)?;
        Ok(Self { gpu, name, pipeline })
    }

    /// Runs `count` threads over the inputs, none of which may be empty unless `count` is 0.
    fn run(&self, inputs: &[(&'static str, &[u8])], count: usize) -> Result<Vec<f32>, GpuError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let device = &self.gpu.device;
        for (what, bytes) in inputs {
            check_size(device, what, bytes.len() as u64)?;
        }
        let groups = (count as u32).div_ceil(WORKGROUP);
        let most = device.limits().max_compute_workgroups_per_dimension;
        if groups > most {
            let (needed, limit) = (u64::from(groups), u64::from(most));
            return Err(
                PrepareError::TooLarge { what: "the dispatch", needed, limit, unit: "workgroups" }.into()
            );
        }
        let size = (size_of::<f32>() * count) as u64;
        let readback = prepared(device, self.name, || {
            let buffer = |label, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let results = buffer("probe results", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
            let readback =
                buffer("probe readback", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
            let mut buffers: Vec<wgpu::Buffer> = inputs
                .iter()
                .map(|(what, contents)| filled_buffer(device, what, contents, wgpu::BufferUsages::STORAGE))
                .collect();
            buffers.push(results.clone());
            let entries: Vec<_> = buffers
                .iter()
                .zip(0..)
                .map(|(buffer, binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(self.name),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            let mut encoder =
                device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(self.name) });
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(self.name),
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
        Ok(read_buffer(device, &readback, size, self.name)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{offsets, wgsl_struct};

    #[test]
    fn threads_and_structs_are_those_of_the_shaders() {
        for pass in ["probe/airlight", "probe/special"] {
            let module = naga::front::wgsl::parse_str(&crate::shader::assemble(pass).unwrap()).unwrap();
            assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, 1, 1], "{pass}");
        }
        let (fields, span) = wgsl_struct("probe/special", "Problem");
        assert_eq!(span as usize, size_of::<SunProblem>());
        assert_eq!(fields, offsets!(SunProblem: u, v0, v1, _pad));
    }
}
