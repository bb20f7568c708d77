//! With marked voxels and nearest reads the grid never traces more rays than the reference.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod support;

use froxel_grid::{Froxels, GridMemory, MaskWidth, Near, SharedGrid, Update};
use glam::Vec3;
use proptest::prelude::*;
use scene::{Camera, DirectionalLight, Light, Medium, Mesh, PointLight, Scene, SpotLight};
use support::Stage;

/// A number in [0, 1) for each seed and index.
fn hash(seed: u32, i: u32) -> f32 {
    let mut h = seed.wrapping_mul(0x9e37_79b9) ^ i.wrapping_mul(0x85eb_ca6b);
    for _ in 0..2 {
        h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    }
    (h >> 8) as f32 / 16_777_216.0
}

fn point(seed: u32, i: u32) -> Vec3 {
    Vec3::new(hash(seed, 3 * i), hash(seed, 3 * i + 1), hash(seed, 3 * i + 2)) * 4.0 - 2.0
}

/// A few triangles, lights of all kinds, and viewers that see much or little of the same; `apart` in [0, 1].
fn small_stage(seed: u32, triangles: u32, lights: u32, viewers: u32, apart: f32) -> Stage {
    let positions = (0..3 * triangles).map(|i| point(seed, i / 3) + 0.3 * point(seed ^ 1, i)).collect();
    let corners = (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let scene = Scene { meshes: vec![Mesh::new(positions, corners, 0).unwrap()], ..Scene::default() };
    let light = |i: u32| {
        let (position, power) = (2.0 * point(seed ^ 2, i), Vec3::splat(1.0 + hash(seed ^ 3, i)));
        match i % 3 {
            0 => Light::Point(PointLight::new(position, power).unwrap()),
            1 => Light::Spot(SpotLight::new(position, -position, 0.2, 0.8, power).unwrap()),
            _ => Light::Directional(DirectionalLight::new(position, power).unwrap()),
        }
    };
    let camera = |i: u32| {
        let eye = Vec3::new(0.0, 0.5, 6.0) + apart * 2.0 * point(seed ^ 4, i);
        Camera::look_at(eye, apart * point(seed ^ 5, i), Vec3::Y, 0.8).unwrap()
    };
    let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
    Stage::new(scene, medium, (0..lights).map(light).collect(), (0..viewers).map(camera).collect(), (40, 32))
}

fn near() -> impl Strategy<Value = Near> {
    prop_oneof![
        Just(Near::Grid),
        (1_u32..5, 0_u32..24).prop_map(|(side, slices)| Near::Frustum { side, slices }),
        (2_u32..5, 1_u32..24).prop_map(|(ratio, slices)| Near::FineGrid { ratio, slices }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn never_more_than_the_reference(
        seed: u32,
        triangles in 1_u32..12,
        lights in 1_u32..11,
        viewers in 1_u32..7,
        apart in 0.0_f32..1.0,
        voxel_size in 0.02_f32..3.0,
        near in near(),
        alternate: bool,
        bricks: bool,
        wide: bool,
    ) {
        let stage = small_stage(seed, triangles, lights, viewers, apart);
        let froxels = Froxels { tile: 8, slices: 24, ..Froxels::new(12.0) };
        let sparse = bricks || matches!(near, Near::FineGrid { .. });
        let grid = SharedGrid {
            near,
            update: Update::Marked { alternate },
            memory: if sparse { GridMemory::Bricks { most: 1 << 16 } } else { GridMemory::Dense },
            lights: if wide { MaskWidth::Sixteen } else { MaskWidth::Eight },
            ..SharedGrid::marked(voxel_size)
        };
        let reference = stage.once(froxels);
        let shared = stage.once(froxels.with_grid(grid));
        prop_assert!(support::is_sound(&reference) && support::is_sound(&shared));
        prop_assert_eq!(reference.counts.froxels, shared.counts.froxels);
        prop_assert_eq!(shared.counts.missed, 0);
        prop_assert!(
            shared.counts.rays() <= reference.counts.rays(),
            "{:?} of {:?}", shared.counts, reference.counts
        );
    }
}

#[test]
fn a_viewer_in_the_same_place_costs_only_its_frustum() {
    let froxels = Froxels { tile: 8, slices: 48, ..Froxels::new(12.0) };
    let grid = SharedGrid { near: Near::Frustum { side: 2, slices: 40 }, ..SharedGrid::marked(0.1) };
    let rays = |viewers: u32, froxels: Froxels| small_stage(7, 8, 3, viewers, 0.0).once(froxels).counts;
    let (one, two) = (rays(1, froxels.with_grid(grid)), rays(2, froxels.with_grid(grid)));
    let reference = rays(1, froxels);
    println!("one {one:?}, two {two:?}, reference {reference:?}");
    assert!(one.near_rays > 0 && two.near_rays == 2 * one.near_rays);
    assert_eq!(one.grid_rays, two.grid_rays);
    assert!(((two.rays() - one.rays()) as f64) < 0.35 * reference.rays() as f64);
    assert_eq!(rays(2, froxels).rays(), 2 * reference.rays());
}
