//! Memory over many frames; a process of its own, since it is the process's memory that is looked at.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "test code")]

mod common;

use common::{Stage, fog, gpu, upload};
use gpu_backend::{Frame, Lamp, Sampling, SceneDepth, Shadows, Technique, View, wgpu};
use scene::AirlightModel;
use shadowmap::MapSurface;

/// Memory of this process; units: bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096 * status.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
}

#[test]
fn memory_does_not_grow() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (16, 12), 1.0);
    let light = stage.lights().remove(0);
    let map = upload(&gpu, &stage.map(&light, 64, MapSurface::Step).unwrap());
    let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
    let mut fog = fog(&gpu);
    // commands are dropped: lavapipe keeps about 1 MiB of every dispatch of a long shader that runs
    let mut run = |frames: u32| {
        for index in 0..frames {
            // the window is resized now and then
            let size = if index % 100 < 90 { (16, 12) } else { (24, 8) };
            let view =
                View { camera: &stage.camera, size, depth: SceneDepth::Nothing, max_distance: f64::INFINITY };
            let frame = Frame {
                views: &[view],
                medium: &stage.medium,
                lamps: &[Lamp { light: &light, shadows, volume: None }],
                model: AirlightModel::Sun,
                technique: Technique::ExactShadowMap { surface: MapSurface::Step },
                sampling: Sampling::Pixels,
            };
            map.touch();
            fog.prepare(&gpu.device, &gpu.queue, &frame).unwrap();
            fog.encode(&mut gpu.device.create_command_encoder(&Default::default()));
            gpu.queue.submit([]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        }
        resident()
    };
    let (before, after) = (run(300), run(1000));
    println!("{} KiB after 300 frames, {} KiB after 1300", before >> 10, after >> 10);
    // a buffer and a bind group a frame would be several MiB
    assert!(after < before + (2 << 20));
}
