//! The airlight integral in every form, over the mix of cases of the reference set.
//!
//! Throughput counts evaluations, so that criterion's time an element is the time of one. The forms that take only
//! isotropic phase functions are compared on the isotropic part of the mix, all on the same cases. How far each is
//! from the truth, `cargo xtask repro airlight-accuracy` prints beside its time.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]

use std::hint::black_box;

use airlight_benches::{Problem, isotropic_problems, problems};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use media_math::{
    FTable, HomogeneousMedium, Interpolation, Real, Warp, airlight, airlight_closed_form, airlight_composite,
    airlight_equiangular,
};

/// Nodes of the fixed quadrature.
const NODES: usize = 16;

/// Measures `evaluate` over all problems.
fn measure<T: Real>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    problems: &[Problem<T>],
    evaluate: impl Fn(&Problem<T>) -> T,
) {
    assert!(!problems.is_empty(), "{name}: no case");
    group.throughput(Throughput::Elements(problems.len() as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for problem in problems {
                black_box(evaluate(black_box(problem)));
            }
        });
    });
}

fn default_form<T: Real>(p: &Problem<T>) -> T {
    airlight(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1)
}

fn forms(criterion: &mut Criterion) {
    let mix = isotropic_problems::<f32>();
    let mut group = criterion.benchmark_group("airlight_f32");
    measure(&mut group, "interval_default", &mix, default_form);
    measure(&mut group, "composite", &mix, |p| {
        airlight_composite(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1)
    });
    measure(&mut group, "closed_form", &mix, |p| {
        airlight_closed_form(&p.medium, p.intensity, &p.foot, p.x0, p.x1)
    });
    measure(&mut group, &format!("equiangular_{NODES}"), &mix, |p| {
        airlight_equiangular(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1, NODES)
    });
    for size in [256, 1024] {
        let table = FTable::<f32>::new(size, Warp::RationalSquared).unwrap();
        measure(&mut group, &format!("f_table_{size}_bilinear"), &mix, |p| {
            let (s, t) = (p.medium.sigma_s(), p.medium.sigma_t());
            table.airlight(s, t, p.intensity, &p.foot, p.x0, p.x1, Interpolation::Bilinear)
        });
    }
    group.finish();
}

fn branches(criterion: &mut Criterion) {
    let (short, long): (Vec<_>, Vec<_>) =
        isotropic_problems::<f32>().into_iter().partition(Problem::is_short);
    let mut group = criterion.benchmark_group("airlight_f32_branch");
    measure(&mut group, "short", &short, default_form);
    measure(&mut group, "long", &long, default_form);
    group.finish();
}

fn mixes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("airlight_f64");
    measure(&mut group, "interval_default", &isotropic_problems::<f64>(), default_form);
    group.finish();
    let mut group = criterion.benchmark_group("airlight_full_mix");
    measure(&mut group, "f32", &problems::<f32>(), default_form);
    measure(&mut group, "f64", &problems::<f64>(), default_form);
    group.finish();
    let mut group = criterion.benchmark_group("airlight_hg");
    let anisotropic = |p: &Problem<f32>| !p.phase.is_isotropic();
    measure(
        &mut group,
        "f32",
        &problems::<f32>().into_iter().filter(anisotropic).collect::<Vec<_>>(),
        default_form,
    );
    let anisotropic = |p: &Problem<f64>| !p.phase.is_isotropic();
    measure(
        &mut group,
        "f64",
        &problems::<f64>().into_iter().filter(anisotropic).collect::<Vec<_>>(),
        default_form,
    );
    group.finish();
}

/// Three channels: one integral where all are attenuated alike, three where they are not.
fn channels(criterion: &mut Criterion) {
    let mix = isotropic_problems::<f32>();
    let mut group = criterion.benchmark_group("airlight_f32_rgb");
    for (name, spread) in [("achromatic", 0.0), ("chromatic", 0.25_f32)] {
        let media: Vec<_> = mix
            .iter()
            .map(|p| {
                let (s, t) = (p.medium.sigma_s(), p.medium.sigma_t());
                let extinction = [t * (1.0 - spread), t, t * (1.0 + spread)];
                HomogeneousMedium::<f32, [f32; 3]>::with_extinction([s; 3], extinction).unwrap()
            })
            .collect();
        group.throughput(Throughput::Elements(mix.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for (p, medium) in mix.iter().zip(&media) {
                    let p = black_box(p);
                    black_box(airlight(medium, &p.phase, [p.intensity; 3], &p.foot, p.x0, p.x1));
                }
            });
        });
    }
    group.finish();
}

/// What the operations cost here that the forms are made of: the numbers behind a prediction of their time.
fn operations(criterion: &mut Criterion) {
    let values: Vec<f32> = (0..512).map(|i| 0.01 + 0.017 * i as f32).collect();
    let mut group = criterion.benchmark_group("operations_f32");
    group.throughput(Throughput::Elements(values.len() as u64));
    let mut measure = |name: &str, operation: fn(f32) -> f32| {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for value in &values {
                    black_box(operation(black_box(*value)));
                }
            });
        });
    };
    measure("divide", |x| 1.7 / x);
    measure("sqrt", f32::sqrt);
    measure("exp", |x| (-x).exp());
    measure("ln", f32::ln);
    measure("ln_1p", f32::ln_1p);
    measure("atan2", |x| x.atan2(1.7));
    measure("sin", f32::sin);
    measure("cos", f32::cos);
    group.finish();
}

criterion_group!(benches, operations, forms, branches, mixes, channels);
criterion_main!(benches);
