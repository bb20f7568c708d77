//! What `docs/guide-wgpu.md` shows beside `examples/host`: the guide quotes these lines, `tests/tests/guide.rs` compares.

#![expect(clippy::unwrap_used, reason = "test code")]

mod common;

use std::sync::Arc;

use common::core_gpu;
use glam::Vec3;
use gpu_backend::wgpu;
use gpu_backend::{
    CompositeTarget, CreateError, Fog, FogDescriptor, Frame, GpuContext, HostDepth, Hybrid, Lamp,
    PrepareError, Sampling, SceneDepth, ShadowCasters, ShadowMap, ShadowVolume, Shadows, Technique, View,
    required_limits,
};
use scene::{AirlightModel, Camera, Density, Light, Medium, PointLight, Scene, procedural};
use shadowmap::{Bias, DepthOrder, MapSurface, Projection};

const SIZE: (u32, u32) = (32, 24);
const SIDE: u32 = 16;
const NEAR: f32 = 0.05;

/// Beside a ball on the ground.
fn lamp() -> PointLight {
    PointLight::new(Vec3::new(1.5, 2.5, 1.0), Vec3::splat(20.0)).unwrap()
}

fn cameras() -> [Camera; 2] {
    [Vec3::new(0.0, 1.0, 5.0), Vec3::new(4.0, 1.5, 3.0)]
        .map(|eye| Camera::look_at(eye, Vec3::Y, Vec3::Y, 0.8).unwrap())
}

fn depth_texture(device: &wgpu::Device, (width, height): (u32, u32), layers: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Fills a depth texture as a pass that draws nothing does.
fn clear(gpu: &GpuContext, texture: &wgpu::Texture, value: f32) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for base_array_layer in 0..texture.depth_or_array_layers() {
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(value), store: wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(ops),
                stencil_ops: None,
            }),
            ..Default::default()
        });
    }
    gpu.queue.submit([encoder.finish()]);
}

fn frame<'a>(views: &'a [View<'a>], medium: &'a Medium, lamps: &'a [Lamp<'a>]) -> Frame<'a> {
    Frame {
        views,
        medium,
        lamps,
        model: AirlightModel::Sun,
        technique: Technique::ExactShadowMap { surface: MapSurface::Step },
        sampling: Sampling::Pixels,
    }
}

/// Mean airlight of a view, once the frame is drawn.
fn mean(gpu: &GpuContext, fog: &mut Fog, view: usize) -> f32 {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    fog.encode(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let airlight = fog.read_airlight(&gpu.device, &gpu.queue, view).unwrap();
    airlight.iter().flatten().sum::<f32>() / (3 * airlight.len()) as f32
}

/// A device with the limits that the guide asks for, and fog on it.
async fn opened(adapter: &wgpu::Adapter) -> Result<(wgpu::Device, wgpu::Queue), wgpu::RequestDeviceError> {
    let descriptor = wgpu::DeviceDescriptor {
        required_features: gpu_backend::optional_features() & adapter.features(),
        required_limits: required_limits(),
        ..Default::default()
    };
    adapter.request_device(&descriptor).await
}

#[test]
fn a_device_with_what_the_guide_asks_for_has_fog() {
    if core_gpu().is_none() {
        return;
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let (device, _queue) = pollster::block_on(opened(&adapter)).unwrap();
    assert!(Fog::new(&device, &FogDescriptor::default()).is_ok());
    let target = CompositeTarget::picture(wgpu::TextureFormat::Rgba8Uint);
    let refused = Fog::new(&device, &FogDescriptor { target: Some(target), ..Default::default() });
    assert!(matches!(refused, Err(CreateError::Format(wgpu::TextureFormat::Rgba8Uint))));
}

/// Reversed depth without a far plane, for two views of different sizes; then one of them is resized.
#[test]
fn several_views_with_reversed_depth() {
    let Some(gpu) = core_gpu() else { return };
    let device = &gpu.device;
    let light = Light::Point(lamp());
    let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
    let lamps = [Lamp { light: &light, shadows: None, volume: None }];
    let mut fog = Fog::new(device, &FogDescriptor::default()).unwrap();
    let cameras = cameras();
    for sizes in [[SIZE, (8, 8)], [SIZE, (40, 20)]] {
        let textures = sizes.map(|size| depth_texture(device, size, 1));
        textures.iter().for_each(|texture| clear(&gpu, texture, 0.0));
        let views = [0, 1].map(|index| View {
            camera: &cameras[index],
            size: sizes[index],
            depth: SceneDepth::Buffer {
                texture: &textures[index],
                order: DepthOrder::Reversed,
                near: NEAR,
                far: f32::INFINITY,
            },
            max_distance: 1000.0,
        });
        fog.prepare(device, &gpu.queue, &frame(&views, &medium, &lamps)).unwrap();
        // a view by itself is the same
        let together = [0, 1].map(|view| mean(&gpu, &mut fog, view));
        for (view, mean_of_both) in views.iter().zip(together) {
            fog.prepare(device, &gpu.queue, &frame(&[*view], &medium, &lamps)).unwrap();
            assert_eq!(mean(&gpu, &mut fog, 0), mean_of_both);
            assert!(mean_of_both > 0.0);
        }
    }
}

/// A cube map of a point light, which moves.
#[test]
fn a_cube_map_follows_its_light() {
    let Some(gpu) = core_gpu() else { return };
    let device = &gpu.device;
    let mut light = lamp();
    let cube = depth_texture(device, (SIDE, SIDE), 6);
    // a surface at 0.1 m all around: nearly everything is dark
    let device_depth = 1.0 - NEAR / 0.1;
    clear(&gpu, &cube, device_depth);
    let host = HostDepth { texture: &cube, order: DepthOrder::Forward, near: NEAR, far: f32::INFINITY };
    let mut map = ShadowMap::from_host(device, host, Projection::point(&light).unwrap(), Bias::NONE).unwrap();
    let faces = map.projection().faces();
    // what to draw the six layers with, in the order of cube textures
    let matrices = faces.iter().map(|face| face.clip_from_world(DepthOrder::Forward, NEAR, f32::INFINITY));
    assert_eq!(matrices.filter(Result::is_ok).count(), 6);

    let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
    let casters = procedural::generate("sphere").unwrap().bounds();
    let camera = &cameras()[0];
    let views = [View { camera, size: SIZE, depth: SceneDepth::Nothing, max_distance: f64::INFINITY }];
    let mut fog = Fog::new(device, &FogDescriptor::default()).unwrap();
    let mut airlight = |map: &ShadowMap, light: PointLight| {
        let light = Light::Point(light);
        let shadows = Some(Shadows::Map { map, casters });
        fog.prepare(
            device,
            &gpu.queue,
            &frame(&views, &medium, &[Lamp { light: &light, shadows, volume: None }]),
        )
        .unwrap();
        mean(&gpu, &mut fog, 0)
    };
    let dark = airlight(&map, light);

    // the renderer draws the map again: nothing is in the way any more
    clear(&gpu, &cube, 1.0);
    assert_eq!(airlight(&map, light), dark, "the map is read when it is touched");
    map.touch();
    let lit = airlight(&map, light);
    assert!(lit > 2.0 * dark, "{lit} {dark}");

    light.position.y += 0.5;
    map.update_host(host, Projection::point(&light).unwrap(), Bias::NONE).unwrap();
    assert!(airlight(&map, light) > 0.0);
}

fn hybrid_parts(device: &wgpu::Device, scene: &Scene) -> Result<ShadowVolume, PrepareError> {
    let casters = Arc::new(ShadowCasters::of_scene(device, scene)?);
    ShadowVolume::new(device, casters)
}

fn what_to_do(error: &PrepareError) -> String {
    match error {
        // the technique cannot take this medium or light; the text names one that can
        PrepareError::Refused(refusal) => format!("another technique: {refusal}"),
        // lost, or out of memory: what was made on the device goes with it
        PrepareError::Device { .. } => format!("another device: {error}"),
        // a size, format or usage; the text says which, and what would do
        _ => format!("a mistake: {error}"),
    }
}

/// What a technique cannot take is told before anything is drawn, and another one takes it.
#[test]
fn refusals_say_what_to_use_instead() {
    let Some(gpu) = core_gpu() else { return };
    let (device, queue) = (&gpu.device, &gpu.queue);
    let scene = procedural::generate("sphere").unwrap();
    let volume = hybrid_parts(device, &scene).unwrap();
    let light = Light::Point(lamp());
    let lamps = [Lamp { light: &light, shadows: None, volume: Some(&volume) }];
    let camera = &cameras()[0];
    let views = [View { camera, size: SIZE, depth: SceneDepth::Nothing, max_distance: f64::INFINITY }];
    let medium = Medium {
        density: Some(Density::height(0.0, 2.0).unwrap()),
        ..Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap()
    };
    let mut fog = Fog::new(device, &FogDescriptor::default()).unwrap();
    let hybrid = Frame { technique: Technique::Hybrid(Hybrid::default()), ..frame(&views, &medium, &lamps) };
    let error = fog.prepare(device, queue, &hybrid).unwrap_err();
    assert!(what_to_do(&error).starts_with("another technique: "), "{error}");
    assert!(error.to_string().contains("use brute-force"), "{error}");
    let march = Technique::BruteForce { samples: 32, lookup: Default::default() };
    fog.prepare(device, queue, &Frame { technique: march, ..hybrid }).unwrap();
    assert!(mean(&gpu, &mut fog, 0) > 0.0);
    assert!(!fog.stats().passes.is_empty() && fog.stats().bytes > 0);
}
