//! Froxels that nobody sees are not lit, and voxels that nothing reads are not traced.
#![allow(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod support;

use froxel_grid::{Counts, FroxelFog, FroxelView, Froxels, Near, SharedGrid, Slices, Update};
use support::Stage;

/// Counts of a frame whose view rays all end in the middle of a slice.
fn counts(stage: &mut Stage, froxels: Froxels, slice: u32) -> Counts {
    let end = Slices::new(&froxels).distance(slice, 0.5);
    stage.ends.iter_mut().for_each(|ends| ends.fill(end));
    stage.once(froxels).counts
}

fn hall() -> (Stage, Froxels) {
    let stage = Stage::generated("hall", (48, 32));
    let range = 2.0 * stage.bvh.bounds().diagonal();
    (stage, Froxels { slices: 24, ..Froxels::new(range) })
}

#[test]
fn a_froxel_behind_the_surfaces_is_not_lit() {
    let (mut stage, froxels) = hall();
    let (columns, rows) = FroxelView::new(&stage.cameras[0], stage.size, froxels.tile).tiles();
    for slice in [0, 5, 11, 23] {
        let counts = counts(&mut stage, froxels, slice);
        assert_eq!(counts.froxels, u64::from(columns * rows) * (u64::from(slice) + 1));
        assert!(counts.near_rays <= counts.froxels * stage.lights.len() as u64);
    }
}

#[test]
fn a_voxel_that_nothing_reads_is_not_traced() {
    let (mut stage, froxels) = hall();
    let near = Near::Frustum { side: 2, slices: 8 };
    let marked = SharedGrid { near, ..SharedGrid::marked(froxels.range / 60.0) };
    let in_sight = SharedGrid { update: Update::InFrustums { alternate: false }, ..marked };
    let none = counts(&mut stage, froxels.with_grid(marked), 7);
    assert_eq!((none.voxels, none.grid_rays), (0, 0));
    assert!(counts(&mut stage, froxels.with_grid(in_sight), 7).voxels > 0);
    let some = counts(&mut stage, froxels.with_grid(marked), 23);
    let read = (some.froxels - none.froxels) * stage.lights.len() as u64;
    assert!(some.voxels > 0 && some.voxels <= read);
}

#[test]
fn without_an_occluder_there_is_neither_a_ray_nor_a_grid() {
    let (mut stage, froxels) = hall();
    let shared = froxels.with_grid(SharedGrid::marked(froxels.range / 60.0));
    stage.look();
    for froxels in [froxels, shared] {
        let mut fog = FroxelFog::new(froxels).unwrap();
        let counts = stage.render_as(&mut fog, false).counts;
        assert_eq!((counts.rays(), counts.voxels), (0, 0));
        assert!(counts.froxels > 0 && fog.lattices().is_empty());
    }
    // and one viewer of the reference has no grid
    let mut fog = FroxelFog::new(froxels).unwrap();
    assert!(stage.render(&mut fog).counts.near_rays > 0 && fog.lattices().is_empty());
}
