//! What the GPU tests share: devices, scenes, and the CPU's answer for the same frame.
#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]
#![allow(missing_debug_implementations, missing_docs, clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::print_stdout, reason = "a test that does not run says so")]

use gpu_backend::wgpu;
use gpu_backend::{
    DeviceFeatures, Fog, FogDescriptor, Frame, GpuBvh, GpuContext, Lamp, Sampling, SceneDepth, ShadowMap,
    Shadows, Technique, View,
};
use hybrid_march::{BruteForce, Occluders};
use scene::{
    AirlightModel, Bvh, Camera, DirectionalLight, Light, Medium, PointLight, Scene, SpotLight, Visibility,
};
use shadowmap::{Bias, DepthMap, ExactShadowMap, MapSurface};

/// Devices with core features only and with everything; empty with a line that says so where there is no adapter. With
/// `REQUIRE_GPU` set its absence fails the test.
pub fn gpus() -> Vec<GpuContext> {
    let adapter = std::env::var("AIRLIGHT_ADAPTER").ok();
    let open = |features| match GpuContext::open(adapter.as_deref(), features) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but: {error}");
            println!("GPU test did not run: {error}");
            None
        }
    };
    // all tests run once more with core features alone
    let core = std::env::var("AIRLIGHT_FEATURES").is_ok_and(|features| features == "core");
    let wanted: &[DeviceFeatures] =
        if core { &[DeviceFeatures::Core] } else { &[DeviceFeatures::Core, DeviceFeatures::Everything] };
    wanted.iter().copied().filter_map(open).collect()
}

/// The device with core features and limits, alone.
pub fn core_gpu() -> Option<GpuContext> {
    gpus().into_iter().next()
}

/// The device with everything, alone.
pub fn gpu() -> Option<GpuContext> {
    gpus().pop()
}

/// A scene with everything that a frame needs.
pub struct Stage {
    pub name: String,
    pub scene: Scene,
    pub bvh: Bvh,
    pub camera: Camera,
    pub medium: Medium,
    pub size: (u32, u32),
    /// Where each view ray ends; units: m.
    pub ends: Vec<f64>,
}

impl Stage {
    /// A generated scene seen by its own camera, in a medium of which the view has optical depth `depth`.
    pub fn procedural(name: &str, size: (u32, u32), depth: f32) -> Self {
        let scene = scene::procedural::generate(name).unwrap();
        let camera = scene.cameras[0].clone();
        Self::new(name, scene, camera, size, depth)
    }

    pub fn new(name: &str, scene: Scene, camera: Camera, size: (u32, u32), depth: f32) -> Self {
        let bvh = Bvh::build(&scene).unwrap();
        let mut ends = Vec::new();
        for y in 0..size.1 {
            for x in 0..size.0 {
                let ray = camera.pixel_ray(x, y, size);
                ends.push(bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance));
            }
        }
        let length = bvh.bounds().diagonal();
        let sigma = if length > 0.0 { depth / length } else { 0.1 };
        let medium = Medium::homogeneous([sigma; 3], [0.0; 3]).unwrap();
        Self { name: name.into(), scene, bvh, camera, medium, size, ends }
    }

    /// A point, a spot and a directional light for the scene: its own point light, and two beside it.
    pub fn lights(&self) -> Vec<Light> {
        let bounds = self.bvh.bounds();
        let (center, size) = (bounds.center(), bounds.diagonal());
        let own = self.scene.lights.iter().find_map(|light| match light {
            Light::Point(light) => Some(light.position),
            Light::Spot(light) => Some(light.position),
            Light::Directional(_) => None,
        });
        let position = own.unwrap_or(center + size * glam::Vec3::new(0.31, 0.43, 0.17));
        let power = glam::Vec3::new(10.0, 8.0, 6.0);
        let above = center + size * glam::Vec3::new(0.12, 0.48, 0.21);
        vec![
            Light::Point(PointLight::new(position, power).unwrap()),
            Light::Spot(SpotLight::new(above, center - above, 0.35, 0.5, power).unwrap()),
            Light::Directional(DirectionalLight::new(glam::Vec3::new(0.35, -1.0, 0.28), power).unwrap()),
        ]
    }

    /// The light's map for a meaning; `None` without triangles.
    pub fn map(&self, light: &Light, side: u32, surface: MapSurface) -> Option<DepthMap> {
        shadowmap::draw_maps_for(std::slice::from_ref(light), &self.scene, side, surface).unwrap().remove(0)
    }

    pub fn ends_f32(&self) -> Vec<f32> {
        self.ends.iter().map(|&end| end as f32).collect()
    }

    /// Airlight of one light on the GPU.
    pub fn on_gpu(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        light: &Light,
        map: Option<&ShadowMap>,
        technique: Technique,
    ) -> Vec<[f32; 3]> {
        self.with_model(gpu, fog, light, map, technique, AirlightModel::Sun)
    }

    /// Airlight of one light on the GPU, formed by a model.
    pub fn with_model(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        light: &Light,
        map: Option<&ShadowMap>,
        technique: Technique,
        model: AirlightModel,
    ) -> Vec<[f32; 3]> {
        let shadows = map.map(|map| Shadows::Map { map, casters: self.bvh.bounds() });
        self.lit(gpu, fog, Lamp { light, shadows, volume: None }, technique, model)
    }

    /// Airlight of one light on the GPU with shadow rays.
    pub fn by_rays_on_gpu(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        light: &Light,
        bvh: &GpuBvh,
        technique: Technique,
    ) -> Vec<[f32; 3]> {
        let shadows = Some(Shadows::Rays { bvh, casters: self.bvh.bounds() });
        self.lit(gpu, fog, Lamp { light, shadows, volume: None }, technique, AirlightModel::Sun)
    }

    fn lit(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        lamp: Lamp<'_>,
        technique: Technique,
        model: AirlightModel,
    ) -> Vec<[f32; 3]> {
        let ends = self.ends_f32();
        let view = View {
            camera: &self.camera,
            size: self.size,
            depth: SceneDepth::Distances(&ends),
            max_distance: f64::INFINITY,
        };
        let frame = Frame {
            views: &[view],
            medium: &self.medium,
            lamps: &[lamp],
            model,
            technique,
            sampling: Sampling::Pixels,
        };
        render(gpu, fog, &frame)
    }

    /// Airlight of one light by the CPU's march.
    pub fn marched(
        &self,
        light: &Light,
        visibility: Option<&dyn Visibility>,
        samples: u32,
        model: AirlightModel,
    ) -> Vec<[f32; 3]> {
        let lights = std::slice::from_ref(light);
        let occluders = visibility.map(|visibility| Occluders { visibility, bounds: self.bvh.bounds() });
        let march = BruteForce { medium: &self.medium, lights, occluders, samples, model };
        self.by_ray(|ray, end| march.airlight(ray, end).airlight.to_array())
    }

    /// Airlight of one light over the lit intervals of a map, in f64.
    pub fn traversed(&self, light: &Light, map: &Option<DepthMap>, surface: MapSurface) -> Vec<[f32; 3]> {
        let lights = std::slice::from_ref(light);
        let shadows = ExactShadowMap::new(std::slice::from_ref(map), lights, surface, Bias::NONE).unwrap();
        let settings = ground_truth::Settings::default();
        let reference = ground_truth::Reference::new(&[], &self.bvh, &self.medium, lights, settings)
            .unwrap()
            .with_shadows(&shadows);
        self.by_ray(|ray, end| reference.airlight(ray, end).as_vec3().to_array())
    }

    pub fn by_ray(&self, airlight: impl Fn(&scene::DRay, f64) -> [f32; 3]) -> Vec<[f32; 3]> {
        let mut pixels = Vec::new();
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let end = self.ends[(y * self.size.0 + x) as usize];
                pixels.push(airlight(&self.camera.pixel_ray(x, y, self.size), end));
            }
        }
        pixels
    }
}

/// Prepares, encodes, submits and reads the first view.
pub fn render(gpu: &GpuContext, fog: &mut Fog, frame: &Frame<'_>) -> Vec<[f32; 3]> {
    fog.prepare(&gpu.device, &gpu.queue, frame).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    fog.encode(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    fog.read_airlight(&gpu.device, &gpu.queue, 0).unwrap()
}

pub fn fog(gpu: &GpuContext) -> Fog {
    Fog::new(&gpu.device, &FogDescriptor { pipelines: Some(&gpu.pipelines), ..Default::default() }).unwrap()
}

pub fn upload(gpu: &GpuContext, map: &DepthMap) -> ShadowMap {
    ShadowMap::upload(&gpu.device, &gpu.queue, map, Bias::NONE).unwrap()
}

/// ‖a − b‖₂/‖b‖₂ and the 99th percentile of |a − b|/mean b; 0 for two black pictures.
pub fn compare(a: &[[f32; 3]], b: &[[f32; 3]]) -> (f64, f64) {
    assert_eq!(a.len(), b.len());
    let flat = |p: &[[f32; 3]]| -> Vec<f64> { p.iter().flatten().map(|&v| f64::from(v)).collect() };
    let (a, b) = (flat(a), flat(b));
    assert!(a.iter().all(|v| v.is_finite()), "a value of the picture is not finite");
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    let ratio = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
    let mut errors: Vec<f64> = a.iter().zip(&b).map(|(a, b)| ratio((a - b).abs(), mean)).collect();
    errors.sort_by(f64::total_cmp);
    let p99 = errors[(0.99 * errors.len() as f64).ceil() as usize - 1];
    (ratio(norm(&mut a.iter().zip(&b).map(|(a, b)| a - b)), norm(&mut b.iter().copied())), p99)
}

/// The bytes of a texture, layer after layer and row after row without padding; submits a copy and waits.
pub fn read_texture(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<u8> {
    let size = texture.size();
    let texel = texture.format().block_copy_size(None).unwrap();
    let stride = (texel * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("texture readback"),
        size: u64::from(stride * size.height * size.depth_or_array_layers),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(stride),
                rows_per_image: Some(size.height),
            },
        },
        size,
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let mapped = buffer.get_mapped_range(..).unwrap();
    let rows = mapped.chunks_exact(stride as usize);
    rows.flat_map(|row| row[..(texel * size.width) as usize].to_vec()).collect()
}

/// [`read_texture`] of 32-bit floats.
pub fn read_floats(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<f32> {
    read_texture(device, queue, texture)
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect()
}
