//! The grid's ways of updating and keeping voxels, against each other.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod support;

use froxel_grid::{
    FroxelFog, Froxels, GridMemory, GridReads, MaskWidth, Near, SharedGrid, Update, dense_bytes,
};
use glam::{UVec3, Vec3};
use scene::{Aabb, Camera, Light, Mesh, PointLight, Scene};
use support::{Stage, is_sound, rel_rmse, shadow_err};

const SIZE: (u32, u32) = (96, 96);

fn froxels() -> Froxels {
    Froxels { tile: 4, slices: 64, ..Froxels::new(12.0) }
}

fn without_near(grid: SharedGrid) -> Froxels {
    froxels().with_grid(SharedGrid { near: Near::Grid, ..grid })
}

#[test]
fn after_two_frames_of_turns_a_still_scene_is_whole() {
    let stage = Stage::generated("slats", SIZE);
    let full = SharedGrid { update: Update::InFrustums { alternate: false }, ..SharedGrid::paper(0.1) };
    let mut all = FroxelFog::new(without_near(full)).unwrap();
    let mut turns = FroxelFog::new(without_near(SharedGrid::paper(0.1))).unwrap();
    let whole = stage.render(&mut all);
    let first = stage.render(&mut turns);
    assert_eq!(whole, first);
    let (second, third) = (stage.render(&mut turns), stage.render(&mut turns));
    assert_eq!((&second.airlight, &third.airlight), (&whole.airlight, &whole.airlight));
    assert_eq!(second.counts.grid_rays + third.counts.grid_rays, whole.counts.grid_rays);

    // a light that moves is followed by half of the layers at once, and by all in two frames
    let mut moved = Stage::generated("slats", SIZE);
    let Light::Point(lamp) = &mut moved.lights[0] else { panic!("a point light") };
    lamp.position.x += 0.6;
    let fresh = moved.render(&mut FroxelFog::new(without_near(full)).unwrap());
    let (half, again) = (moved.render(&mut turns), moved.render(&mut turns));
    assert_ne!(half.airlight, fresh.airlight);
    assert_eq!(again.airlight, fresh.airlight);
}

#[test]
fn voxels_out_of_sight_keep_what_they_have() {
    let mut stage = Stage::generated("slats", SIZE);
    let seen = SharedGrid { update: Update::InFrustums { alternate: false }, ..SharedGrid::paper(0.2) };
    let mut fog = FroxelFog::new(without_near(seen)).unwrap();
    let first = stage.render(&mut fog);
    let eye = stage.cameras[0].position;
    stage.cameras[0] = Camera::look_at(eye, 2.0 * eye, Vec3::Y, 0.7).unwrap();
    stage.look();
    assert!(stage.render(&mut fog).counts.grid_rays < first.counts.grid_rays / 2);
    let dims = fog.lattices()[0].dims;
    let masks = |fog: &FroxelFog| {
        (0..dims.element_product())
            .map(|i| {
                fog.voxel(0, UVec3::new(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y)).unwrap().lit
            })
            .collect::<Vec<u32>>()
    };
    let kept = masks(&fog);
    stage = Stage::generated("slats", SIZE);
    assert_eq!(stage.render(&mut fog), first);
    assert_eq!(masks(&fog), kept);
    fog.forget();
    assert!(fog.lattices().is_empty());
}

#[test]
fn marked_turns_read_nothing_stale() {
    let still = Stage::generated("slats", SIZE);
    let mut moved = Stage::generated("slats", SIZE);
    let Light::Point(lamp) = &mut moved.lights[0] else { panic!("a point light") };
    lamp.position.x += 0.6;
    for reads in [GridReads::Nearest, GridReads::Trilinear] {
        let grid =
            SharedGrid { update: Update::Marked { alternate: true }, reads, ..SharedGrid::marked(0.1) };
        let (mut changed, mut fresh) = (
            FroxelFog::new(froxels().with_grid(grid)).unwrap(),
            FroxelFog::new(froxels().with_grid(grid)).unwrap(),
        );
        for frame in 0..4 {
            // the same frames, but that one fog has seen the light elsewhere
            let a = if frame < 2 { still.render(&mut changed) } else { moved.render(&mut changed) };
            let b = moved.render(&mut fresh);
            assert_eq!(a == b, frame >= 2, "{reads:?}, frame {frame}");
        }
    }
    // about half the voxels, and a picture next to that of all
    let whole = still.once(without_near(SharedGrid::marked(0.1)));
    let turns = SharedGrid { update: Update::Marked { alternate: true }, ..SharedGrid::marked(0.1) };
    let half = still.once(without_near(turns));
    let unshadowed = still.render_as(&mut FroxelFog::new(froxels()).unwrap(), false);
    let error = shadow_err(&half.airlight[0], &whole.airlight[0], &unshadowed.airlight[0]);
    println!("turns: {:?} of {:?}, shadow_err {error:.4}", half.counts, whole.counts);
    assert!(half.counts.grid_rays < whole.counts.grid_rays && error < 0.15);
}

#[test]
fn marked_voxels_are_those_in_sight_where_both_are_traced() {
    let stage = Stage::generated("slats", SIZE);
    let seen = SharedGrid { update: Update::InFrustums { alternate: false }, ..SharedGrid::paper(0.1) };
    let (mut marked, mut all) = (
        FroxelFog::new(without_near(SharedGrid::marked(0.1))).unwrap(),
        FroxelFog::new(without_near(seen)).unwrap(),
    );
    let (a, b) = (stage.render(&mut marked), stage.render(&mut all));
    assert!(a.counts.grid_rays < b.counts.grid_rays);
    let dims = marked.lattices()[0].dims;
    let mut both = 0;
    for i in 0..dims.element_product() {
        let voxel = UVec3::new(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y);
        let (a, b) = (marked.voxel(0, voxel).unwrap(), all.voxel(0, voxel).unwrap());
        let known = a.known & b.known;
        assert_eq!(a.lit & known, b.lit & known);
        assert_eq!(a.lit & !a.known, 0);
        both += known.count_ones();
    }
    println!("{both} voxels in both");
    assert!(both > 1000);
    assert_eq!(marked.voxel(0, dims), None);
    assert_eq!(marked.voxel(1, UVec3::ZERO), None);
}

#[test]
fn bricks_equal_dense_memory_where_there_is_room() {
    let stage = Stage::generated("slats", SIZE);
    for reads in [GridReads::Nearest, GridReads::Trilinear] {
        for alternate in [false, true] {
            let dense =
                SharedGrid { reads, update: Update::Marked { alternate }, ..SharedGrid::marked(0.07) };
            let bricks = SharedGrid { memory: GridMemory::Bricks { most: 1 << 20 }, ..dense };
            let mut fogs = [dense, bricks].map(|grid| FroxelFog::new(froxels().with_grid(grid)).unwrap());
            for _ in 0..2 {
                let [mut a, mut b] = fogs.each_mut().map(|fog| stage.render(fog));
                assert!(b.counts.bricks > 0 && a.counts.bricks == 0);
                println!("{reads:?} {alternate}: {:?}", b.counts);
                (a.counts.bricks, b.counts.bricks) = (0, 0);
                assert_eq!(a, b);
            }
        }
    }
}

#[test]
fn without_room_reads_are_lit_and_counted() {
    let stage = Stage::generated("slats", SIZE);
    let grid = |most| SharedGrid { memory: GridMemory::Bricks { most }, ..SharedGrid::marked(0.07) };
    let whole = stage.once(without_near(grid(1 << 20)));
    let unshadowed = stage.render_as(&mut FroxelFog::new(froxels()).unwrap(), false);
    let mut before = f64::INFINITY;
    for share in [8, 4, 2, 1] {
        let most = (whole.counts.bricks as u32).div_ceil(share);
        let rendered = stage.once(without_near(grid(most)));
        let error = rel_rmse(&rendered.airlight[0], &whole.airlight[0]);
        println!("{most} bricks: {} missed, rel_rmse {error:.4}", rendered.counts.missed);
        assert!(is_sound(&rendered) && rendered.counts.bricks == u64::from(most));
        assert_eq!(rendered.counts.missed == 0, share == 1);
        assert!(error < before);
        assert_eq!(rendered, stage.once(without_near(grid(most))), "the same on every run");
        before = error;
        // never darker than with its shadows, never lighter than without
        let lighter = rendered.airlight[0].iter().zip(&whole.airlight[0]);
        assert!(lighter.clone().all(|(a, b)| a.x >= b.x * 0.9999));
        let lit = rendered.airlight[0].iter().zip(&unshadowed.airlight[0]);
        assert!(lit.clone().all(|(a, b)| a.x <= b.x * 1.0001));
    }
    assert_eq!(before, 0.0);
}

#[test]
fn a_finer_grid_next_to_the_viewer() {
    let stage = Stage::generated("slats", SIZE);
    let reference = stage.once(froxels());
    let unshadowed = stage.render_as(&mut FroxelFog::new(froxels()).unwrap(), false);
    let bricks = GridMemory::Bricks { most: 1 << 20 };
    let error = |near| {
        let grid = SharedGrid { memory: bricks, near, ..SharedGrid::marked(0.2) };
        let mut fog = FroxelFog::new(froxels().with_grid(grid)).unwrap();
        let rendered = stage.render(&mut fog);
        let error = shadow_err(&rendered.airlight[0], &reference.airlight[0], &unshadowed.airlight[0]);
        println!("{near:?}: shadow_err {error:.4}, {:?}", rendered.counts);
        assert!(rendered.counts.rays() <= reference.counts.rays() && rendered.counts.near_rays == 0);
        assert_eq!(fog.lattices().len(), 1 + usize::from(near != Near::Grid));
        error
    };
    let coarse = error(Near::Grid);
    let some = error(Near::FineGrid { ratio: 4, slices: 40 });
    let all = error(Near::FineGrid { ratio: 4, slices: 64 });
    assert!(all < some && some < coarse, "{coarse} {some} {all}");
    // all of the slices in the finer grid are a grid of its voxels, but for where the lattice ends
    let fine = stage.once(without_near(SharedGrid { memory: bricks, ..SharedGrid::marked(0.05) }));
    let fine = shadow_err(&fine.airlight[0], &reference.airlight[0], &unshadowed.airlight[0]);
    assert!((all / fine - 1.0).abs() < 0.2, "{all} {fine}");
}

/// A square over a floor that no view sees, and `count` lamps in a row above it, the first the brightest.
fn lamps(count: usize) -> Stage {
    let corner = |x: f32, z: f32| Vec3::new(x, 1.0, z);
    let square = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Mesh::new(square, vec![[0, 1, 2], [0, 2, 3]], 0).unwrap();
    let lamp = |i: usize| {
        let position = Vec3::new(i as f32 * 0.1 - 0.5, 3.0, 0.0);
        Light::Point(PointLight::new(position, Vec3::splat(20.0 / (1 + i) as f32)).unwrap())
    };
    let camera = Camera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::new(0.0, 0.5, 0.0), Vec3::Y, 0.7).unwrap();
    let medium = scene::Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
    let scene = Scene { meshes: vec![mesh], ..Scene::default() };
    Stage::new(scene, medium, (0..count).map(lamp).collect(), vec![camera], SIZE)
}

#[test]
fn nine_lights_in_eight_bits_lose_the_weakest() {
    for near in [Near::Grid, Near::Frustum { side: 2, slices: 64 }] {
        let grid = |lights| froxels().with_grid(SharedGrid { near, lights, ..SharedGrid::marked(0.1) });
        let eight = lamps(8).once(grid(MaskWidth::Eight));
        assert_eq!(eight.counts.dropped, 0);
        let nine = lamps(9);
        let (dropped, kept) = (nine.once(grid(MaskWidth::Eight)), nine.once(grid(MaskWidth::Sixteen)));
        println!("{near:?}: {:?}", dropped.counts);
        assert!(dropped.counts.dropped > 0 && kept.counts.dropped == 0);
        assert!(dropped.counts.rays() < kept.counts.rays());
        // dark where it was dropped, so between the pictures of eight lights and of nine
        for ((eight, dropped), kept) in
            eight.airlight[0].iter().zip(&dropped.airlight[0]).zip(&kept.airlight[0])
        {
            assert!(dropped.x >= eight.x * 0.9999 && dropped.x <= kept.x * 1.0001);
        }
        // the weakest of all is the one that is lost: what it shines on through the casters' box has eight lights
        let error = rel_rmse(&dropped.airlight[0], &kept.airlight[0]);
        println!("rel_rmse {error:.4}");
        assert!(error > 0.0 && error < 1.0 / 9.0);
    }
}

#[test]
fn a_flat_casters_shadow_is_in_the_grid() {
    // all of the square's shadow lies outside of its box
    let stage = lamps(1);
    let reference = stage.once(froxels());
    let unshadowed = stage.render_as(&mut FroxelFog::new(froxels()).unwrap(), false);
    let mut before = f64::INFINITY;
    for voxel_size in [0.4, 0.2, 0.1, 0.05] {
        let rendered = stage.once(without_near(SharedGrid::marked(voxel_size)));
        let error = shadow_err(&rendered.airlight[0], &reference.airlight[0], &unshadowed.airlight[0]);
        println!(
            "square, {voxel_size} m: shadow_err {error:.4}, {:?} of {:?}",
            rendered.counts, reference.counts
        );
        assert!(error < before, "{error} after {before}");
        before = error;
    }
    assert!(before < 0.1, "{before}");
}

#[test]
fn voxels_that_are_too_many_are_an_error() {
    let stage = lamps(1);
    let mut fog = FroxelFog::new(without_near(SharedGrid::marked(1e-4))).unwrap();
    let visibility = scene::Unoccluded;
    let mut frame = froxel_grid::Frame {
        views: &[],
        medium: &stage.medium,
        lights: &stage.lights,
        model: stage.model,
        occluders: Some(froxel_grid::Occluders {
            visibility: &visibility,
            bounds: Aabb { min: Vec3::ZERO, max: Vec3::ONE },
        }),
    };
    let error = fog.render(&frame).unwrap_err().to_string();
    assert!(error.contains("voxels"), "{error}");
    let ends = [1.0];
    let view = [froxel_grid::View { camera: &stage.cameras[0], size: (1, 2), ends: &ends }];
    frame.views = &view;
    assert!(fog.render(&frame).unwrap_err().to_string().contains("1 distances"));
    let many = vec![stage.lights[0].clone(); 33];
    frame = froxel_grid::Frame { views: &[], lights: &many, ..frame };
    assert!(fog.render(&frame).unwrap_err().to_string().contains("at most 32"));
    let lattice = SharedGrid::paper(1.0).lattice(&Aabb { min: Vec3::ZERO, max: Vec3::splat(2.0) }).unwrap();
    assert_eq!(dense_bytes(&lattice, MaskWidth::Sixteen), 4 * 16 * 2);
}
