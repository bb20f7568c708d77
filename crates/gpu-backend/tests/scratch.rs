mod common;
use common::*;
use glam::Vec3;
use gpu_backend::*;
use scene::*;
use shadowmap::MapSurface;

fn time(
    gpu: &GpuContext,
    fog: &mut Fog,
    stage: &Stage,
    light: &Light,
    map: &ShadowMap,
    technique: Technique,
    frames: usize,
) -> (Vec<[f32; 3]>, f64, f64) {
    let ends = stage.ends_f32();
    let view = View {
        camera: &stage.camera,
        size: stage.size,
        depth: SceneDepth::Distances(&ends),
        max_distance: f64::INFINITY,
    };
    let shadows = Some(Shadows { map, casters: stage.bvh.bounds() });
    let frame = Frame {
        views: &[view],
        medium: &stage.medium,
        lamps: &[Lamp { light, shadows }],
        model: AirlightModel::Sun,
        technique,
    };
    fog.prepare(&gpu.device, &gpu.queue, &frame).unwrap();
    let mut walls = vec![];
    let mut gpus = vec![];
    for _ in 0..frames {
        fog.prepare(&gpu.device, &gpu.queue, &frame).unwrap();
        let t = std::time::Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        fog.encode(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        walls.push(t.elapsed().as_secs_f64() * 1e3);
        let times = fog.pass_times(&gpu.device, &gpu.queue).unwrap();
        gpus.push(times.iter().filter_map(|t| t.ms).sum::<f64>());
    }
    walls.sort_by(f64::total_cmp);
    gpus.sort_by(f64::total_cmp);
    (fog.read_airlight(&gpu.device, &gpu.queue, 0).unwrap(), walls[frames / 2], gpus[frames / 2])
}

#[test]
fn timing() {
    let gpu = gpu().unwrap();
    let mut fog = fog(&gpu);
    let folder = std::env::var("SCENES").unwrap();
    let n: u32 = std::env::var("SIDE").map(|s| s.parse().unwrap()).unwrap_or(512);
    let map_side: u32 = std::env::var("MAP").map(|s| s.parse().unwrap()).unwrap_or(512);
    let sponza =
        scene::import::load_gltf(std::path::Path::new(&format!("{folder}/sponza_dabrovic_66k.glb"))).unwrap();
    let camera =
        Camera::look_at(Vec3::new(-11.0, 1.6, 0.4), Vec3::new(6.0, 2.6, 0.0), Vec3::Y, 60f32.to_radians())
            .unwrap();
    let mut stages = vec![];
    if std::env::var("HALL").is_err() {
        let mut stage = Stage::new("sponza", sponza, camera, (n, n), 1.0);
        stage.medium = Medium::homogeneous([0.3 / 17.0; 3], [0.0; 3]).unwrap();
        let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        let lights = vec![
            Light::Point(PointLight::new(p(-4.29, 1.79, 6.74), Vec3::splat(300.0)).unwrap()),
            Light::Spot(
                SpotLight::new(p(3.0, 9.0, 2.5), p(-1.0, -1.0, -0.35), 0.5, 0.7, Vec3::splat(300.0)).unwrap(),
            ),
            Light::Directional(DirectionalLight::new(p(0.4, -1.0, 0.3), Vec3::splat(3.0)).unwrap()),
        ];
        stages.push((stage, lights));
    }
    let mut hall = Stage::procedural("hall", (n, n), 1.0);
    hall.medium = Medium::homogeneous([0.3 / 20.0; 3], [0.0; 3]).unwrap();
    let lights = hall.lights();
    stages.push((hall, lights));
    for (stage, lights) in &stages {
        for (kind, light) in ["point", "spot", "sun"].iter().zip(lights) {
            for surface in [MapSurface::Step, MapSurface::Linear]
                .into_iter()
                .take(if std::env::var("STEP").is_ok() { 1 } else { 2 })
            {
                let map = stage.map(light, map_side, surface).unwrap();
                let on = upload(&gpu, &map);
                let (exact, wall, ms) =
                    time(&gpu, &mut fog, stage, light, &on, Technique::ExactShadowMap { surface }, 5);
                let (_, _, closed) = {
                    let ends = stage.ends_f32();
                    let view = View {
                        camera: &stage.camera,
                        size: stage.size,
                        depth: SceneDepth::Distances(&ends),
                        max_distance: f64::INFINITY,
                    };
                    let frame = Frame {
                        views: &[view],
                        medium: &stage.medium,
                        lamps: &[Lamp { light, shadows: None }],
                        model: AirlightModel::Sun,
                        technique: Technique::ExactShadowMap { surface },
                    };
                    fog.prepare(&gpu.device, &gpu.queue, &frame).unwrap();
                    let t = std::time::Instant::now();
                    let mut encoder = gpu.device.create_command_encoder(&Default::default());
                    fog.encode(&mut encoder);
                    gpu.queue.submit([encoder.finish()]);
                    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
                    println!("= closed wall {:.1}", t.elapsed().as_secs_f64() * 1e3);
                    let times = fog.pass_times(&gpu.device, &gpu.queue).unwrap();
                    ((), (), times.iter().filter_map(|t| t.ms).sum::<f64>())
                };
                if std::env::var("COUNT").is_ok() {
                    for c in 0..3 {
                        let mut v: Vec<f32> = exact.iter().map(|p| p[c]).collect();
                        v.sort_by(f32::total_cmp);
                        println!(
                            "= {c}: mean {:.1} median {} 99% {} max {}",
                            v.iter().sum::<f32>() / v.len() as f32,
                            v[v.len() / 2],
                            v[v.len() * 99 / 100],
                            v[v.len() - 1]
                        );
                    }
                }
                println!("= closed {closed:.1}");
                let open = stage.on_gpu(&gpu, &mut fog, light, None, Technique::ExactShadowMap { surface });
                let norm = |a: &[[f32; 3]], b: &[[f32; 3]]| {
                    a.iter()
                        .flatten()
                        .zip(b.iter().flatten())
                        .map(|(a, b)| f64::from(a - b).powi(2))
                        .sum::<f64>()
                        .sqrt()
                };
                let weight = norm(&open, &exact);
                let zero = vec![[0f32; 3]; exact.len()];
                println!(
                    "= {} {kind} {surface:?}: exact wall {wall:.1} gpu {ms:.1}; weight {:.2}",
                    stage.name,
                    weight / norm(&exact, &zero)
                );
                let lookup =
                    if surface == MapSurface::Step { Lookup::Nearest } else { Lookup::LinearSurface };
                let mut line = String::new();
                if std::env::var("EXACT").is_ok() {
                    continue;
                }
                let mut before: Option<(f64, f64)> = None;
                let mut targets = vec![0.01, 0.002];
                for samples in [15, 30, 60, 120, 250, 500, 1000, 2000] {
                    let (got, wall, ms) =
                        time(&gpu, &mut fog, stage, light, &on, Technique::BruteForce { samples, lookup }, 1);
                    let e = norm(&got, &exact) / weight;
                    line += &format!("  {samples}: {e:.5} {ms:.0}ms({wall:.0})");
                    while let Some(&t) = targets.first() {
                        if e <= t {
                            let at = before.map_or(ms, |(m0, e0)| {
                                let k = (e0 / t).ln() / (e0 / e).ln();
                                m0 * (ms / m0).powf(k)
                            });
                            line += &format!("  [{t}: {at:.0}ms]");
                            targets.remove(0);
                        } else {
                            break;
                        }
                    }
                    before = Some((ms, e));
                    if targets.is_empty() {
                        break;
                    }
                }
                println!("= {line}");
            }
        }
    }
}
