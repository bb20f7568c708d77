//! What a march costs by pixel, counted by the implementations of the CPU on smaller pictures.

use super::measure::{Arena, Measured, Setting};
use crate::airlight::{Airlight, Stage};
use crate::failure::Outcome;
use crate::technique::{Options, Technique};
use crate::view_rays::ViewRays;
use hybrid_march::Sampling;

/// Pictures have so many times fewer pixels a side.
const SMALLER: u32 = 4;

/// Costs of a march for each of some pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts {
    /// Evaluations of a step's airlight.
    pub(super) steps: f64,
    /// Times that visibility was asked, bisections included.
    pub(super) lookups: f64,
    /// How many pixels of the whole picture they are for.
    pub(super) pixels: f64,
    /// Which pixels those are, as rows say it.
    pub(super) per: &'static str,
}

impl Counts {
    /// Those of all pixels of a march on the CPU.
    pub(super) fn of(marched: &Airlight) -> Self {
        let pixels = marched.radiance.len() as f64;
        let by_pixel = |count: u64| count as f64 / pixels;
        let (steps, lookups) = (by_pixel(marched.samples), by_pixel(marched.rays));
        Self { steps, lookups, pixels, per: "pixel" }
    }

    /// The greater of the two: what a march without bisections would be called a march of so many steps by.
    pub(super) fn most(self) -> f64 {
        self.steps.max(self.lookups)
    }
}

fn run(arena: &Arena, setting: &Setting, options: &Options) -> Outcome<Airlight> {
    let rays = ViewRays::trace(&arena.setup.camera, &arena.bvh, options.size);
    Stage { options, rays: &rays, ..arena.stage(setting)? }.run(setting.technique)
}

/// Counts for all pixels where the frames have not counted them, with tiles and blocks of as many pixels as theirs.
pub(super) fn for_all_pixels(arena: &Arena, measured: &mut [Measured]) -> Outcome {
    let (width, height) = arena.base.size;
    let small = (width.div_ceil(SMALLER).max(16), height.div_ceil(SMALLER).max(16));
    for measured in measured.iter_mut().filter(|measured| measured.counts.is_none()) {
        let options = Options { size: small, ..measured.setting.options };
        let counts = Counts::of(&run(arena, &measured.setting, &options)?);
        measured.counts = Some(Counts { pixels: f64::from(width) * f64::from(height), ..counts });
    }
    Ok(())
}

/// Counts for the pixels that the light can reach, with tiles that cover as much of the picture.
pub(super) fn for_lit_pixels(arena: &Arena, measured: &mut [Measured]) -> Outcome {
    let smaller = |(width, height): (u32, u32)| (width.div_ceil(SMALLER), height.div_ceil(SMALLER));
    let larger = f64::from(SMALLER * SMALLER);
    let one = Options { samples: Some(1), size: smaller(arena.base.size), ..arena.base };
    let pixels =
        larger * run(arena, &Setting::new("", Technique::BruteForce, arena.base), &one)?.samples as f64;
    for measured in measured {
        let whole = &measured.setting.options;
        let mut options = Options { size: smaller(whole.size), sampling: Sampling::Pixels, ..*whole };
        options.hybrid.tile = whole.hybrid.tile.div_ceil(SMALLER);
        let marched = run(arena, &measured.setting, &options)?;
        // two layers for each block
        let scale = whole.sampling.scale();
        let share = if scale > 1 { 2.0 / f64::from(scale * scale) } else { 1.0 };
        let by_pixel = |count: u64| share * larger * count as f64 / pixels.max(1.0);
        let (steps, lookups) = (by_pixel(marched.samples), by_pixel(marched.rays));
        measured.counts = Some(Counts { steps, lookups, pixels, per: "covered_pixel" });
    }
    Ok(())
}

/// How costs for the pixels that the light can reach were counted.
pub(super) const LIT_NOTE: &str = "Steps and lookups are counted on the CPU, bisections and the lookups at the ends of segments included, on a picture of a sixteenth of the pixels, and given for each pixel that the light's cone (or what can be shadowed, for a point light) covers.";
