//! `shadow-rays`: shadow rays a second through a scene's hierarchy on the GPU and on the CPU, and how often they disagree.

use std::time::Instant;

use glam::Vec3;
use gpu_backend::{GpuBvh, OcclusionProbe, ShadowRay};
use rayon::prelude::*;
use scene::{Aabb, Bvh, WideBvh};

use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::{Failure, Outcome};
use crate::gpu;
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Section};
use crate::setups::Source;

/// Runs of which the fastest counts.
const RUNS: usize = 3;

/// Most of the rays that may differ: those that graze an edge.
const DIFFER: f64 = 1e-5;

fn count(preset: Preset) -> usize {
    match preset {
        Preset::Smoke => 1 << 14,
        Preset::Quick => 1 << 19,
        Preset::Standard | Preset::Paper => 1_000_000,
    }
}

/// Rays between points of a box: random pairs, or a grid of points towards one of them.
fn rays(bounds: &Aabb, count: usize, random: bool) -> Vec<ShadowRay> {
    let mut state = 11_u64;
    let mut number = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let extent = bounds.max - bounds.min;
    let light = bounds.min + extent * Vec3::new(0.41, 0.63, 0.57);
    let side = (count as f64).cbrt().ceil() as usize;
    (0..count)
        .map(|i| {
            let (origin, target) = if random {
                let mut point = || bounds.min + extent * Vec3::new(number(), number(), number());
                (point(), point())
            } else {
                let cell = Vec3::new((i % side) as f32, (i / side % side) as f32, (i / (side * side)) as f32);
                (bounds.min + extent * ((cell + 0.5) / side as f32), light)
            };
            ShadowRay { origin: origin.to_array(), direction: (target - origin).to_array(), far: 1.0 }
        })
        .collect()
}

/// Millions of rays a second, of the fastest of some runs, with what the last run found.
fn fastest<T>(count: usize, mut run: impl FnMut() -> Outcome<(f64, T)>) -> Outcome<(f64, T)> {
    let mut best: Option<(f64, T)> = None;
    for _ in 0..RUNS {
        let (seconds, found) = run()?;
        let least = best.as_ref().map_or(seconds, |(least, _)| seconds.min(*least));
        best = Some((least, found));
    }
    let (seconds, found) = best.ok_or_else(|| Failure::program("no run"))?;
    Ok((count as f64 / seconds / 1e6, found))
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let mut found = experiment(
        context,
        "shadow-rays",
        "Shadow rays through a hierarchy of triangles",
        "the visibility of the froxel reference (HPG 2023, §3)",
    );
    found.adapter = gpu_or_cpu(context);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut table = Table::new(
        "Shadow rays, in millions a second",
        vec![
            Column::left("scene"),
            Column::right("triangles"),
            Column::left("rays"),
            Column::right("blocked"),
            Column::right("GPU"),
            Column::right(format!("CPU, {cores} threads")),
            Column::right("that differ"),
            Column::right("on the GPU"),
        ],
    );
    let mut worst: Option<f64> = None;
    for source in sources(context) {
        let setup = source.setup(0.3)?;
        let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
        for random in [true, false] {
            let rays = rays(&bvh.bounds(), count(context.preset), random);
            tracing::info!("{}: {} rays", source.title(), rays.len());
            let on_cpu = || {
                let started = Instant::now();
                let blocked: Vec<bool> = rays
                    .par_iter()
                    .map(|ray| bvh.blocked(ray.origin.into(), ray.direction.into(), ray.far))
                    .collect();
                Ok((started.elapsed().as_secs_f64(), blocked))
            };
            let (cpu, expected) = fastest(rays.len(), on_cpu)?;
            let mut gpu_rate = None;
            let mut differ = None;
            let mut bytes = None;
            if let Some(adapter) = &context.gpu {
                let wide = WideBvh::build(&setup.scene).map_err(Failure::program)?;
                let on_gpu = GpuBvh::upload(&adapter.device, &wide).map_err(Failure::program)?;
                let probe = OcclusionProbe::new(adapter).map_err(Failure::program)?;
                let (rate, blocked) = fastest(rays.len(), || {
                    let traced = probe.trace(&on_gpu, &rays).map_err(Failure::program)?;
                    // a software driver's stamps are not those of the work
                    let stamped = traced.gpu_time.filter(|_| gpu::is_hardware(adapter));
                    Ok((stamped.unwrap_or(traced.wall_time).as_secs_f64(), traced.blocked))
                })?;
                let different = blocked.iter().zip(&expected).filter(|(a, b)| a != b).count();
                let share = different as f64 / rays.len() as f64;
                worst = Some(worst.unwrap_or(0.0).max(share));
                (gpu_rate, differ, bytes) = (Some(rate), Some(different as u64), Some(on_gpu.bytes()));
            }
            let blocked = expected.iter().filter(|blocked| **blocked).count() as f64 / rays.len() as f64;
            table.push(vec![
                source.title(),
                report::count(setup.scene.triangle_count() as u64),
                if random { "random pairs of points" } else { "a grid of points to one light" }.into(),
                format!("{:.0} %", 100.0 * blocked),
                report::figure(gpu_rate),
                report::figure(cpu),
                report::count(differ),
                report::bytes(bytes),
            ]);
        }
    }
    table.note = Some("Error and time of a shadow ray: how many differ from the CPU's, and the fastest of three runs; on a GPU of hardware by its own clock, else by the wall clock with the copies.".into());
    found.checks.push(Check::new(
        "GPU and CPU agree on all shadow rays but those that graze an edge: largest share that differs",
        "both test the same triangles in f32",
        worst,
        Bound::AtMost,
        DIFFER,
    ));
    let mut section = Section::default();
    section.tables.push(table);
    section.experiment = found;
    Ok(section)
}

/// Sponza where it is given, and the hall.
fn sources(context: &Context) -> Vec<Source> {
    super::map_traversal::sources(context)
}
