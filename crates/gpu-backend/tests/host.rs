//! Fog in a renderer that owns its device, its depth buffers and its shadow map, each in a convention of its own.

#![expect(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "test code")]

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Stage, compare, gpu, read_texture, upload};
use glam::{DMat4, DVec2, Vec3};
use gpu_backend::{
    CompositeTarget, Fog, FogDescriptor, Frame, HostDepth, Lamp, Lookup, Sampling, SceneDepth, ShadowMap,
    Shadows, Technique, View, wgpu,
};
use scene::{AirlightModel, Camera, Density, Interval, Light, Medium, Mesh};
use shadowmap::{Bias, DepthOrder, Face, MapSurface, Projection};
use wgpu::util::DeviceExt;

const SIZES: [(u32, u32); 2] = [(56, 40), (24, 36)];
const MAP_SIDE: u32 = 128;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// How the host draws: which end of depth is near, and its planes.
#[derive(Clone, Copy)]
struct Convention {
    order: DepthOrder,
    near: f32,
    far: f32,
}

const FORWARD: Convention = Convention { order: DepthOrder::Forward, near: 0.2, far: 80.0 };
const REVERSED: Convention = Convention { order: DepthOrder::Reversed, near: 0.05, far: f32::INFINITY };

/// A renderer as simple as can be: surfaces coloured by their place.
struct Host {
    device: wgpu::Device,
    queue: wgpu::Queue,
    vertices: wgpu::Buffer,
    count: u32,
    errors: Arc<AtomicUsize>,
}

const SURFACES: &str = "
    @group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
    struct Out { @builtin(position) position: vec4f, @location(0) color: vec3f }
    @vertex fn vs(@location(0) p: vec3f) -> Out {
        return Out(clip_from_world * vec4f(p, 1.0), vec3f(0.3, 0.2, 0.25) + 0.15 * sin(p));
    }
    @fragment fn fs(in: Out) -> @location(0) vec4f { return vec4f(in.color, 0.75); }
";

impl Host {
    /// A device of WebGPU's default limits, and the features that are there of those asked for.
    fn new(features: wgpu::Features, stage: &Stage) -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = match pollster::block_on(instance.request_adapter(&Default::default())) {
            Ok(adapter) => adapter,
            Err(error) => {
                assert!(std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but: {error}");
                println!("GPU test did not run: {error}");
                return None;
            }
        };
        let descriptor =
            wgpu::DeviceDescriptor { required_features: features & adapter.features(), ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        let errors = Arc::new(AtomicUsize::new(0));
        let counter = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            println!("uncaptured: {error}");
            counter.fetch_add(1, Ordering::Relaxed);
        }));
        let corners: Vec<[f32; 3]> =
            stage.scene.meshes.iter().flat_map(Mesh::corners).flatten().map(|p| p.to_array()).collect();
        let vertices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(&corners),
            usage: wgpu::BufferUsages::VERTEX,
        });
        Some(Self { device, queue, vertices, count: corners.len() as u32, errors })
    }

    fn texture(&self, size: (u32, u32), format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Draws depth, and colour where there is a picture.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        clip_from_world: DMat4,
        order: DepthOrder,
        depth: &wgpu::Texture,
        picture: Option<&wgpu::Texture>,
    ) {
        let device = &self.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SURFACES.into()),
        });
        let targets: Vec<_> = picture.iter().map(|picture| Some(picture.format().into())).collect();
        let (clear, compare) = match order {
            DepthOrder::Forward => (1.0, wgpu::CompareFunction::Less),
            DepthOrder::Reversed => (0.0, wgpu::CompareFunction::Greater),
        };
        let layout = wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[Some(layout)],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: picture.map(|_| wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        let matrix = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(&clip_from_world.as_mat4().to_cols_array()),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: matrix.as_entire_binding() }],
        });
        let background = wgpu::Color { r: 0.1, g: 0.3, b: 0.2, a: 0.75 };
        let mut pass =
            begin(encoder, depth, wgpu::LoadOp::Clear(clear), picture, wgpu::LoadOp::Clear(background));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }

    fn pixels(&self, texture: &wgpu::Texture) -> Vec<[f32; 4]> {
        let bytes = read_texture(&self.device, &self.queue, texture);
        match texture.format() {
            wgpu::TextureFormat::Rgba8Unorm => {
                bytes.chunks_exact(4).map(|p| [0, 1, 2, 3].map(|i| f32::from(p[i]) / 255.0)).collect()
            }
            wgpu::TextureFormat::Rgba16Float => bytes
                .chunks_exact(8)
                .map(|p| [0, 2, 4, 6].map(|i| half(u16::from_le_bytes([p[i], p[i + 1]]))))
                .collect(),
            other => panic!("{other:?} is not read here"),
        }
    }
}

/// A half as a float; only normal numbers and zero come up.
fn half(bits: u16) -> f32 {
    let (sign, exponent, mantissa) = (bits >> 15, i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let magnitude = match exponent {
        0 => mantissa * 2_f32.powi(-24),
        _ => (1.0 + mantissa / 1024.0) * 2_f32.powi(exponent - 15),
    };
    if sign == 1 { -magnitude } else { magnitude }
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    depth: &wgpu::Texture,
    depth_load: wgpu::LoadOp<f32>,
    picture: Option<&wgpu::Texture>,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    let depth = depth.create_view(&Default::default());
    let picture = picture.map(|picture| picture.create_view(&Default::default()));
    let colors: Vec<_> = picture
        .iter()
        .map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })
        })
        .collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &colors,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations { load: depth_load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// The matrix of a host's camera.
fn clip_from_world(camera: &Camera, size: (u32, u32), convention: Convention) -> DMat4 {
    let half = (0.5 * f64::from(camera.fov_y)).tan();
    let face = Face {
        origin: camera.position.as_dvec3(),
        right: camera.right.as_dvec3(),
        down: -camera.up.as_dvec3(),
        forward: camera.forward.as_dvec3(),
        half: DVec2::new(half * f64::from(size.0) / f64::from(size.1), half),
        perspective: true,
    };
    face.clip_from_world(convention.order, convention.near, convention.far).unwrap()
}

/// Media with how they are computed.
fn media(stage: &Stage) -> Vec<(&'static str, Medium, Technique)> {
    let exact = Technique::ExactShadowMap { surface: MapSurface::Step };
    let march = Technique::BruteForce { samples: 64, lookup: Lookup::Nearest };
    let (grey, sigma) = (stage.medium.clone(), stage.medium.coefficients.sigma_s()[0]);
    let colored =
        Medium::homogeneous([sigma, 0.5 * sigma, 0.2 * sigma], [0.0, 0.2 * sigma, 0.8 * sigma]).unwrap();
    let low = Medium { density: Some(Density::height(0.5, 0.7).unwrap()), ..colored.clone() };
    vec![("achromatic", grey, exact), ("chromatic", colored, exact), ("height", low, march)]
}

/// Two views of a scene, with a spot light whose map is the host's.
struct Set {
    stages: [Stage; 2],
    light: Light,
    projection: Projection,
}

impl Set {
    fn new() -> Self {
        let scene = scene::procedural::generate("sphere").unwrap();
        let around = |eye| Camera::look_at(eye, Vec3::new(0.0, 0.6, 0.0), Vec3::Y, 0.8).unwrap();
        let cameras = [around(Vec3::new(0.5, 1.2, 5.0)), around(Vec3::new(-3.0, 2.5, 3.5))];
        let mut sizes = SIZES.iter();
        let stages = cameras.map(|camera| {
            Stage::new("sphere", scene.clone(), camera, *sizes.next().unwrap_or(&SIZES[0]), 1.0)
        });
        let light = stages[0].lights()[1].clone();
        let Light::Spot(spot) = &light else { panic!("the second light is a spot") };
        let projection = Projection::spot(spot).unwrap();
        Self { stages, light, projection }
    }
}

#[test]
fn surfaces_are_attenuated_and_airlight_is_added() {
    let set = Set::new();
    let Some(host) = Host::new(wgpu::Features::empty(), &set.stages[0]) else { return };
    let headless = gpu().unwrap();
    assert_eq!(host.device.limits(), wgpu::Limits::default());
    let scope = host.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let map_depth = host.texture((MAP_SIDE, MAP_SIDE), DEPTH);
    let host_depth =
        HostDepth { texture: &map_depth, order: FORWARD.order, near: FORWARD.near, far: FORWARD.far };
    let map = ShadowMap::from_host(&host.device, host_depth, set.projection.clone(), Bias::NONE).unwrap();
    for format in [wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Rgba8Unorm] {
        let target = CompositeTarget { depth_format: Some(DEPTH), ..CompositeTarget::picture(format) };
        let descriptor = FogDescriptor { label: Some("mist"), target: Some(target), ..Default::default() };
        let mut fog = Fog::new(&host.device, &descriptor).unwrap();
        for (name, medium, technique) in media(&set.stages[0]) {
            let conventions = [FORWARD, REVERSED];
            let depths = SIZES.map(|size| host.texture(size, DEPTH));
            let pictures = SIZES.map(|size| host.texture(size, format));
            let mut encoder = host.device.create_command_encoder(&Default::default());
            let light = set.projection.faces()[0].clip_from_world(FORWARD.order, FORWARD.near, FORWARD.far);
            host.draw(&mut encoder, light.unwrap(), FORWARD.order, &map_depth, None);
            for view in 0..2 {
                let matrix = clip_from_world(&set.stages[view].camera, SIZES[view], conventions[view]);
                let order = conventions[view].order;
                host.draw(&mut encoder, matrix, order, &depths[view], Some(&pictures[view]));
            }
            host.queue.submit([encoder.finish()]);
            let surfaces = pictures.each_ref().map(|picture| host.pixels(picture));

            let views = [0, 1].map(|view| View {
                camera: &set.stages[view].camera,
                size: SIZES[view],
                depth: SceneDepth::Buffer {
                    texture: &depths[view],
                    order: conventions[view].order,
                    near: conventions[view].near,
                    far: conventions[view].far,
                },
                max_distance: 30.0,
            });
            let shadows = Some(Shadows::Map { map: &map, casters: set.stages[0].bvh.bounds() });
            let lamps = [Lamp { light: &set.light, shadows, volume: None }];
            let frame = Frame {
                views: &views,
                medium: &medium,
                lamps: &lamps,
                model: AirlightModel::Sun,
                technique,
                sampling: Sampling::Pixels,
            };
            map.touch();
            fog.prepare(&host.device, &host.queue, &frame).unwrap();
            let pixels: u32 = SIZES.iter().map(|(width, height)| width * height).sum();
            let draws = if name == "achromatic" { 1 } else { 2 };
            assert_eq!(fog.stats().fragments, draws * u64::from(pixels));
            let mut encoder = host.device.create_command_encoder(&Default::default());
            fog.encode(&mut encoder);
            for view in 0..2 {
                let mut pass = begin(
                    &mut encoder,
                    &depths[view],
                    wgpu::LoadOp::Load,
                    Some(&pictures[view]),
                    wgpu::LoadOp::Load,
                );
                fog.composite(&mut pass, view);
            }
            // nothing of it runs before the host submits: another submission finds all as it was
            for view in 0..2 {
                assert_eq!(host.pixels(&pictures[view]), surfaces[view]);
            }
            if format == wgpu::TextureFormat::Rgba16Float && name == "achromatic" {
                let airlight = read_texture(&host.device, &host.queue, fog.airlight(0).unwrap());
                assert!(airlight.iter().all(|&byte| byte == 0));
            }
            host.queue.submit([encoder.finish()]);

            for view in 0..2 {
                let airlight = fog.read_airlight(&host.device, &host.queue, view).unwrap();
                let stage = &set.stages[view];
                check_picture(
                    &host.pixels(&pictures[view]),
                    &surfaces[view],
                    &airlight,
                    stage,
                    &medium,
                    format,
                );
                // the same picture without a host
                let stage = Stage { medium: medium.clone(), ends: limited(&stage.ends), ..clone(stage) };
                let cpu = stage.map(&set.light, MAP_SIDE, MapSurface::Step).unwrap();
                let want = stage.on_gpu(
                    &headless,
                    &mut common::fog(&headless),
                    &set.light,
                    Some(&upload(&headless, &cpu)),
                    technique,
                );
                let (rmse, p99) = compare(&airlight, &want);
                println!("{format:?} {name} view {view}: rel_rmse {rmse:.1e} p99 {p99:.1e}");
                // silhouettes of the host's rasteriser, and the rounding of forward z
                assert!(rmse < 5e-3 && p99 < 2e-2, "{rmse} {p99}");
            }
        }
    }
    assert!(pollster::block_on(scope.pop()).is_none());
    assert_eq!(host.errors.load(Ordering::Relaxed), 0);
}

/// Ends of rays that go 30 m where they hit nothing.
fn limited(ends: &[f64]) -> Vec<f64> {
    ends.iter().map(|end| end.min(30.0)).collect()
}

fn clone(stage: &Stage) -> Stage {
    Stage::new(&stage.name, stage.scene.clone(), stage.camera.clone(), stage.size, 1.0)
}

/// Surface × transmittance + airlight, but for the rounding of the picture's format, and silhouettes where the host's
/// depth is another surface's.
fn check_picture(
    got: &[[f32; 4]],
    surfaces: &[[f32; 4]],
    airlight: &[[f32; 3]],
    stage: &Stage,
    medium: &Medium,
    format: wgpu::TextureFormat,
) {
    let sigma_t = medium.coefficients.sigma_t();
    let mut different = 0;
    for (index, ((got, surface), airlight)) in (0..).zip(got.iter().zip(surfaces).zip(airlight)) {
        let ray = stage.camera.pixel_ray(index % stage.size.0, index / stage.size.0, stage.size);
        let end = stage.ends[index as usize].min(30.0);
        let path = medium.optical_path(&ray, Interval::new(0.0, end));
        for channel in 0..3 {
            let transmittance = (-f64::from(sigma_t[channel]) * path).exp() as f32;
            let want = surface[channel] * transmittance + airlight[channel];
            let (want, tolerance) = match format {
                // two draws round twice
                wgpu::TextureFormat::Rgba8Unorm => (want.min(1.0), 1.6 / 255.0),
                _ => (want, 2e-3 * want + 1e-4),
            };
            different += usize::from((got[channel] - want).abs() > tolerance);
        }
        // the host's alpha stays
        assert_eq!(got[3], surface[3]);
    }
    println!("{different} of {} values differ", 3 * got.len());
    assert!((different as f64) < 0.01 * (3 * got.len()) as f64);
}

#[test]
fn frames_may_be_encoded_before_others_are_submitted() {
    let set = Set::new();
    // with the features that the passes use where they are there
    let Some(host) = Host::new(gpu_backend::optional_features(), &set.stages[0]) else { return };
    let mut fog = Fog::new(&host.device, &FogDescriptor::default()).unwrap();
    let stage = &set.stages[0];
    let lamps = [Lamp { light: &set.light, shadows: None, volume: None }];
    let view = View {
        camera: &stage.camera,
        size: stage.size,
        depth: SceneDepth::Nothing,
        max_distance: f64::INFINITY,
    };
    let frame = Frame {
        views: &[view],
        medium: &stage.medium,
        lamps: &lamps,
        model: AirlightModel::Sun,
        technique: Technique::ExactShadowMap { surface: MapSurface::Step },
        sampling: Sampling::Pixels,
    };
    let mut commands = Vec::new();
    for _ in 0..3 {
        fog.prepare(&host.device, &host.queue, &frame).unwrap();
        let mut encoder = host.device.create_command_encoder(&Default::default());
        fog.encode(&mut encoder);
        fog.encode(&mut encoder);
        commands.push(encoder.finish());
    }
    host.queue.submit(commands);
    let first = fog.read_airlight(&host.device, &host.queue, 0).unwrap();
    let times = fog.pass_times(&host.device, &host.queue).unwrap();
    if host.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        assert_eq!(times.len(), fog.stats().passes.len());
        assert!(fog.pass_times(&host.device, &host.queue).unwrap().is_empty());
    }
    // after the times were read their buffer serves again
    let mut encoder = host.device.create_command_encoder(&Default::default());
    fog.encode(&mut encoder);
    host.queue.submit([encoder.finish()]);
    assert_eq!(fog.read_airlight(&host.device, &host.queue, 0).unwrap(), first);
    assert_eq!(host.errors.load(Ordering::Relaxed), 0);
}
