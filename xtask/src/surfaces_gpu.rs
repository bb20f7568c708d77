//! The surfaces of a picture on the GPU: the same stage as on the CPU, from the same view rays.

use std::time::Instant;

use glam::Vec3;
use gpu_backend::{
    GpuBvh, GpuContext, Lamp, Shadows, SurfaceFrame, SurfaceTriangle, SurfaceTriangles, Surfaces,
    VisibleSurfaces, wgpu,
};
use scene::{Bvh, WideBvh};

use crate::failure::{Failure, Outcome};
use crate::gpu;
use crate::scene_args::Setup;
use crate::surfaces::Lit;
use crate::view_rays::ViewRays;

/// Lights what the view rays hit. The time is that of the second of two renderings, since the first also compiles: the
/// GPU's own clock where it is one of hardware, else the wall clock; uploads are excluded.
///
/// Fails if the device cannot hold it.
pub(crate) fn run(
    gpu: &GpuContext,
    setup: &Setup,
    bvh: &Bvh,
    rays: &ViewRays,
    size: (u32, u32),
) -> Outcome<Lit> {
    let GpuContext { device, queue, .. } = gpu;
    let wide = WideBvh::build(&setup.scene).map_err(Failure::input)?;
    let hierarchy = GpuBvh::upload(device, &wide).map_err(Failure::input)?;
    let triangles = SurfaceTriangle::of_scene(bvh.triangles(), &setup.scene.materials);
    let triangles = SurfaceTriangles::upload(device, &triangles).map_err(Failure::input)?;
    let shadows = Shadows::Rays { bvh: &hierarchy, casters: bvh.bounds() };
    let casts = !bvh.triangles().is_empty();
    let lamps: Vec<Lamp<'_>> = setup
        .lights
        .iter()
        .map(|light| Lamp { light, shadows: casts.then_some(shadows), volume: None })
        .collect();
    let frame = SurfaceFrame {
        camera: &setup.camera,
        size,
        visible: VisibleSurfaces { distances: &rays.ends, triangles: &rays.triangles },
        triangles: &triangles,
        medium: &setup.medium,
        lamps: &lamps,
    };
    let mut surfaces = Surfaces::new(device).map_err(Failure::program)?;
    surfaces.prepare(device, queue, &frame).map_err(Failure::input)?;
    render(gpu, &mut surfaces)?;
    let ms = render(gpu, &mut surfaces)?;
    let radiance = surfaces.read(device, queue).map_err(Failure::program)?;
    Ok(Lit { radiance: radiance.into_iter().map(|pixel| Vec3::from(pixel).as_dvec3()).collect(), ms })
}

/// Time of one rendering of a prepared frame; units: ms.
fn render(gpu: &GpuContext, surfaces: &mut Surfaces) -> Outcome<f64> {
    let GpuContext { device, queue, .. } = gpu;
    // uploads are no part of the frame
    queue.submit([]);
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
    let started = Instant::now();
    let mut encoder = device.create_command_encoder(&Default::default());
    surfaces.encode(&mut encoder);
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
    let wall = started.elapsed().as_secs_f64() * 1e3;
    let passes = surfaces.pass_times(device, queue).map_err(Failure::program)?;
    let stamped = passes.iter().map(|pass| pass.ms).sum::<Option<f64>>().filter(|_| !passes.is_empty());
    Ok(stamped.filter(|_| gpu::is_hardware(gpu)).unwrap_or(wall))
}
