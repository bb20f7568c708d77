//! A picture of fog without a window or a renderer: `cargo run --release --example headless -p gpu-backend [PNG]`.

use glam::Vec3;
use gpu_backend::{
    DepthDrawer, DrawnDepth, DrawnMap, Fog, FogDescriptor, Frame, GpuContext, Lamp, Sampling, Shadows,
    Technique, Triangles, View,
};
use scene::{AirlightModel, DirectionalLight, Light, Medium, procedural};
use shadowmap::{Bias, MapSurface, Projection};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = procedural::generate("hall")?;
    let (camera, size, side) = (&scene.cameras[0], (960, 540), (2048, 2048));
    // sunlight through the windows
    let light = &Light::Directional(DirectionalLight::new(Vec3::new(-1.0, -0.6, -0.3), Vec3::splat(10.0))?);
    let sigma = 0.5 / scene.bounds().diagonal();
    let medium = Medium::homogeneous([sigma; 3], [0.1 * sigma; 3])?;

    let gpu = GpuContext::headless(None)?;
    let mut fog = Fog::new(&gpu.device, &FogDescriptor::default())?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());

    // what the light and the camera see
    let (drawer, triangles) = (DepthDrawer::new(&gpu.device)?, Triangles::of_scene(&gpu.device, &scene)?);
    let casters = triangles.bounds();
    let projection = Projection::of_light(light, &casters, side)?;
    let map = DrawnMap::new(&gpu.device, projection, side, &casters, Bias::NONE)?;
    drawer.draw_map(&gpu.device, &mut encoder, &triangles, &map)?;
    let depth = DrawnDepth::new(&gpu.device, size)?;
    drawer.draw_view(&gpu.device, &mut encoder, &triangles, camera, &depth)?;

    // the exact lit pieces of every view ray
    let frame = Frame {
        views: &[View { camera, size, depth: depth.scene_depth(), max_distance: f64::INFINITY }],
        medium: &medium,
        lamps: &[Lamp { light, shadows: Some(Shadows::Map { map: map.map(), casters }), volume: None }],
        model: AirlightModel::Sun,
        technique: Technique::ExactShadowMap { surface: MapSurface::Step },
        sampling: Sampling::Pixels,
    };
    fog.prepare(&gpu.device, &gpu.queue, &frame)?;
    fog.encode(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let radiance = fog.read_airlight(&gpu.device, &gpu.queue, 0)?;

    // a plain exposure: four times the mean is white
    let white = 4.0 * radiance.iter().flatten().sum::<f32>() / (3 * radiance.len()) as f32;
    let byte = |value: f32| (255.0 * (value / white).min(1.0).powf(1.0 / 2.2)) as u8;
    let bytes = radiance.iter().flatten().map(|&value| byte(value)).collect();
    let path = std::env::args().nth(1).unwrap_or_else(|| "headless.png".into());
    image::RgbImage::from_raw(size.0, size.1, bytes).ok_or("the picture's size")?.save(path)?;
    Ok(())
}
