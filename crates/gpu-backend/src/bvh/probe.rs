//! Shadow rays over arrays on the GPU: for tests, and to measure rays per second.
//!
//! Twin of `shaders/probe/occlusion.wgsl`.

use std::time::{Duration, Instant};

use bytemuck::{Pod, Zeroable};

use super::GpuBvh;
use crate::checked::{prepared, read_buffer};
use crate::pass::probe_pipeline;
use crate::{CreateError, GpuContext, GpuError};

const PASS: &str = "probe/occlusion";

/// Threads of a workgroup, as in the shader.
const WORKGROUP: u32 = 64;

/// Most rays of one dispatch: 32 MiB of rays, and a time that no watchdog minds.
const RAYS_PER_DISPATCH: u64 = 1 << 20;

/// Time stamps of a dispatch: before it and after; units: ticks of the queue.
const STAMPS: u64 = size_of::<[u64; 2]>() as u64;

/// A ray that asks whether something lies between its origin and `origin` + `far`·`direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowRay {
    /// Where the ray starts; units: m.
    pub origin: [f32; 3],
    /// Where it goes, of any length; units: m.
    pub direction: [f32; 3],
    /// Its end, in lengths of the direction: 1 if the direction is the way to a point light. An infinite one is taken
    /// as the largest finite number.
    pub far: f32,
}

/// [`ShadowRay`] as the shader reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuRay {
    origin: [f32; 3],
    far: f32,
    direction: [f32; 3],
    _pad0: f32,
}

impl From<&ShadowRay> for GpuRay {
    fn from(ray: &ShadowRay) -> Self {
        // the shader may assume that there are no infinities
        Self { origin: ray.origin, far: ray.far.min(f32::MAX), direction: ray.direction, _pad0: 0.0 }
    }
}

/// What [`OcclusionProbe::trace`] found out, and how long it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// Whether each ray is blocked.
    pub blocked: Vec<bool>,
    /// Time of the dispatches by the device's own clock; `None` if it has none, or one that stands still.
    pub gpu_time: Option<Duration>,
    /// Time of the call: upload, dispatches and readback.
    pub wall_time: Duration,
}

/// The compiled probe.
#[derive(Debug)]
pub struct OcclusionProbe<'a> {
    gpu: &'a GpuContext,
    pipeline: wgpu::ComputePipeline,
    /// Rays of one dispatch.
    rays_per_dispatch: u64,
}

/// Where a dispatch finds its rays and leaves its results.
struct Buffers {
    rays: wgpu::Buffer,
    results: wgpu::Buffer,
    /// Results, and the time stamps before them.
    readback: wgpu::Buffer,
    /// The stamps, as a query writes them and as they can be copied; `None` without the feature.
    stamps: Option<(wgpu::QuerySet, wgpu::Buffer)>,
}

impl<'a> OcclusionProbe<'a> {
    /// Compiles the probe.
    ///
    /// # Errors
    /// [`CreateError`] if the shader does not compile on this device.
    pub fn new(gpu: &'a GpuContext) -> Result<Self, CreateError> {
        let pipeline = probe_pipeline(&gpu.device, PASS)?;
        let limits = gpu.device.limits();
        let by_binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size - STAMPS)
            / size_of::<GpuRay>() as u64;
        let by_groups = u64::from(limits.max_compute_workgroups_per_dimension) * u64::from(WORKGROUP);
        Ok(Self { gpu, pipeline, rays_per_dispatch: RAYS_PER_DISPATCH.min(by_binding).min(by_groups) })
    }

    /// Whether each ray is blocked, in as many dispatches as the device's limits ask for.
    ///
    /// The answers are those of [`scene::Bvh::blocked`] but for rays that pass an edge, or end at a surface, within the
    /// rounding of `f32`. A ray with a coordinate that is not finite gets either answer.
    ///
    /// # Errors
    /// [`GpuError`] if wgpu refuses the work or the device is lost.
    pub fn trace(&self, bvh: &GpuBvh, rays: &[ShadowRay]) -> Result<Traced, GpuError> {
        let start = Instant::now();
        let mut blocked = Vec::with_capacity(rays.len());
        let mut gpu_time = None;
        if !rays.is_empty() {
            let most = self.rays_per_dispatch.min(rays.len() as u64);
            let buffers = prepared(&self.gpu.device, PASS, || self.buffers(most))?;
            let mut ticks = Some(0);
            for part in rays.chunks(most as usize) {
                let packed: Vec<GpuRay> = part.iter().map(GpuRay::from).collect();
                prepared(&self.gpu.device, PASS, || self.dispatch(bvh, &buffers, &packed))?;
                let bytes = STAMPS + 4 * part.len() as u64;
                let words: Vec<u32> = read_buffer(&self.gpu.device, &buffers.readback, bytes, PASS)?;
                let (stamps, results) = words.split_at(STAMPS as usize / 4);
                blocked.extend(results.iter().map(|&result| result != 0));
                ticks = ticks.zip(elapsed(stamps)).map(|(sum, more)| sum + more);
            }
            let period = f64::from(self.gpu.queue.get_timestamp_period());
            gpu_time = ticks.map(|ticks| Duration::from_nanos((ticks as f64 * period) as u64));
        }
        Ok(Traced { blocked, gpu_time, wall_time: start.elapsed() })
    }

    fn buffers(&self, rays: u64) -> Buffers {
        use wgpu::BufferUsages as Usage;
        let device = &self.gpu.device;
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let stamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let set = device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("occlusion stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            (set, buffer("occlusion stamps", STAMPS, Usage::QUERY_RESOLVE | Usage::COPY_SRC))
        });
        let results = 4 * rays;
        Buffers {
            rays: buffer(
                "occlusion rays",
                size_of::<GpuRay>() as u64 * rays,
                Usage::STORAGE | Usage::COPY_DST,
            ),
            results: buffer("occlusion results", results, Usage::STORAGE | Usage::COPY_SRC),
            readback: buffer("occlusion readback", STAMPS + results, Usage::MAP_READ | Usage::COPY_DST),
            stamps,
        }
    }

    /// Submits one dispatch over `rays`, which fit the buffers.
    fn dispatch(&self, bvh: &GpuBvh, buffers: &Buffers, rays: &[GpuRay]) {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        queue.write_buffer(&buffers.rays, 0, bytemuck::cast_slice(rays));
        // only the part in use is bound: its length is how the shader knows where the rays end
        let used = |buffer, bytes| {
            let size = std::num::NonZero::new(bytes);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
        };
        let results = 4 * rays.len() as u64;
        let entries = [
            bvh.nodes().as_entire_binding(),
            bvh.triangles().as_entire_binding(),
            used(&buffers.rays, size_of_val(rays) as u64),
            used(&buffers.results, results),
        ];
        let mut binding = 0..;
        let entries =
            entries.map(|resource| wgpu::BindGroupEntry { binding: binding.next().unwrap_or(0), resource });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(PASS),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(PASS) });
        let timestamp_writes = buffers.stamps.as_ref().map(|(set, _)| wgpu::ComputePassTimestampWrites {
            query_set: set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        });
        {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(PASS), timestamp_writes });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups((rays.len() as u32).div_ceil(WORKGROUP), 1, 1);
        }
        if let Some((set, stamps)) = &buffers.stamps {
            encoder.resolve_query_set(set, 0..2, stamps, 0);
            encoder.copy_buffer_to_buffer(stamps, 0, &buffers.readback, 0, STAMPS);
        }
        encoder.copy_buffer_to_buffer(&buffers.results, 0, &buffers.readback, STAMPS, results);
        queue.submit([encoder.finish()]);
    }
}

/// Ticks between two stamps, low word first; `None` if a stamp is missing or the clock stands still.
fn elapsed(stamps: &[u32]) -> Option<u64> {
    let [a, b, c, d] = *stamps else { return None };
    let stamp = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
    let (before, after) = (stamp(a, b), stamp(c, d));
    (before > 0 && after > before).then(|| after - before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let module = naga::front::wgsl::parse_str(&crate::shader::assemble(PASS).unwrap()).unwrap();
        assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, 1, 1]);
        let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Ray")).unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("Ray is a struct") };
        assert_eq!(*span as usize, size_of::<GpuRay>());
        let offsets: Vec<(&str, usize)> =
            members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset as usize)).collect();
        let expected = [
            ("origin", offset_of!(GpuRay, origin)),
            ("far", offset_of!(GpuRay, far)),
            ("direction", offset_of!(GpuRay, direction)),
            ("_pad0", offset_of!(GpuRay, _pad0)),
        ];
        assert_eq!(offsets, expected);
    }

    #[test]
    fn stamps_that_say_nothing_are_no_time() {
        assert_eq!(elapsed(&[5, 0, 9, 1]), Some((1 << 32) + 4));
        for nothing in [[0, 0, 0, 0], [0, 0, 7, 0], [7, 0, 7, 0], [7, 0, 5, 0]] {
            assert_eq!(elapsed(&nothing), None);
        }
    }
}
