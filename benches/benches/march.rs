//! One row of a picture: the exact airlight against the brute-force march and the hybrid, on one core.
//!
//! The hybrid's preparation (edges, silhouette, faces) is a group of its own: a light that stands still keeps it.
//!
//! A march's time means nothing without its error, so the error of every row is printed before it is timed, against
//! the exact row: `rel_rmse`, and `shadow_err`, the share of what the shadows change at all.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]
#![expect(clippy::print_stderr, reason = "the error that stands beside a time")]

use std::time::Duration;

use airlight_benches::Stage;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use ground_truth::{Reference, Settings};
use hybrid_march::{Adjacency, BruteForce, FaceBounds, Hybrid, Occluders, ShadowVolume};
use scene::{AirlightModel, BvhVisibility, DRay};

/// A deep interior, where rays cross many shadows, and a single body.
const SCENES: [&str; 2] = ["hall", "blob-70k"];

/// Pixels of the row, which goes through the middle of the picture.
const WIDTH: u32 = 256;

/// Steps of the march; Wyman and Ramsey take 50 where they accelerate it and 150 where they do not.
const SAMPLES: [u32; 3] = [10, 50, 150];

/// Steps of the hybrid between the faces, its bisections of each boundary, and the side of a tile of faces in pixels.
const HYBRID_SAMPLES: [u32; 2] = [8, 32];
const REFINE: u32 = 6;
const TILE: u32 = 8;

/// ‖a − b‖₂.
fn distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt()
}

fn row(criterion: &mut Criterion) {
    for name in SCENES {
        let stage = Stage::new(name);
        let (bvh, medium, lights) = (&stage.bvh, &stage.medium, &stage.lights);
        let rays: Vec<(DRay, f64)> = (0..WIDTH)
            .map(|x| {
                let ray = stage.camera.pixel_ray(x, WIDTH / 2, (WIDTH, WIDTH));
                let end = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
                (ray, end)
            })
            .collect();
        let reference = |shadows_in_medium| {
            let settings = Settings { shadows_in_medium, ..Settings::default() };
            Reference::new(&[], bvh, medium, lights, settings).unwrap()
        };
        let (exact, open) = (reference(true), reference(false));
        let visibility = BvhVisibility::new(bvh, lights);
        let march = |samples| BruteForce {
            medium,
            lights,
            occluders: Some(Occluders { visibility: &visibility, bounds: bvh.bounds() }),
            samples,
            model: AirlightModel::Sun,
        };
        let exactly = |reference: &Reference<'_>| -> Vec<DVec3> {
            rays.iter().map(|(ray, end)| reference.airlight(ray, *end)).collect()
        };
        let marched = |samples: u32| -> Vec<DVec3> {
            let march = march(samples);
            rays.iter().map(|(ray, end)| march.airlight(ray, *end).airlight.as_dvec3()).collect()
        };
        let (truth, unshadowed) = (exactly(&exact), exactly(&open));
        let black = vec![DVec3::ZERO; truth.len()];

        let mut group = criterion.benchmark_group(format!("march_{name}"));
        group.throughput(Throughput::Elements(WIDTH.into())).sample_size(20);
        group.measurement_time(Duration::from_secs(4));
        group.bench_function("exact", |bencher| bencher.iter(|| exactly(&exact)));
        for samples in SAMPLES {
            let error = distance(&marched(samples), &truth);
            eprintln!(
                "march_{name}/brute_force/{samples}: rel_rmse {:.2e}, shadow_err {:.2e}",
                error / distance(&truth, &black),
                error / distance(&unshadowed, &truth)
            );
            group.bench_function(format!("brute_force/{samples}"), |bencher| {
                bencher.iter(|| marched(samples));
            });
        }
        let mesh = Adjacency::of_scene(&stage.scene).unwrap();
        let volumes: Vec<ShadowVolume> = lights.iter().map(|light| ShadowVolume::new(&mesh, light)).collect();
        let draw = |volume: &ShadowVolume| FaceBounds::draw(volume, &stage.camera, (WIDTH, WIDTH), TILE);
        let bounds: Vec<FaceBounds> = volumes.iter().map(draw).collect();
        let hybrid = |samples: u32| -> Vec<DVec3> {
            let occluders = Occluders { visibility: &visibility, bounds: bvh.bounds() };
            let march =
                Hybrid::new(medium, lights, Some(occluders), samples, REFINE, AirlightModel::Sun).unwrap();
            let pixel = |((ray, end), x): (&(DRay, f64), u32)| {
                let faces: Vec<_> = bounds.iter().map(|bounds| bounds.at(x, WIDTH / 2)).collect();
                march.airlight(ray, *end, &faces).airlight.as_dvec3()
            };
            rays.iter().zip(0..).map(pixel).collect()
        };
        for samples in HYBRID_SAMPLES {
            let error = distance(&hybrid(samples), &truth);
            eprintln!(
                "march_{name}/hybrid/{samples}: rel_rmse {:.2e}, shadow_err {:.2e}",
                error / distance(&truth, &black),
                error / distance(&unshadowed, &truth)
            );
            group.bench_function(format!("hybrid/{samples}"), |bencher| bencher.iter(|| hybrid(samples)));
        }
        group.bench_function("unshadowed", |bencher| bencher.iter(|| exactly(&open)));
        group.finish();

        let mut group = criterion.benchmark_group(format!("volumes_{name}"));
        group.sample_size(20).measurement_time(Duration::from_secs(4));
        group.bench_function("edges", |bencher| bencher.iter(|| Adjacency::of_scene(&stage.scene)));
        group.bench_function("silhouette", |bencher| {
            bencher.iter(|| lights.iter().map(|light| ShadowVolume::new(&mesh, light)).collect::<Vec<_>>());
        });
        group.bench_function("faces by tile", |bencher| {
            bencher.iter(|| volumes.iter().map(draw).collect::<Vec<_>>());
        });
        group.finish();
    }
}

criterion_group!(benches, row);
criterion_main!(benches);
