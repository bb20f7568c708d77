//! Fog in a renderer that has its own device, depth buffer and shadow map: one pass more.
//!
//! `cargo run --release --example host -p gpu-backend [PNG]`. The four steps below are all that fog asks for; the renderer
//! in `renderer.rs` knows nothing of it, but for the `TEXTURE_BINDING` usage of its depth textures.

mod renderer;

use glam::{DMat4, DVec2, Vec3};
use gpu_backend::{
    CompositeTarget, Fog, FogDescriptor, Frame, HostDepth, Lamp, Sampling, SceneDepth, ShadowMap, Shadows,
    Technique, View,
};
use renderer::{COLOR, DEPTH, Renderer, begin, texture};
use scene::{AirlightModel, Camera, Light, Medium, SpotLight, procedural};
use shadowmap::{Bias, DepthOrder, Face, MapSurface, Projection};

const SIZE: (u32, u32) = (960, 540);
const MAP: (u32, u32) = (2048, 2048);
/// This renderer draws depth from 0 at the near plane to 1 at the far plane; units: m.
const ORDER: DepthOrder = DepthOrder::Forward;
const NEAR: f32 = 0.1;
const FAR: f32 = 100.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = procedural::generate("hall")?;
    let (camera, casters) = (&scene.cameras[0], scene.bounds());
    let position = Vec3::new(30.0, 12.0, 2.0);
    let spot = SpotLight::new(position, Vec3::new(0.0, 3.0, -4.0) - position, 0.3, 0.35, Vec3::splat(2e4))?;
    let projection = Projection::spot(&spot)?;
    let lamp = position.extend(spot.intensity.x);
    let light_clip = projection.faces()[0].clip_from_world(ORDER, NEAR, FAR)?;
    let light = Light::Spot(spot);
    let renderer = Renderer::new(&scene.meshes)?;
    let (device, queue) = (&renderer.device, &renderer.queue);
    let (color, depth, light_depth) =
        (texture(device, SIZE, COLOR), texture(device, SIZE, DEPTH), texture(device, MAP, DEPTH));

    // 1. once: say what the fog will be drawn into
    let target = CompositeTarget { depth_format: Some(DEPTH), ..CompositeTarget::picture(COLOR) };
    let mut fog = Fog::new(device, &FogDescriptor { target: Some(target), ..Default::default() })?;
    // ... and which of the renderer's textures is the light's map; if something moves, call `map.touch()` every frame
    let host = HostDepth { texture: &light_depth, order: ORDER, near: NEAR, far: FAR };
    let map = ShadowMap::from_host(device, host, projection, Bias::NONE)?;

    // 2. every frame: what there is. Nothing is submitted
    fog.prepare(
        device,
        queue,
        &Frame {
            views: &[View {
                camera,
                size: SIZE,
                depth: SceneDepth::Buffer { texture: &depth, order: ORDER, near: NEAR, far: FAR },
                max_distance: f64::from(FAR),
            }],
            medium: &Medium::homogeneous([0.03; 3], [0.003; 3])?,
            lamps: &[Lamp {
                light: &light,
                shadows: Some(Shadows::Map { map: &map, casters }),
                volume: None,
            }],
            model: AirlightModel::Sun,
            technique: Technique::ExactShadowMap { surface: MapSurface::Step },
            sampling: Sampling::Pixels,
        },
    )?;

    let mut encoder = device.create_command_encoder(&Default::default());
    renderer.draw(&mut encoder, light_clip, light_clip, lamp, None, &light_depth);
    renderer.draw(&mut encoder, camera_clip(camera)?, light_clip, lamp, Some((&color, &light_depth)), &depth);
    // 3. after depth is drawn: the fog's own passes
    fog.encode(&mut encoder);
    // 4. over the picture, in a pass of the renderer's: its depth attachment is neither tested nor written
    fog.composite(&mut begin(&mut encoder, Some(&color), &depth, false), 0);
    queue.submit([encoder.finish()]);

    let path = std::env::args().nth(1).unwrap_or_else(|| "host.png".into());
    image::RgbaImage::from_raw(SIZE.0, SIZE.1, renderer.pixels(&color)?)
        .ok_or("the picture's size")?
        .save(path)?;
    Ok(())
}

/// Clip space of the camera: a face's matrix is the usual one, x right, y up, depth in [0, 1].
fn camera_clip(camera: &Camera) -> Result<DMat4, shadowmap::ShadowMapError> {
    let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|axis| axis.as_dvec3());
    let half = (0.5 * f64::from(camera.fov_y)).tan() * DVec2::new(f64::from(SIZE.0) / f64::from(SIZE.1), 1.0);
    let origin = camera.position.as_dvec3();
    Face { origin, right, down: -up, forward, half, perspective: true }.clip_from_world(ORDER, NEAR, FAR)
}
