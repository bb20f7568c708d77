//! What froxels are compared with on hard cases: airlight that ends where they do.

use super::measure::Arena;
use crate::airlight::Stage;
use crate::failure::Outcome;
use crate::froxels;
use crate::image_file::Image;
use crate::technique::{FroxelOptions, Options, Technique};
use crate::view_rays::ViewRays;

/// A case up to the range of its froxels.
pub(super) struct Ranged {
    range: f32,
    rays: ViewRays,
    /// The exact airlight.
    pub(super) exact: Image,
    /// The same where nothing casts a shadow.
    pub(super) open: Image,
}

impl Ranged {
    /// Computes the exact pictures.
    pub(super) fn new(arena: &Arena) -> Outcome<Self> {
        let range = froxels::range(&arena.setup, &arena.bvh);
        let rays = arena.rays.up_to(range);
        let options = options(range, arena.base);
        let run = |options: &Options| {
            let maps = crate::maps::Maps::none(arena.setup.lights.len());
            let stage = Stage {
                setup: &arena.setup,
                bvh: &arena.bvh,
                options,
                rays: &rays,
                maps: &maps,
                further: &[],
                tick: &|_| (),
            };
            Ok(arena.references.picture(&stage, Technique::Exact)?.image)
        };
        let exact = run(&options)?;
        let open = run(&Options { shadows_in_medium: false, ..options })?;
        Ok(Self { range, rays, exact, open })
    }

    /// Options with the same range.
    pub(super) fn options(&self, base: Options) -> Options {
        options(self.range, base)
    }

    /// A stage whose rays end at the range.
    pub(super) fn stage<'s>(&'s self, stage: Stage<'s>) -> Stage<'s> {
        Stage { rays: &self.rays, ..stage }
    }
}

/// Pictures are so small that froxels of one pixel are as many as those of a usual one.
fn options(range: f32, base: Options) -> Options {
    let froxels = FroxelOptions { range: Some(range), tile: 1, ..base.froxels };
    Options { max_distance: range.into(), froxels, ..base }
}
