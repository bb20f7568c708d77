//! Frames of froxel fog on a GPU.

use std::time::Instant;

use froxel_grid::{Counts, Froxels};
use glam::Vec3;
use gpu_backend::{
    Fog, FogDescriptor, Frame, GpuBvh, GpuContext, Lamp, PrepareError, Sampling, SceneDepth, Shadows,
    Technique, View, wgpu,
};
use scene::{Scene, WideBvh};

use super::engine::{Eye, FrameTime, World};
use super::wrong;
use crate::failure::{Failure, Outcome};
use crate::gpu;

/// Froxel fog of a GPU with its last frame.
pub(crate) struct GpuFroxels<'g> {
    gpu: &'g GpuContext,
    fog: Fog,
    froxels: Froxels,
}

/// What shadow rays go through.
///
/// Fails for a scene with more triangles than a GPU can hold.
pub(crate) fn hierarchy(gpu: &GpuContext, scene: &Scene) -> Outcome<GpuBvh> {
    let wide = WideBvh::build(scene).map_err(Failure::input)?;
    GpuBvh::upload(&gpu.device, &wide).map_err(Failure::input)
}

impl<'g> GpuFroxels<'g> {
    pub(super) fn new(gpu: &'g GpuContext, froxels: Froxels) -> Outcome<Self> {
        let descriptor = FogDescriptor { pipelines: Some(&gpu.pipelines), ..FogDescriptor::default() };
        let fog = Fog::new(&gpu.device, &descriptor).map_err(Failure::program)?;
        Ok(Self { gpu, fog, froxels })
    }

    pub(super) fn frame(
        &mut self,
        world: &World<'_>,
        eyes: &[Eye<'_>],
        size: (u32, u32),
    ) -> Outcome<FrameTime> {
        let GpuContext { device, queue, .. } = self.gpu;
        let shadows = world.casters.and_then(|casters| {
            let bvh = casters.on_gpu?;
            Some(Shadows::Rays { bvh, casters: casters.bvh.bounds() })
        });
        let lamps: Vec<Lamp<'_>> =
            world.lights.iter().map(|light| Lamp { light, shadows, volume: None }).collect();
        let max_distance = self.froxels.range.into();
        let views: Vec<View<'_>> = eyes
            .iter()
            .map(|eye| View {
                camera: eye.camera,
                size,
                depth: SceneDepth::Distances(eye.ends),
                max_distance,
            })
            .collect();
        let frame = Frame {
            views: &views,
            medium: world.medium,
            lamps: &lamps,
            model: world.model,
            technique: Technique::Froxels(self.froxels),
            sampling: Sampling::Pixels,
        };
        self.fog.prepare(device, queue, &frame).map_err(|error| match error {
            PrepareError::Froxels(error) => wrong(&error),
            other => Failure::input(other),
        })?;
        // uploads are no part of the frame
        queue.submit([]);
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
        let started = Instant::now();
        let mut encoder = device.create_command_encoder(&Default::default());
        self.fog.encode(&mut encoder);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
        let wall = started.elapsed().as_secs_f64() * 1e3;
        let passes = self.fog.pass_times(device, queue).map_err(Failure::program)?;
        let stamped = passes.iter().map(|pass| pass.ms).sum::<Option<f64>>().filter(|_| !passes.is_empty());
        Ok(FrameTime { ms: stamped.filter(|_| gpu::is_hardware(self.gpu)).unwrap_or(wall), passes })
    }

    pub(super) fn forget(&mut self) {
        self.fog.forget();
    }

    pub(super) fn counts(&self) -> Outcome<Counts> {
        self.fog.read_froxel_counts(&self.gpu.device, &self.gpu.queue).map_err(Failure::program)
    }

    pub(super) fn picture(&self, viewer: usize) -> Outcome<Vec<Vec3>> {
        let pixels =
            self.fog.read_airlight(&self.gpu.device, &self.gpu.queue, viewer).map_err(Failure::program)?;
        Ok(pixels.into_iter().map(Vec3::from).collect())
    }

    pub(super) fn bytes(&self) -> u64 {
        self.fog.stats().bytes
    }
}
