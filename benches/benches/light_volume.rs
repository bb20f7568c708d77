//! Light volumes on one core: building them beside the min-max pyramid that the exact traversal of the same map needs, and
//! a small picture by their crossings beside that traversal and the march.
//!
//! A time means nothing without its error, so the error of every picture is printed before it is timed, against the
//! traversal in f64: `shadow_err`, the share of what the shadows change at all.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]
#![expect(clippy::print_stderr, reason = "the error that stands beside a time")]

use std::hint::black_box;
use std::time::Duration;

use airlight_benches::Stage;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use ground_truth::{Reference, Settings};
use hybrid_march::{BruteForce, Occluders};
use lightvolume::{Anchor, LightVolume, LightVolumes, Options, SignedAirlight, Tessellation};
use scene::{AirlightModel, DRay, Light, SpotLight};
use shadowmap::{
    Bias, DepthMap, ExactShadowMap, MapSurface, MinMaxPyramid, SurfaceVisibility, draw_maps_for,
};

const SCENE: &str = "hall";

/// Sides of the maps that volumes are built of.
const BUILT: [u32; 2] = [256, 1024];

/// Side of the map that pictures are made with.
const MAP: u32 = 1024;

/// Side of the pictures.
const SIDE: u32 = 64;

/// Steps of the march: few, and the number of Billeter et al. for a picture of equal quality.
const SAMPLES: [u32; 2] = [64, 400];

/// Threshold of adaptive tessellations, as a share of the scene's diagonal.
const THRESHOLD: f32 = 1e-3;

/// A lamp on the floor that shines through the columns.
fn spot() -> Light {
    let (from, to) = (Vec3::new(-6.33, 3.21, -7.16), Vec3::new(1.18, 0.48, 6.06));
    let [inner, outer] = [25.0_f32, 35.0].map(f32::to_radians);
    Light::Spot(SpotLight::new(from, to - from, inner, outer, Vec3::splat(300.0)).unwrap())
}

fn map_of(stage: &Stage, side: u32) -> Vec<Option<DepthMap>> {
    draw_maps_for(&stage.lights, &stage.scene, side, MapSurface::Linear).unwrap()
}

fn adaptive(stage: &Stage, criterion: lightvolume::Criterion) -> Options {
    let threshold = THRESHOLD * stage.scene.bounds().diagonal();
    Options::new(Tessellation::Adaptive { criterion, threshold })
}

fn stage() -> Stage {
    Stage { lights: vec![spot()], ..Stage::new(SCENE) }
}

fn build(criterion: &mut Criterion) {
    let stage = stage();
    for side in BUILT {
        let maps = map_of(&stage, side);
        let map = maps[0].as_ref().unwrap();
        let mut group = criterion.benchmark_group(format!("light_volume_build_{side}"));
        group.throughput(Throughput::Elements(u64::from(side).pow(2)));
        group.sample_size(20).measurement_time(Duration::from_secs(3));
        group.bench_function("min-max pyramid", |bencher| {
            bencher.iter(|| MinMaxPyramid::of_cells(black_box(map), 0));
        });
        let tessellations = [
            ("static", Options::default()),
            ("adaptive, distance", adaptive(&stage, lightvolume::Criterion::Distance)),
            ("adaptive, Laplacian", adaptive(&stage, lightvolume::Criterion::Laplacian)),
        ];
        for (name, options) in tessellations {
            let volume = LightVolume::build(map, &options).unwrap();
            eprintln!("light_volume_build_{side}/{name}: {} triangles", volume.triangles().len());
            group.bench_function(name, |bencher| {
                bencher.iter(|| LightVolume::build(black_box(map), &options).unwrap());
            });
            let volumes = [Some(volume)];
            group.bench_function(format!("{name}, boxes for rays"), |bencher| {
                bencher.iter(|| LightVolumes::new(black_box(&volumes), &stage.lights).unwrap());
            });
        }
        group.finish();
    }
}

/// ‖a − b‖₂.
fn distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt()
}

fn picture(criterion: &mut Criterion) {
    let stage = stage();
    let Stage { bvh, camera, medium, lights, .. } = &stage;
    let maps = map_of(&stage, MAP);
    let rays: Vec<(DRay, f64)> = (0..SIDE * SIDE)
        .map(|pixel| {
            let ray = camera.pixel_ray(pixel % SIDE, pixel / SIDE, (SIDE, SIDE));
            let end = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            (ray, end)
        })
        .collect();
    let all = |airlight: &dyn Fn(&DRay, f64) -> DVec3| -> Vec<DVec3> {
        rays.iter().map(|(ray, end)| airlight(ray, *end)).collect()
    };
    let reference = |shadows_in_medium| {
        let settings = Settings { shadows_in_medium, ..Settings::default() };
        Reference::new(&[], bvh, medium, lights, settings).unwrap()
    };
    let traversal = ExactShadowMap::new(&maps, lights, MapSurface::Linear, Bias::NONE).unwrap();
    let (exact, open) = (reference(true).with_shadows(&traversal), reference(false));
    let (truth, unshadowed) =
        (all(&|ray, end| exact.airlight(ray, end)), all(&|ray, end| open.airlight(ray, end)));
    let built = |options: &Options| {
        maps.iter()
            .map(|map| map.as_ref().map(|map| LightVolume::build(map, options).unwrap()))
            .collect::<Vec<_>>()
    };
    let cells = built(&Options::default());
    let leaves = built(&adaptive(&stage, lightvolume::Criterion::Distance));
    let [cells, leaves] = [&cells, &leaves].map(|volumes| LightVolumes::new(volumes, lights).unwrap());
    let visibility = SurfaceVisibility::new(&maps, MapSurface::Linear, Bias::NONE);
    let march = |samples| BruteForce {
        medium,
        lights,
        occluders: Some(Occluders { visibility: &visibility, bounds: bvh.bounds() }),
        samples,
        model: AirlightModel::Sun,
    };
    let [marched_64, marched_400] = SAMPLES.map(march);
    let by_cells = reference(true).with_shadows(&cells);
    let by_leaves = reference(true).with_shadows(&leaves);
    let signed = SignedAirlight::<f32>::new(medium, &leaves, Anchor::Near).unwrap();

    let mut group = criterion.benchmark_group("light_volume_picture");
    group.throughput(Throughput::Elements(u64::from(SIDE).pow(2)));
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    let mut measure = |name: &str, airlight: &dyn Fn(&DRay, f64) -> DVec3| {
        let error = distance(&all(airlight), &truth) / distance(&unshadowed, &truth);
        eprintln!("light_volume_picture/{name}: shadow_err {error:.2e}");
        group.bench_function(name, |bencher| bencher.iter(|| all(airlight)));
    };
    measure("exact traversal", &|ray, end| exact.airlight(ray, end));
    measure("static", &|ray, end| by_cells.airlight(ray, end));
    measure("adaptive", &|ray, end| by_leaves.airlight(ray, end));
    measure("adaptive, signed f32", &|ray, end| DVec3::from(signed.airlight(ray, end).map(f64::from)));
    measure("brute force, 64 steps", &|ray, end| marched_64.airlight(ray, end).airlight.as_dvec3());
    measure("brute force, 400 steps", &|ray, end| marched_400.airlight(ray, end).airlight.as_dvec3());
    measure("unshadowed", &|ray, end| open.airlight(ray, end));
    group.finish();
}

criterion_group!(benches, build, picture);
criterion_main!(benches);
