//! Frame after frame of every technique, with lights and cameras that move, media that change and windows that are
//! resized: memory stays where it was after the first rounds, nothing is said by the validation, and a frame that is
//! drawn again is the same to the last bit.
//!
//! `AIRLIGHT_SOAK_FRAMES` sets how many frames there are. Three figures tell whose memory grows: what this process has
//! allocated in Rust (this crate's and wgpu's), what wgpu has allocated on the device, and the resident memory, which
//! has the driver's own in it as well. Software drivers run in this process: lavapipe compiles a shader anew in every
//! dispatch where uniforms alone decide much of it, and keeps what it compiled, so that resident memory tells such shaders
//! as well; `each_technique_by_itself` tells whose they are. A process of its own, since it is the process's memory that is
//! looked at.
#![expect(unsafe_code, reason = "an allocator that counts")]
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "test code, and the figures behind its verdicts"
)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex};

use common::{Stage, fog, gpu, render};
use froxel_grid::{Froxels, GridMemory, Near, SharedGrid, Temporal};
use glam::Quat;
use gpu_backend::{
    Adaptive, Criterion, Faces, Fog, Frame, GpuBvh, GpuContext, Hybrid, Lamp, LightPicture, Lookup, Sampling,
    SceneDepth, ShadowCasters, ShadowMap, ShadowVolume, Shadows, Technique, Tessellation, View, wgpu,
};
use hybrid_march::Adjacency;
use media_math::PhaseFunction;
use scene::{AirlightModel, Camera, Light, LightTexture, Medium, SpotLight, TextureFilter, WideBvh};
use shadowmap::{Bias, MapSurface};

/// Frames where nothing else is asked for.
const USUAL_FRAMES: u32 = WARM_UP + 10 * ROUND;

/// Frames after which memory is to stay: by then every pipeline and every list is made.
const WARM_UP: u32 = 2 * ROUND;

/// Frames in which every technique has had both media: after them memory is compared, the last frames being of one size.
const ROUND: u32 = 2 * TECHNIQUES;

const TECHNIQUES: u32 = 11;

/// The window's sizes; units: pixels.
const SIZES: [(u32, u32); 5] = [(16, 12), (24, 8), (31, 17), (8, 8), (40, 24)];

/// What may come on top between the end of the warm-up and that of the last round: lists that double, pools that find
/// their size; units: bytes.
const SLACK: i64 = 256 << 10;

/// What may come on top of resident memory in the median round: what is compiled anew takes more in each frame; units: bytes.
const ROUND_SLACK: i64 = 128 << 10;

/// What may come on top of resident memory in all: at some time in one run of four a thread of the driver takes an arena of
/// the allocator for itself, 12 to 16 MB at once and never again; units: bytes.
const RESIDENT_SLACK: i64 = 32 << 20;

/// Counts what is allocated in Rust.
struct Counted;

static LIVE: AtomicI64 = AtomicI64::new(0);

// SAFETY: all of it is the system's allocator
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LIVE.fetch_add(layout.size() as i64, Ordering::Relaxed);
        // SAFETY: the caller's promise
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size() as i64, Ordering::Relaxed);
        // SAFETY: the caller's promise
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;

/// Memory at one time; units: bytes.
#[derive(Debug, Clone, Copy)]
struct Memory {
    /// Allocated in Rust.
    heap: i64,
    /// Allocated by wgpu on the device; 0 where it does not say.
    device: i64,
    /// Of this process; 0 where the system does not say.
    resident: i64,
}

impl Memory {
    fn now(gpu: &GpuContext) -> Self {
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let report = gpu.device.generate_allocator_report();
        let device = report.map_or(0, |report| report.total_allocated_bytes as i64);
        let status = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
        let pages = status.split_whitespace().nth(1).and_then(|pages| pages.parse::<i64>().ok());
        Self { heap: LIVE.load(Ordering::Relaxed), device, resident: 4096 * pages.unwrap_or(0) }
    }

    fn print(&self, what: &str) {
        let [heap, device, resident] = [self.heap, self.device, self.resident].map(|bytes| bytes >> 10);
        println!("{what}: {heap} KiB in Rust, {device} KiB on the device, {resident} KiB resident");
    }
}

/// What all frames have in common.
struct Soak {
    gpu: GpuContext,
    stage: Stage,
    bvh: GpuBvh,
    volume: ShadowVolume,
    picture: Arc<LightTexture>,
    /// What the validation said.
    said: Arc<Mutex<Vec<String>>>,
}

impl Soak {
    fn new() -> Option<Self> {
        let gpu = gpu()?;
        let said = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&said);
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            heard.lock().unwrap().push(error.to_string());
        }));
        let stage = Stage::procedural("slats", SIZES[0], 1.0);
        let bvh = GpuBvh::upload(&gpu.device, &WideBvh::build(&stage.scene).unwrap()).unwrap();
        let mesh = Adjacency::of_scene(&stage.scene).unwrap();
        let casters = ShadowCasters::upload(&gpu.device, &mesh).unwrap();
        let volume = ShadowVolume::new(&gpu.device, Arc::new(casters)).unwrap();
        let texels = (0..12).map(|i| [i as f32 / 11.0, 1.0, 0.5]).collect();
        let picture = Arc::new(LightTexture::new(4, 3, texels, TextureFilter::Linear).unwrap());
        Some(Self { gpu, stage, bvh, volume, picture, said })
    }

    /// A technique, whether its shadows are looked up in a map, the kind of its light (point, spot, directional, textured
    /// spot), and for which view rays it is computed.
    fn technique(&self, index: u32) -> (Technique, bool, usize, Sampling) {
        let range = 2.0 * self.stage.bvh.bounds().diagonal();
        let march = Technique::BruteForce { samples: 8, lookup: Lookup::Nearest };
        let hybrid = Hybrid { samples: 8, lit_samples: 4, refine: 2, ..Hybrid::default() };
        let volume = |tessellation| Technique::LightVolume { tessellation, kept: None };
        let froxels = Froxels { slices: 16, ..Froxels::new(range) };
        let near = Near::Frustum { side: 2, slices: 5 };
        let memory = GridMemory::Bricks { most: 512 };
        let grid = SharedGrid { near, memory, ..SharedGrid::marked(range / 40.0) };
        let temporal = Some(Temporal { frames: 4, keeps_changed: true });
        let (all, few) = (Sampling::Pixels, Sampling::Adaptive(Adaptive::default()));
        match index % TECHNIQUES {
            0 => (Technique::ExactShadowMap { surface: MapSurface::Step }, true, 0, few),
            1 => (Technique::ExactShadowMap { surface: MapSurface::Linear }, true, 2, all),
            2 => (march, true, 1, all),
            3 => (march, false, 0, few),
            4 => (Technique::Hybrid(Hybrid { faces: Faces::Pixels, ..hybrid }), true, 2, all),
            5 => (
                Technique::Hybrid(Hybrid { picture: LightPicture::Mips { blur: 0.5 }, ..hybrid }),
                true,
                3,
                all,
            ),
            6 => (Technique::Hybrid(hybrid), true, 0, Sampling::Blocks { scale: 2, anew_at_edges: true }),
            7 => (volume(Tessellation::IndexedGrid), true, 2, all),
            8 => {
                let criterion = Criterion::Distance;
                let adaptive = Tessellation::Adaptive { criterion, threshold: 0.01, most_leaves: 1 << 12 };
                (volume(adaptive), true, 1, all)
            }
            9 => (Technique::Froxels(froxels), false, 0, all),
            _ => (Technique::Froxels(Froxels { temporal, ..froxels }.with_grid(grid)), false, 1, all),
        }
    }

    /// The light of a kind, turned about the scene by an angle.
    fn light(&self, kind: usize, angle: f32) -> Light {
        let center = self.stage.bvh.bounds().center();
        let turn = Quat::from_rotation_y(angle);
        let mut light = self.stage.lights().remove([0, 1, 2, 1][kind]);
        match &mut light {
            Light::Point(light) => light.position = center + turn * (light.position - center),
            Light::Spot(light) => {
                let position = center + turn * (light.position - center);
                let SpotLight { inner, outer, intensity, .. } = *light;
                *light = SpotLight::new(position, center - position, inner, outer, intensity).unwrap();
                light.texture = (kind == 3).then(|| Arc::clone(&self.picture));
            }
            Light::Directional(light) => light.direction = turn * light.direction,
        }
        light
    }

    fn camera(&self, angle: f32) -> Camera {
        let camera = self.stage.camera.clone();
        let turn = Quat::from_axis_angle(camera.up, angle);
        Camera { right: turn * camera.right, forward: turn * camera.forward, ..camera }
    }

    /// Two media, with colour and without.
    fn medium(&self, index: u32) -> Medium {
        if index.is_multiple_of(2) {
            return self.stage.medium.clone();
        }
        let phase = PhaseFunction::henyey_greenstein(0.5).unwrap();
        Medium { phase, ..Medium::homogeneous([0.05, 0.1, 0.15], [0.01, 0.0, 0.02]).unwrap() }
    }

    /// One frame of a technique; its picture.
    fn draw(&self, fog: &mut Fog, index: u32, size: (u32, u32), medium: u32, angle: f32) -> Vec<[f32; 3]> {
        let Self { gpu, stage, .. } = self;
        let (technique, by_map, kind, sampling) = self.technique(index);
        let (light, camera, medium) =
            (self.light(kind, angle), self.camera(0.2 * angle.sin()), self.medium(medium));
        let surface = match technique {
            Technique::LightVolume { .. } => MapSurface::Linear,
            Technique::ExactShadowMap { surface } => surface,
            _ => MapSurface::Step,
        };
        let map = by_map.then(|| {
            let map = stage.map(&light, 33, surface).unwrap();
            ShadowMap::upload(&gpu.device, &gpu.queue, &map, Bias::NONE).unwrap()
        });
        let casters = stage.bvh.bounds();
        let shadows = match &map {
            Some(map) => Shadows::Map { map, casters },
            None => Shadows::Rays { bvh: &self.bvh, casters },
        };
        let ends: Vec<f32> = (0..size.0 * size.1)
            .map(|i| {
                let ray = camera.pixel_ray(i % size.0, i / size.0, size);
                stage.bvh.closest_hit(&ray, f64::INFINITY).map_or(f32::INFINITY, |hit| hit.distance as f32)
            })
            .collect();
        let depth = SceneDepth::Distances(&ends);
        let max_distance = 4.0 * f64::from(casters.diagonal());
        let view = View { camera: &camera, size, depth, max_distance };
        let frame = Frame {
            views: &[view, view][..if by_map { 1 } else { 2 }],
            medium: &medium,
            lamps: &[Lamp { light: &light, shadows: Some(shadows), volume: Some(&self.volume) }],
            model: AirlightModel::Sun,
            technique,
            sampling,
        };
        render(gpu, fog, &frame)
    }

    /// The frame that is drawn again and again.
    fn draw_again(&self, fog: &mut Fog, index: u32) -> Vec<[f32; 3]> {
        fog.forget();
        self.draw(fog, index, (20, 15), index, 0.3)
    }
}

#[test]
fn frames_leave_nothing_behind() {
    let Some(soak) = Soak::new() else { return };
    let asked: u32 =
        std::env::var("AIRLIGHT_SOAK_FRAMES").map_or(USUAL_FRAMES, |frames| frames.parse().unwrap());
    let frames = asked.max(USUAL_FRAMES).next_multiple_of(ROUND);
    let mut fog = fog(&soak.gpu);
    let first: Vec<_> = (0..TECHNIQUES).map(|index| soak.draw_again(&mut fog, index)).collect();
    assert!(
        first.iter().all(|picture| picture.iter().flatten().any(|&value| value > 0.0)),
        "a black picture"
    );
    let (mut warm, mut last, mut repeated) = (None, Memory::now(&soak.gpu), 0);
    let mut rounds = Vec::new();
    let start = std::time::Instant::now();
    for index in 0..frames {
        // another size for the first medium in every round
        let medium = index / TECHNIQUES % 2;
        let size = if medium == 0 { SIZES[1 + (index / ROUND) as usize % 4] } else { SIZES[0] };
        let picture = soak.draw(&mut fog, index, size, medium, 0.1 * index as f32);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "frame {index} is not finite");
        // another technique each time, seven being prime to how many there are
        if index % 7 == 6 {
            let again = index / 7 % TECHNIQUES;
            let picture = soak.draw_again(&mut fog, again);
            assert!(picture == first[again as usize], "technique {again} is another after {index} frames");
            repeated += 1;
        }
        let said = soak.said.lock().unwrap();
        assert!(said.is_empty(), "frame {index}: {said:?}");
        drop(said);
        if (index + 1) % ROUND == 0 {
            let now = Memory::now(&soak.gpu);
            if index + 1 > WARM_UP {
                rounds.push(now.resident - last.resident);
            }
            last = now;
            if index + 1 >= WARM_UP {
                warm.get_or_insert(last);
            }
            if (index + 1) % (20 * ROUND) == 0 || index < 3 * ROUND {
                last.print(&format!("{:5} frames, {:.0} s", index + 1, start.elapsed().as_secs_f64()));
            }
        }
    }
    let before = warm.unwrap();
    last.print(&format!("{frames} frames, {repeated} of them drawn again, on {}", soak.gpu.info.name));
    let (heap, device) = (last.heap - before.heap, last.device - before.device);
    let resident = last.resident - before.resident;
    rounds.sort_unstable();
    let median = rounds[rounds.len() / 2];
    println!(
        "grown by {heap} bytes in Rust, {device} on the device, {resident} resident, {median} of them in the median round"
    );
    assert!(heap <= SLACK && device <= SLACK, "{heap} bytes in Rust, {device} on the device");
    assert!(
        median <= ROUND_SLACK && resident <= RESIDENT_SLACK,
        "{resident} bytes resident, {median} in the median round: see each_technique_by_itself"
    );
}

/// Time and memory of each technique by itself: with nothing that changes, and with a light, a medium or a window that does.
#[test]
#[ignore = "measures the driver"]
fn each_technique_by_itself() {
    let Some(soak) = Soak::new() else { return };
    for index in 0..TECHNIQUES {
        let mut fog = fog(&soak.gpu);
        for change in ["nothing", "light", "medium", "size"] {
            let mut run = |frames: u32| {
                for frame in 0..frames {
                    let medium = if change == "medium" { frame % 2 } else { 0 };
                    let size = if change == "size" { SIZES[frame as usize % SIZES.len()] } else { SIZES[0] };
                    let angle = if change == "light" { 0.1 * frame as f32 } else { 0.3 };
                    soak.draw(&mut fog, index, size, medium, angle);
                }
                Memory::now(&soak.gpu)
            };
            let (before, start) = (run(10), std::time::Instant::now());
            let after = run(60);
            let ms = start.elapsed().as_secs_f64() * 1e3 / 60.0;
            let resident = (after.resident - before.resident) / 60 / 1024;
            let technique = soak.technique(index).0;
            println!("{resident} KiB resident and {ms:.1} ms a frame, {change} changes: {technique:?}");
        }
    }
}
