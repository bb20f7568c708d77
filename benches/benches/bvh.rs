//! The hierarchy: how long it takes to build, and how many rays a second each of its queries answers, on one core.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]

use std::hint::black_box;
use std::time::Duration;

use airlight_benches::Stage;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ground_truth::ExactShadows;
use scene::{Bvh, Interval, LightId, LitIntervals};

/// A deep interior and a single closed body, of like size.
const SCENES: [&str; 2] = ["hall", "blob-70k"];

/// Rays of each batch.
const RAYS: usize = 2048;

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bvh_build");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    for name in SCENES {
        let stage = Stage::new(name);
        group.throughput(Throughput::Elements(stage.scene.triangle_count() as u64));
        group.bench_function(name, |bencher| bencher.iter(|| Bvh::build(black_box(&stage.scene)).unwrap()));
    }
    group.finish();
}

fn queries(criterion: &mut Criterion) {
    for name in SCENES {
        let stage = Stage::new(name);
        let (bvh, rays) = (&stage.bvh, stage.rays(RAYS));
        let mut group = criterion.benchmark_group(format!("bvh_{name}"));
        group.throughput(Throughput::Elements(RAYS as u64));
        group.bench_function("closest_hit", |bencher| {
            bencher.iter(|| {
                rays.iter().filter(|ray| bvh.closest_hit(black_box(ray), f64::INFINITY).is_some()).count()
            });
        });
        let (points, lamp) = (stage.points(RAYS), stage.lamp());
        group.bench_function("blocked", |bencher| {
            bencher.iter(|| points.iter().filter(|p| bvh.blocked(black_box(**p), lamp - **p, 1.0)).count());
        });
        // what the exact reference does for a pixel, its hit and its airlight aside
        let shadows = ExactShadows::new(bvh, &stage.lights);
        let spans: Vec<Interval> = rays
            .iter()
            .map(|ray| {
                Interval::new(
                    0.0,
                    bvh.closest_hit(ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance),
                )
            })
            .collect();
        group.bench_function("lit_intervals", |bencher| {
            let mut lit = Vec::new();
            bencher.iter(|| {
                let mut pieces = 0;
                for (ray, span) in rays.iter().zip(&spans) {
                    shadows.lit_intervals(black_box(ray), *span, LightId(0), &mut lit);
                    pieces += lit.len();
                }
                pieces
            });
        });
        group.finish();
    }
}

criterion_group!(benches, build, queries);
criterion_main!(benches);
