//! Froxels on the CPU: the reference beside the shared grid, for one viewer and for eight side by side, and what of it is
//! tracing.
//!
//! A time means nothing without its error, so the error of every picture is printed before it is timed: `shadow_err`
//! against the reference, the share of what the shadows change at all. The reference's own error against the exact picture
//! is in `cargo xtask repro grid-convergence`.
#![expect(clippy::unwrap_used, reason = "a benchmark whose input is broken must stop")]
#![expect(clippy::print_stderr, reason = "the error that stands beside a time")]

use std::hint::black_box;
use std::time::Duration;

use airlight_benches::Stage;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use froxel_grid::{Frame, FroxelFog, Froxels, GridMemory, Occluders, Rendered, SharedGrid, View};
use glam::Quat;
use scene::{AirlightModel, BvhVisibility, Camera};

const SCENE: &str = "hall";

/// Side of each viewer's picture; units: pixels.
const SIDE: u32 = 128;

/// Side of a voxel; units: m.
const VOXEL: f32 = 0.25;

const VIEWERS: [usize; 2] = [1, 8];

/// The scene's camera, turned a little further and set a step aside for each viewer.
fn cameras(first: &Camera, count: usize) -> Vec<Camera> {
    let nth = |index: usize| {
        let turn = Quat::from_axis_angle(first.up, 0.15 * index as f32);
        Camera {
            position: first.position + 0.1 * index as f32 * first.right,
            right: turn * first.right,
            forward: turn * first.forward,
            ..first.clone()
        }
    };
    (0..count).map(nth).collect()
}

/// ‖a − b‖₂ over all viewers.
fn distance(a: &Rendered, b: &Rendered) -> f64 {
    let pixels = |rendered: &Rendered| rendered.airlight.concat();
    let squares = pixels(a).iter().zip(pixels(b)).map(|(a, b)| f64::from(a.distance_squared(b))).sum::<f64>();
    squares.sqrt()
}

fn froxels(criterion: &mut Criterion) {
    let stage = Stage::new(SCENE);
    let Stage { bvh, medium, lights, .. } = &stage;
    let visibility = BvhVisibility::new(bvh, lights);
    let range = bvh.bounds().diagonal();
    for viewers in VIEWERS {
        let cameras = cameras(&stage.camera, viewers);
        let end = |camera: &Camera, pixel: u32| {
            let ray = camera.pixel_ray(pixel % SIDE, pixel / SIDE, (SIDE, SIDE));
            bvh.closest_hit(&ray, f64::INFINITY).map_or(f32::INFINITY, |hit| hit.distance as f32)
        };
        let ends: Vec<Vec<f32>> =
            cameras.iter().map(|camera| (0..SIDE * SIDE).map(|pixel| end(camera, pixel)).collect()).collect();
        let views: Vec<View<'_>> = cameras
            .iter()
            .zip(&ends)
            .map(|(camera, ends)| View { camera, size: (SIDE, SIDE), ends })
            .collect();
        let open = Frame { views: &views, medium, lights, model: AirlightModel::Sun, occluders: None };
        let frame =
            Frame { occluders: Some(Occluders { visibility: &visibility, bounds: bvh.bounds() }), ..open };
        let reference = Froxels::new(range);
        let (paper, marked) = (SharedGrid::paper(VOXEL), SharedGrid::marked(VOXEL));
        let bricks = SharedGrid { memory: GridMemory::Bricks { most: 1 << 13 }, ..marked };
        let settings = [
            ("no shadows", reference, &open),
            ("reference", reference, &frame),
            ("the paper's grid", reference.with_grid(paper), &frame),
            ("marked voxels", reference.with_grid(marked), &frame),
            ("marked voxels in bricks", reference.with_grid(bricks), &frame),
        ];
        let once = |froxels: Froxels, frame: &Frame<'_>| {
            let mut fog = FroxelFog::new(froxels).unwrap();
            // every other layer of voxels is traced in the second frame
            fog.render(frame).unwrap();
            fog.render(frame).unwrap()
        };
        let (truth, unshadowed) = (once(reference, &frame), once(reference, &open));
        let mut group = criterion.benchmark_group(format!("froxels_{viewers}_viewers"));
        group.throughput(Throughput::Elements(viewers as u64 * u64::from(SIDE).pow(2)));
        group.sample_size(10).measurement_time(Duration::from_secs(4));
        for (name, froxels, frame) in settings {
            let rendered = once(froxels, frame);
            let error = distance(&rendered, &truth) / distance(&unshadowed, &truth);
            let rays = rendered.counts.rays();
            eprintln!("froxels_{viewers}_viewers/{name}: shadow_err {error:.2e}, {rays} shadow rays");
            let mut fog = FroxelFog::new(froxels).unwrap();
            group.bench_function(name, |bencher| bencher.iter(|| fog.render(black_box(frame)).unwrap()));
        }
        group.finish();
    }
}

criterion_group!(benches, froxels);
criterion_main!(benches);
