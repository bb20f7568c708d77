//! Accumulation over frames: better pictures of what stays, and no trace of what was.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod support;

use froxel_grid::{FroxelFog, Froxels, SharedGrid, Temporal};
use glam::Vec3;
use scene::{Bvh, Camera, Light};
use support::{Stage, is_sound, rel_rmse};

const SIZE: (u32, u32) = (64, 64);

fn froxels(temporal: Temporal) -> Froxels {
    let froxels = Froxels { tile: 4, slices: 32, temporal: Some(temporal), ..Froxels::new(10.0) };
    froxels.with_grid(SharedGrid::marked(0.05))
}

#[test]
fn a_still_scene_becomes_better() {
    let stage = Stage::generated("slats", SIZE);
    let fine = stage.once(Froxels { tile: 4, slices: 128, ..Froxels::new(10.0) });
    let once = stage.once(Froxels { tile: 4, slices: 32, ..Froxels::new(10.0) });
    let temporal = Temporal { frames: 16, ..Temporal::default() };
    let traced = Froxels { shadows: froxel_grid::Shadowing::Traced, ..froxels(temporal) };
    let mut fog = FroxelFog::new(traced).unwrap();
    let errors: Vec<f64> =
        (0..16).map(|_| rel_rmse(&stage.render(&mut fog).airlight[0], &fine.airlight[0])).collect();
    let alone = rel_rmse(&once.airlight[0], &fine.airlight[0]);
    println!("one frame {alone:.4}; 1 to 16: {errors:.4?}");
    assert!((errors[0] - alone).abs() < 1e-9 && errors[15] < 0.65 * alone);
    // what is left: samples behind surfaces in the slices that they cut, and 1/d² and visibility averaged one by one
    let finest = stage.once(Froxels { tile: 4, slices: 256, ..Froxels::new(10.0) });
    let many = stage.render(&mut fog);
    for (name, picture) in [("one frame", &once), ("17 frames", &many), ("4 x slices", &fine)] {
        println!("{name} against 256 slices: {:.4}", rel_rmse(&picture.airlight[0], &finest.airlight[0]));
    }
}

fn move_light(stage: &mut Stage) {
    let Light::Point(lamp) = &mut stage.lights[0] else { panic!("a point light") };
    lamp.position += Vec3::new(0.5, 0.3, 0.2);
}

/// Moves the first mesh of a scene.
fn move_mesh(stage: &mut Stage, by: Vec3) {
    let mesh = &stage.scene.meshes[0];
    let positions = mesh.positions().iter().map(|p| *p + by).collect();
    stage.scene.meshes[0] = scene::Mesh::new(positions, mesh.triangles().to_vec(), mesh.material).unwrap();
    stage.bvh = Bvh::build(&stage.scene).unwrap();
    stage.look();
}

/// As many frames as make a fog's next one that of the same index.
fn after(stage: &Stage, frames: u32, temporal: Temporal) -> FroxelFog {
    let mut fog = FroxelFog::new(froxels(temporal)).unwrap();
    (0..frames).for_each(|_| drop(stage.render(&mut fog)));
    fog
}

#[test]
fn what_changes_leaves_no_ghost() {
    // a triangle alone, whose box moves with it
    for (name, change) in [
        ("light", move_light as fn(&mut Stage)),
        ("occluder", |stage: &mut Stage| move_mesh(stage, Vec3::new(0.4, 0.3, 0.0))),
    ] {
        let still = Stage::generated("triangle", SIZE);
        let mut changed = Stage::generated("triangle", SIZE);
        change(&mut changed);
        let mut fog = after(&still, 5, Temporal::default());
        let first = changed.render(&mut fog);
        // the same jitter, no history
        let mut never = after(&changed, 5, Temporal { frames: 1, ..Temporal::default() });
        let fresh = changed.render(&mut never);
        assert_eq!(first.airlight, fresh.airlight, "{name}");
        assert!(is_sound(&first));
    }
}

#[test]
fn casters_that_move_within_their_box_fade_or_are_forgotten() {
    // the floor keeps the box what it is
    let still = Stage::generated("slats", SIZE);
    let mut moved = Stage::generated("slats", SIZE);
    move_mesh(&mut moved, Vec3::new(0.3, 0.0, 0.2));
    assert_eq!(still.bvh.bounds(), moved.bvh.bounds());
    let temporal = Temporal { frames: 8, ..Temporal::default() };
    let mut fog = after(&still, 16, temporal);
    let mut alone = after(&moved, 16, temporal);
    let errors: Vec<f64> = (0..32)
        .map(|_| rel_rmse(&moved.render(&mut fog).airlight[0], &moved.render(&mut alone).airlight[0]))
        .collect();
    let stated = |n: i32| (7.0_f64 / 8.0).powi(n);
    for n in [1, 8, 16, 24, 31] {
        let share = errors[n] / errors[0];
        println!("{n} frames after the first: {share:.4} is left, stated {:.4}", stated(n as i32));
        assert!(share < 1.1 * stated(n as i32), "{errors:?}");
    }
    let mut fog = after(&still, 16, temporal);
    fog.forget();
    assert_eq!(moved.render(&mut fog), moved.render(&mut after(&moved, 0, temporal)));
}

#[test]
fn a_cut_begins_anew() {
    let mut stage = Stage::generated("triangle", SIZE);
    let mut fog = after(&stage, 5, Temporal::default());
    stage.cameras[0] = Camera::look_at(Vec3::new(-3.0, 2.0, 1.0), Vec3::Y, Vec3::Y, 0.8).unwrap();
    stage.look();
    fog.forget();
    let cut = stage.render(&mut fog);
    let fresh = stage.render(&mut after(&stage, 0, Temporal::default()));
    assert_eq!(cut, fresh);
}

#[test]
fn a_history_that_is_kept_decays_as_stated() {
    // the light's colour changes, so that the share of what was is its red over all
    let mut stage = Stage::generated("triangle", SIZE);
    let set = |stage: &mut Stage, intensity: Vec3| {
        let Light::Point(lamp) = &mut stage.lights[0] else { panic!("a point light") };
        lamp.intensity = intensity;
    };
    for frames in [4, 8, 16] {
        set(&mut stage, Vec3::new(10.0, 0.0, 0.0));
        let mut fog = after(&stage, 2 * frames, Temporal { frames, keeps_changed: true });
        let before = stage.render(&mut fog).airlight[0].clone();
        set(&mut stage, Vec3::new(0.0, 10.0, 0.0));
        let sum = |picture: &[Vec3]| picture.iter().map(|v| f64::from(v.x)).sum::<f64>();
        for n in 1..=3 * frames {
            let share = sum(&stage.render(&mut fog).airlight[0]) / sum(&before);
            let stated = (1.0 - 1.0 / f64::from(frames)).powi(n as i32);
            assert!((share - stated).abs() < 0.005 * stated, "{frames}, frame {n}: {share} {stated}");
            if n % frames == 0 {
                println!("{frames} frames, {n} later: {share:.5}, stated {stated:.5}");
            }
        }
    }
}

#[test]
fn another_size_or_number_of_views_begins_anew() {
    let mut stage = Stage::generated("triangle", SIZE);
    let mut fog = after(&stage, 5, Temporal::default());
    stage.size = (32, 48);
    stage.look();
    let resized = stage.render(&mut fog);
    let fresh = stage.render(&mut after(&stage, 5, Temporal { frames: 1, ..Temporal::default() }));
    assert_eq!(resized.airlight, fresh.airlight);
    stage.cameras.push(stage.cameras[0].clone());
    stage.look();
    let two = stage.render(&mut fog);
    let fresh = stage.render(&mut after(&stage, 6, Temporal { frames: 1, ..Temporal::default() }));
    assert_eq!(two.airlight, fresh.airlight);
    assert_eq!(two.airlight[0], two.airlight[1]);
}

#[test]
fn a_moving_camera_draws_no_trail() {
    let mut stage = Stage::generated("slats", SIZE);
    let from = stage.cameras[0].position;
    let temporal = Temporal { frames: 8, ..Temporal::default() };
    let mut fog = FroxelFog::new(froxels(temporal)).unwrap();
    let (mut moving, mut still) = (Vec::new(), Vec::new());
    for frame in 0..32_u16 {
        // walks for 16 frames, 5 cm each, then stands
        let at = from + Vec3::new(0.05 * f32::from(frame.min(16)), 0.0, 0.0);
        stage.cameras[0] = Camera::look_at(at, Vec3::Y, Vec3::Y, 0.8).unwrap();
        stage.look();
        let picture = &stage.render(&mut fog).airlight[0];
        let fine = stage.once(Froxels { tile: 4, slices: 128, ..Froxels::new(10.0) });
        let error = rel_rmse(picture, &fine.airlight[0]);
        if (1..=16).contains(&frame) {
            moving.push(error);
        } else if frame > 16 {
            still.push(error);
        }
    }
    let alone = {
        let once = stage.once(Froxels { temporal: None, ..froxels(temporal) });
        let fine = stage.once(Froxels { tile: 4, slices: 128, ..Froxels::new(10.0) });
        rel_rmse(&once.airlight[0], &fine.airlight[0])
    };
    println!("moving {moving:.4?}");
    println!("still {still:.4?}; one frame alone {alone:.4}");
    // never worse than a frame by itself, and steady two times the frames after it stands
    assert!(moving.iter().all(|&error| error < 1.2 * alone), "{moving:?} {alone}");
    assert!(still[8..].iter().all(|&error| error < alone), "{still:?} {alone}");
}
