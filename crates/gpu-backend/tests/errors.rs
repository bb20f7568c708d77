//! What cannot work is an error with words: no panic, and nothing reaches the host's error handler. After an error the
//! same fog makes a good frame.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "test code")]

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Stage, gpu, gpus, render, upload};
use glam::{DVec2, DVec3, Vec3};
use gpu_backend::{
    AirlightProbe, CompositeTarget, CreateError, DepthDrawer, DrawnDepth, DrawnMap, Fog, FogDescriptor,
    Frame, GpuBvh, GpuContext, HostDepth, Lamp, Lookup, OcclusionProbe, Pipelines, PrepareError, Problem,
    ReadError, Sampling, SceneDepth, ShadowMap, ShadowRay, Shadows, Technique, Triangles, View, wgpu,
};
use scene::{AirlightModel, Camera, Density, Light, Medium, PointLight, WideBvh};
use shadowmap::{Bias, DepthMap, DepthOrder, MapSurface, Projection, ShadowMapError, VarianceMap};

const EXACT: Technique = Technique::ExactShadowMap { surface: MapSurface::Step };

/// Counts what reaches the host's handler instead of ending the program.
fn counted(device: &wgpu::Device) -> Arc<AtomicUsize> {
    let count = Arc::new(AtomicUsize::new(0));
    let handler = count.clone();
    device.on_uncaptured_error(Arc::new(move |error| {
        println!("uncaptured: {error}");
        handler.fetch_add(1, Ordering::Relaxed);
    }));
    count
}

/// The parts of a frame, to be spoilt one by one.
struct Parts<'a> {
    camera: Camera,
    size: (u32, u32),
    depth: SceneDepth<'a>,
    max_distance: f64,
    medium: Medium,
    lights: Vec<Light>,
    shadows: Option<Shadows<'a>>,
    model: AirlightModel,
    technique: Technique,
}

impl Parts<'_> {
    fn good() -> Self {
        let light = PointLight::new(Vec3::new(1.0, 2.0, 0.0), Vec3::splat(50.0)).unwrap();
        Self {
            camera: Camera::look_at(Vec3::new(0.0, 1.0, 6.0), Vec3::ZERO, Vec3::Y, 0.8).unwrap(),
            size: (16, 12),
            depth: SceneDepth::Nothing,
            max_distance: f64::INFINITY,
            medium: Medium::homogeneous([0.05; 3], [0.01; 3]).unwrap(),
            lights: vec![Light::Point(light)],
            shadows: None,
            model: AirlightModel::Sun,
            technique: EXACT,
        }
    }

    fn with<T>(&self, f: impl FnOnce(&Frame<'_>) -> T) -> T {
        let view = View {
            camera: &self.camera,
            size: self.size,
            depth: self.depth,
            max_distance: self.max_distance,
        };
        let lamps: Vec<Lamp<'_>> =
            self.lights.iter().map(|light| Lamp { light, shadows: self.shadows, volume: None }).collect();
        f(&Frame {
            views: &[view],
            medium: &self.medium,
            lamps: &lamps,
            model: self.model,
            technique: self.technique,
            sampling: Sampling::Pixels,
        })
    }

    fn prepare(&self, gpu: &GpuContext, fog: &mut Fog) -> Result<(), PrepareError> {
        self.with(|frame| fog.prepare(&gpu.device, &gpu.queue, frame))
    }
}

fn march(samples: u32, lookup: Lookup) -> Technique {
    Technique::BruteForce { samples, lookup }
}

/// Asserts that a frame is refused as `$pattern`, that nothing of it can be encoded, and that a good frame follows.
macro_rules! refused {
    ($gpu:expr, $fog:expr, $parts:expr, $pattern:pat) => {{
        let error = $parts.prepare($gpu, $fog).unwrap_err();
        assert!(matches!(error, $pattern), "{error:?}");
        assert!(error.to_string().len() > 10 && !error.to_string().contains('\n'), "{error}");
        assert!($fog.airlight(0).is_none() && $fog.stats().passes.is_empty());
        let nothing = $fog.read_airlight(&$gpu.device, &$gpu.queue, 0);
        assert!(matches!(nothing, Err(ReadError::Nothing(_))));
        let mut encoder = $gpu.device.create_command_encoder(&Default::default());
        $fog.encode(&mut encoder);
        $gpu.queue.submit([encoder.finish()]);
        let picture = Parts::good().with(|frame| render($gpu, $fog, frame));
        assert!(picture.iter().flatten().all(|value| *value > 0.0 && value.is_finite()));
    }};
}

fn depth_texture(
    device: &wgpu::Device,
    size: (u32, u32),
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
    sample_count: u32,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host depth"),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

#[test]
fn frames_that_make_no_sense() {
    for gpu in &gpus() {
        let uncaptured = counted(&gpu.device);
        let fog = &mut Fog::new(&gpu.device, &FogDescriptor::default()).unwrap();
        let good = Parts::good;
        let lights = vec![good().lights[0].clone(); 9];
        refused!(gpu, fog, Parts { lights, ..good() }, PrepareError::TooManyLights { got: 9, most: 8 });
        refused!(gpu, fog, Parts { size: (0, 5), ..good() }, PrepareError::EmptyView { view: 0 });
        let size = (1, gpu.device.limits().max_texture_dimension_2d + 1);
        refused!(gpu, fog, Parts { size, ..good() }, PrepareError::TooLarge { .. });
        for (distances, ok) in
            [(vec![1.0; 191], false), (vec![1.0; 193], false), (vec![], false), (vec![1.0; 192], true)]
        {
            let parts = Parts { depth: SceneDepth::Distances(&distances), ..good() };
            if ok {
                parts.prepare(gpu, fog).unwrap();
            } else {
                refused!(gpu, fog, parts, PrepareError::Distances { view: 0, pixels: 192, .. });
            }
        }
        for bad in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            let mut distances = vec![1.0; 192];
            distances[77] = bad;
            let depth = SceneDepth::Distances(&distances);
            refused!(gpu, fog, Parts { depth, ..good() }, PrepareError::Value { name: "a distance", .. });
        }
        for max_distance in [0.0, -1.0, f64::NAN] {
            refused!(gpu, fog, Parts { max_distance, ..good() }, PrepareError::Value { .. });
        }
        for (fov_y, position) in [(f32::NAN, Vec3::ZERO), (0.0, Vec3::ZERO), (0.8, Vec3::NAN)] {
            let camera = Camera { fov_y, position, ..good().camera };
            refused!(gpu, fog, Parts { camera, ..good() }, PrepareError::Value { .. });
        }
        assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
    }
}

#[test]
fn textures_that_cannot_be_read_as_depth() {
    let Some(gpu) = &gpu() else { return };
    let uncaptured = counted(&gpu.device);
    let fog = &mut Fog::new(&gpu.device, &FogDescriptor::default()).unwrap();
    let (binding, depth32) = (wgpu::TextureUsages::TEXTURE_BINDING, wgpu::TextureFormat::Depth32Float);
    let make = |size, format, usage, samples| depth_texture(&gpu.device, size, format, usage, samples);
    let bad = [
        make((16, 12), wgpu::TextureFormat::R32Float, binding, 1),
        make((16, 11), depth32, binding, 1),
        make((16, 12), depth32, wgpu::TextureUsages::COPY_SRC, 1),
        make((16, 12), depth32, binding, 4),
        make((16, 12), wgpu::TextureFormat::Stencil8, binding, 1),
    ];
    fn buffer(texture: &wgpu::Texture, near: f32, far: f32) -> Parts<'_> {
        let depth = SceneDepth::Buffer { texture, order: DepthOrder::Reversed, near, far };
        Parts { depth, ..Parts::good() }
    }
    for texture in &bad {
        refused!(gpu, fog, buffer(texture, 0.1, 10.0), PrepareError::Texture { .. });
    }
    let spot = || Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
    let map = |texture: &wgpu::Texture, near, far, projection| {
        let host = HostDepth { texture, order: DepthOrder::Forward, near, far };
        ShadowMap::from_host(&gpu.device, host, projection, Bias::NONE).map(|_| ())
    };
    for texture in [&bad[0], &bad[2], &bad[3], &bad[4]] {
        let error = map(texture, 0.1, 10.0, spot()).unwrap_err();
        assert!(matches!(error, PrepareError::Texture { .. }), "{error:?}");
    }
    let fine = make((16, 12), depth32, binding, 1);
    let planes = [
        (0.0, 1.0),
        (2.0, 1.0),
        (1.0, 1.0),
        (f32::NAN, 1.0),
        (0.1, f32::NAN),
        (f32::INFINITY, f32::INFINITY),
    ];
    for (near, far) in planes {
        refused!(gpu, fog, buffer(&fine, near, far), PrepareError::Value { .. });
        let error = map(&fine, near, far, spot()).unwrap_err();
        assert!(matches!(error, PrepareError::Map(ShadowMapError::Planes { .. })), "{error:?}");
    }
    let flat = Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
    let endless = map(&fine, 0.0, f32::INFINITY, flat).unwrap_err();
    assert!(matches!(endless, PrepareError::Map(ShadowMapError::Planes { .. })));
    // one layer where a cube needs six
    let cube = map(&fine, 0.1, 10.0, Projection::cube(DVec3::ZERO).unwrap()).unwrap_err();
    assert!(matches!(cube, PrepareError::Texture { .. }), "{cube:?}");
    // depth formats with stencil, and 16 bits, are fine
    for format in [wgpu::TextureFormat::Depth24PlusStencil8, wgpu::TextureFormat::Depth16Unorm] {
        let texture = make((16, 12), format, binding, 1);
        buffer(&texture, 0.1, f32::INFINITY).prepare(gpu, fog).unwrap();
        map(&texture, 0.1, f32::INFINITY, spot()).unwrap();
    }
    assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
}

#[test]
fn maps_that_do_not_fit() {
    let Some(gpu) = &gpu() else { return };
    let (device, queue) = (&gpu.device, &gpu.queue);
    let uncaptured = counted(device);
    let fog = &mut Fog::new(device, &FogDescriptor::default()).unwrap();
    let stage = Stage::procedural("sphere", (1, 1), 1.0);
    let maps: Vec<DepthMap> =
        stage.lights().iter().map(|light| stage.map(light, 8, MapSurface::Step).unwrap()).collect();
    let (cube, spot) = (upload(gpu, &maps[0]), upload(gpu, &maps[1]));
    let with = |map, technique| {
        let shadows = Some(Shadows::Map { map, casters: stage.bvh.bounds() });
        Parts { shadows, technique, ..Parts::good() }
    };
    refused!(
        gpu,
        fog,
        with(&spot, EXACT),
        PrepareError::WrongMap { light: 0, map: "a perspective", kind: "point" }
    );
    refused!(gpu, fog, with(&cube, march(9, Lookup::Variance)), PrepareError::NoMoments { light: 0 });
    for width in [0, 33] {
        let technique = march(9, Lookup::PercentageCloser { width });
        refused!(gpu, fog, with(&cube, technique), PrepareError::Map(_));
    }
    let moments = VarianceMap::new(&maps[1], 10.0).unwrap();
    let error = cube.clone().with_moments(device, queue, &moments).unwrap_err();
    assert!(matches!(error, PrepareError::Texture { .. }), "{error:?}");
    let error = cube.clone().update(device, queue, &maps[1], Bias::NONE).unwrap_err();
    assert!(matches!(error, PrepareError::Texture { .. }), "{error:?}");
    // larger than the device allows: refused before anything is made
    let most = device.limits().max_texture_dimension_2d;
    let flat = maps[1].projection().clone();
    for size in [(most + 1, 1), (0, 4)] {
        let error = DrawnMap::new(device, flat.clone(), size, &stage.bvh.bounds(), Bias::NONE).unwrap_err();
        assert!(matches!(error, PrepareError::TooLarge { .. } | PrepareError::Map(_)), "{error:?}");
        let error = DrawnDepth::new(device, size).unwrap_err();
        assert!(matches!(error, PrepareError::TooLarge { .. } | PrepareError::EmptyView { .. }), "{error:?}");
    }
    if let Ok(map) = DepthMap::uniform(flat, (most + 1, 1), 1.0) {
        let error = ShadowMap::upload(device, queue, &map, Bias::NONE).unwrap_err();
        assert!(matches!(error, PrepareError::TooLarge { .. }), "{error:?}");
    }
    let projection = Projection::cube(DVec3::ZERO).unwrap();
    let error = DrawnMap::new(device, projection, (8, 4), &stage.bvh.bounds(), Bias::NONE).unwrap_err();
    assert!(matches!(error, PrepareError::Map(ShadowMapError::NotSquare { .. })), "{error:?}");
    // a map as long as the device allows: its pyramid fits as well, whatever its padding
    let long = DepthMap::uniform(maps[1].projection().clone(), (most, 1), 2.0);
    if let Ok(long) = long {
        let long = upload(gpu, &long);
        let light = stage.lights()[1].clone();
        let parts = Parts { lights: vec![light], ..with(&long, EXACT) };
        let picture = parts.with(|frame| render(gpu, fog, frame));
        assert!(picture.iter().flatten().all(|value| value.is_finite()));
    }
    assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
}

#[test]
fn what_a_technique_cannot_take() {
    let Some(gpu) = &gpu() else { return };
    let fog = &mut Fog::new(&gpu.device, &FogDescriptor::default()).unwrap();
    let good = Parts::good;
    let grey = good().medium;
    let bounds = scene::Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let media = [
        Medium { density: Some(Density::height(0.0, 1.0).unwrap()), ..grey.clone() },
        Medium { bounds: Some(bounds), ..grey.clone() },
        Medium { emission: [1.0; 3], ..grey },
    ];
    for medium in media {
        refused!(gpu, fog, Parts { medium: medium.clone(), ..good() }, PrepareError::Refused(_));
        Parts { medium, technique: march(9, Lookup::Nearest), ..good() }.prepare(gpu, fog).unwrap();
    }
    refused!(gpu, fog, Parts { model: AirlightModel::HoffmanPreetham, ..good() }, PrepareError::Refused(_));
}

#[test]
fn targets_and_limits() {
    for gpu in &gpus() {
        let uncaptured = counted(&gpu.device);
        let make =
            |target| Fog::new(&gpu.device, &FogDescriptor { target: Some(target), ..Default::default() });
        for format in [
            wgpu::TextureFormat::R32Uint,
            wgpu::TextureFormat::Depth32Float,
            wgpu::TextureFormat::Rgb9e5Ufloat,
        ] {
            let error = make(CompositeTarget::picture(format)).unwrap_err();
            assert_eq!(error, CreateError::Format(format));
        }
        if !gpu.device.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
            let error = make(CompositeTarget::picture(wgpu::TextureFormat::Rgba32Float)).unwrap_err();
            assert_eq!(error, CreateError::Format(wgpu::TextureFormat::Rgba32Float));
        }
        // three samples, or a depth format that is none: the driver's words, when the pipeline is first needed
        let picture = CompositeTarget::picture(wgpu::TextureFormat::Rgba16Float);
        let bad = [
            CompositeTarget { sample_count: 3, ..picture },
            CompositeTarget { depth_format: Some(wgpu::TextureFormat::Rgba8Unorm), ..picture },
        ];
        for target in bad {
            let mut fog = make(target).unwrap();
            let error = Parts::good().prepare(gpu, &mut fog).unwrap_err();
            assert!(matches!(error, PrepareError::Create(CreateError::Pipeline { .. })), "{error:?}");
            assert!(fog.airlight(0).is_none());
        }
        assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
    }
    let Some((device, _)) =
        with_limits(wgpu::Limits { max_storage_textures_per_shader_stage: 3, ..wgpu::Limits::default() })
    else {
        return;
    };
    let error = Fog::new(&device, &FogDescriptor::default()).unwrap_err();
    let name = "max_storage_textures_per_shader_stage";
    assert_eq!(error, CreateError::Limit { name, needed: 4, got: 3 });
}

/// A device with these limits.
fn with_limits(required_limits: wgpu::Limits) -> Option<(wgpu::Device, wgpu::Queue)> {
    open(wgpu::MemoryBudgetThresholds::default(), required_limits)
}

fn open(
    memory_budget_thresholds: wgpu::MemoryBudgetThresholds,
    required_limits: wgpu::Limits,
) -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        memory_budget_thresholds,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok()?;
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    pollster::block_on(adapter.request_device(&descriptor)).ok()
}

#[test]
fn memory_that_is_not_there() {
    // a share of the memory so small that a cube of 8192² texels does not fit, and none at all
    for percent in [1, 0] {
        let budget =
            wgpu::MemoryBudgetThresholds { for_resource_creation: Some(percent), for_device_loss: None };
        let Some((device, queue)) = open(budget, wgpu::Limits::default()) else { return };
        let uncaptured = counted(&device);
        let pipelines = Pipelines::new(&device);
        let gpu = GpuContext { info: device.adapter_info(), device, queue, pipelines };
        let side = gpu.device.limits().max_texture_dimension_2d;
        let bounds = scene::Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let projection = Projection::cube(DVec3::ZERO).unwrap();
        match DrawnMap::new(&gpu.device, projection, (side, side), &bounds, Bias::NONE) {
            // the driver does not say what it has
            Ok(_) => println!("a cube of {side} texels fits into {percent} % of the memory"),
            Err(error) => assert!(matches!(error, PrepareError::Device { .. }), "{error:?}"),
        }
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let triangles = Triangles::upload(&gpu.device, &[triangle]);
        match Fog::new(&gpu.device, &FogDescriptor::default()) {
            Ok(mut fog) => {
                let picture = Parts::good().with(|frame| render(&gpu, &mut fog, frame));
                assert!(picture.iter().flatten().all(|value| *value > 0.0) && triangles.is_ok());
            }
            Err(error) => {
                assert!(percent == 0 && error.to_string().contains("memory"), "{error}");
                println!("{error}; {}", triangles.unwrap_err());
            }
        }
        assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
    }
}

#[test]
fn pipelines_of_another_device() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let device = || {
        let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok()?;
        pollster::block_on(adapter.request_device(&Default::default())).ok()
    };
    let (Some((one, _)), Some((other, _))) = (device(), device()) else { return };
    let pipelines = Pipelines::new(&other);
    let descriptor = FogDescriptor { pipelines: Some(&pipelines), ..Default::default() };
    assert_eq!(Fog::new(&one, &descriptor).unwrap_err(), CreateError::OtherDevice);
    assert!(pipelines.count() == 0 && Fog::new(&other, &descriptor).is_ok());
}

/// Whether an error says that the device is gone.
fn lost(error: &impl std::fmt::Display) -> bool {
    error.to_string().contains("lost")
}

#[test]
fn a_lost_device() {
    for gpu in &gpus() {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let uncaptured = counted(device);
        let stage = Stage::procedural("sphere", (16, 12), 1.0);
        let light = stage.lights()[0].clone();
        let cpu = stage.map(&light, 64, MapSurface::Step).unwrap();
        let target = CompositeTarget::picture(wgpu::TextureFormat::Rgba16Float);
        let descriptor = FogDescriptor { target: Some(target), ..Default::default() };
        let mut fog = Fog::new(device, &descriptor).unwrap();
        let drawer = DepthDrawer::new(device).unwrap();
        let triangles = Triangles::of_scene(device, &stage.scene).unwrap();
        let bounds = triangles.bounds();
        let drawn = DrawnMap::new(device, cpu.projection().clone(), (64, 64), &bounds, Bias::NONE).unwrap();
        let depth = DrawnDepth::new(device, (16, 12)).unwrap();
        let (airlight, occlusion) = (AirlightProbe::new(gpu).unwrap(), OcclusionProbe::new(gpu).unwrap());
        let wide = WideBvh::build(&stage.scene).unwrap();
        let bvh = GpuBvh::upload(device, &wide).unwrap();
        let mut uploaded = upload(gpu, &cpu);
        let mut parts = Parts { lights: vec![light], ..Parts::good() };
        parts.shadows = Some(Shadows::Map { map: drawn.map(), casters: bounds });
        parts.with(|frame| render(gpu, &mut fog, frame));
        parts.prepare(gpu, &mut fog).unwrap();

        device.destroy();

        // the frame that was prepared before: commands that go nowhere
        let mut encoder = device.create_command_encoder(&Default::default());
        fog.encode(&mut encoder);
        queue.submit([encoder.finish()]);
        let error = fog.read_airlight(device, queue, 0).unwrap_err();
        assert!(matches!(error, ReadError::Device { .. }) && lost(&error), "{error}");
        match fog.pass_times(device, queue) {
            Ok(times) => assert!(times.is_empty()),
            Err(error) => assert!(lost(&error), "{error}"),
        }
        // a new one, the same and another size
        for size in [(16, 12), (20, 12)] {
            parts.size = size;
            let error = parts.prepare(gpu, &mut fog).unwrap_err();
            assert!(lost(&error), "{error}");
            assert!(fog.airlight(0).is_none());
            let mut encoder = device.create_command_encoder(&Default::default());
            fog.encode(&mut encoder);
            queue.submit([encoder.finish()]);
        }
        for technique in
            [march(9, Lookup::Nearest), Technique::ExactShadowMap { surface: MapSurface::Linear }]
        {
            assert!(lost(
                &Parts { technique, ..Parts { shadows: parts.shadows, ..Parts::good() } }
                    .prepare(gpu, &mut fog)
                    .unwrap_err()
            ));
        }
        let moments = VarianceMap::new(&cpu, 10.0).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        let errors = [
            Fog::new(device, &descriptor).err().map(|e| e.to_string()),
            ShadowMap::upload(device, queue, &cpu, Bias::NONE).err().map(|e| e.to_string()),
            uploaded.update(device, queue, &cpu, Bias::NONE).err().map(|e| e.to_string()),
            uploaded.with_moments(device, queue, &moments).err().map(|e| e.to_string()),
            ShadowMap::from_host(device, drawn.depth(), cpu.projection().clone(), Bias::NONE)
                .err()
                .map(|e| e.to_string()),
            DepthDrawer::new(device).err().map(|e| e.to_string()),
            Triangles::of_scene(device, &stage.scene).err().map(|e| e.to_string()),
            DrawnDepth::new(device, (4, 4)).err().map(|e| e.to_string()),
            DrawnMap::new(device, cpu.projection().clone(), (4, 4), &bounds, Bias::NONE)
                .err()
                .map(|e| e.to_string()),
            drawer.draw_map(device, &mut encoder, &triangles, &drawn).err().map(|e| e.to_string()),
            drawer
                .draw_view(device, &mut encoder, &triangles, &stage.camera, &depth)
                .err()
                .map(|e| e.to_string()),
            GpuBvh::upload(device, &wide).err().map(|e| e.to_string()),
            AirlightProbe::new(gpu).err().map(|e| e.to_string()),
            OcclusionProbe::new(gpu).err().map(|e| e.to_string()),
            airlight.evaluate(&[(problem(), vec![[0.0, 1.0]])]).err().map(|e| e.to_string()),
            occlusion.trace(&bvh, &[shadow_ray()]).err().map(|e| e.to_string()),
        ];
        queue.submit([encoder.finish()]);
        for (index, error) in errors.iter().enumerate() {
            let error = error.as_ref().unwrap_or_else(|| panic!("call {index} did not fail"));
            assert!(lost(error), "call {index}: {error}");
        }
        assert_eq!(uncaptured.load(Ordering::Relaxed), 0);
    }
}

fn problem() -> Problem {
    Problem { sigma_s: 0.1, sigma_t: 0.1, intensity: 1.0, x_foot: 0.5, h: 1.0, g: 0.0 }
}

fn shadow_ray() -> ShadowRay {
    ShadowRay { origin: [0.0; 3], direction: [0.0, 1.0, 0.0], far: 1.0 }
}
