//! The scenes of the grid experiments with their lights, and how large their pictures are.

use froxel_grid::Froxels;
use gpu_backend::GpuContext;
use scene::Light;

use super::grid_bench::Cast;
use super::grid_stand::Stand;
use super::wyman_bench::{generated, source, thin};
use super::{Context, Preset};
use crate::failure::Outcome;
use crate::gpu;
use crate::report::data::Adapter;
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source};
use crate::viewers::scattered;

/// A paper's scene: what stands for it in a folder, and the entry whose generated scene does without.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// The entry with a file, if there is any.
    file: Option<&'static str>,
    stand_in: &'static str,
}

/// San Miguel, which no file stands for.
pub(super) const SAN_MIGUEL: Place = Place { file: None, stand_in: "bistro" };
/// Bistro's exterior.
pub(super) const BISTRO: Place = Place { file: Some("bistro"), stand_in: "bistro" };
/// Battle of the Trash God: another scene outdoors.
pub(super) const TRASH_GOD: Place = Place { file: Some("gas-station"), stand_in: "sponza" };
/// Crytek's sponza.
pub(super) const SPONZA: Place = Place { file: Some("sponza-crytek"), stand_in: "sponza" };
/// Dabrovic's sponza.
pub(super) const OLD_SPONZA: Place = Place { file: Some("sponza"), stand_in: "sponza" };
/// The cathedral.
pub(super) const SIBENIK: Place = Place { file: Some("sibenik"), stand_in: "sponza" };

impl Place {
    /// The scene's entry. The shortest preset takes the smallest generated scene for all; the default one has no time for
    /// the hierarchy of Bistro's 1.6 million triangles.
    fn source(self, context: &Context) -> Outcome<Source> {
        if context.preset == Preset::Smoke {
            return generated(context, SPONZA.stand_in);
        }
        let small = |file: &&str| context.preset > Preset::Quick || BISTRO.file != Some(*file);
        let file = self.file.filter(|_| context.setups.has_folder()).filter(small);
        file.and_then(|id| source(context, id).ok()).map_or_else(|| generated(context, self.stand_in), Ok)
    }

    /// Name in the tables, and the set-up in the thin medium under its lamp and its sun: whatever there is of the two.
    pub(super) fn lit(self, context: &Context) -> Outcome<(String, Setup)> {
        let source = self.source(context)?;
        let mut lights: Vec<Light> = Vec::new();
        for kind in [LightKind::Point, LightKind::Directional] {
            let found = source.setup_lit(thin(context), kind)?;
            lights.extend(found.into_iter().flat_map(|setup| setup.lights));
        }
        let mut setup = source.setup(thin(context))?;
        if !lights.is_empty() {
            setup.lights = lights;
        }
        Ok((source.title(), setup))
    }

    /// The same with `count` viewers scattered in it, of whom the first `exact` have exact pictures.
    pub(super) fn stand(self, context: &Context, scale: Scale, count: usize, exact: usize) -> Outcome<Stand> {
        let (title, setup) = self.lit(context)?;
        tracing::info!("{title}");
        let mut stand = Stand::new(context, title, setup, (scale.size, scale.tile), None)?;
        let cameras = scattered(&stand.setup.cameras(), &stand.bvh, count);
        stand.look(cameras, exact)?;
        Ok(stand)
    }
}

/// How large pictures and their froxels are, and how many viewers there are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub(super) size: (u32, u32),
    pub(super) tile: u32,
    pub(super) viewers: &'static [usize],
}

/// The paper's numbers of viewers.
pub(super) const VIEWERS: &[usize] = &[1, 2, 3, 4, 6, 8, 12, 16];

impl Scale {
    /// As many froxels as the paper's pictures have.
    pub(super) const FULL: Self = Self { size: (240, 135), tile: 1, viewers: &[16] };

    /// For many viewers: small pictures with froxels of two pixels, which are as many as those of pictures four times as wide.
    pub(super) fn many(context: &Context) -> Self {
        let of = |size, viewers| Self { size, tile: 2, viewers };
        match context.preset {
            Preset::Smoke => of((32, 18), &[1, 2]),
            Preset::Quick => of((64, 36), &[1, 8]),
            Preset::Standard => of((128, 72), VIEWERS),
            Preset::Paper => Self { size: (1920, 1080), tile: 8, viewers: VIEWERS },
        }
    }

    /// For pictures of one viewer.
    pub(super) fn one(context: &Context) -> Self {
        let of = |size, tile| Self { size, tile, viewers: &[1] };
        match context.preset {
            Preset::Smoke => of((64, 64), 8),
            Preset::Quick => of((192, 192), 3),
            Preset::Standard => of((512, 512), 4),
            Preset::Paper => of((1920, 1080), 8),
        }
    }

    /// Froxels up to `range` metres.
    pub(super) fn cast(self, range: f32) -> Cast {
        Cast(Froxels { tile: self.tile, ..Froxels::new(range) })
    }

    /// The most viewers.
    pub(super) fn most(self) -> usize {
        self.viewers.last().copied().unwrap_or(1)
    }

    /// What a reader must know of pictures and froxels.
    pub(super) fn note(self) -> String {
        let Self { size: (width, height), tile, .. } = self;
        let (columns, rows) = (width.div_ceil(tile), height.div_ceil(tile));
        let mut note =
            format!("Pictures are {width}×{height}, with {columns}×{rows}×128 froxels of {tile} pixels");
        if tile != 8 {
            note += &format!(
                ": as many as a picture of {}×{} has with the paper's 8 pixels",
                8 * columns,
                8 * rows
            );
        }
        note + "; the paper's pictures are 1920×1080, with 240×135×128. Airlight only."
    }
}

/// What grid experiments run on: software adapters compile for longer than the shorter presets render, so that they are left to the
/// longer ones.
pub(super) fn device(context: &Context) -> Option<&GpuContext> {
    let short = context.preset <= Preset::Quick;
    context.gpu.as_ref().filter(|gpu| !short || gpu::is_hardware(gpu))
}

/// The same in words.
pub(super) fn adapter(context: &Context) -> Adapter {
    device(context).map_or_else(|| context.adapter.clone(), gpu::describe)
}

/// What a reader must know of where the times come from.
pub(super) fn clock_note(context: &Context) -> Option<String> {
    if context.gpu.is_some() && device(context).is_none() {
        return Some("The GPU adapter is software, which compiles for longer than this preset renders: the CPU implementations were timed.".into());
    }
    super::shown::clock_note(context)
}

/// What a reader must know of the scenes.
pub(super) fn scene_notes(context: &Context) -> Vec<String> {
    let mut notes = vec![
        "Scenes are lit by the lamp of their set-up and by its sun, in the thin medium. Viewers stand where one can walk from the set-up's cameras, level with them, in evenly spread headings with a metre free ahead; the first viewer is the set-up's. The sets were fixed before anything was measured.".to_owned(),
        "Errors of a grid are against the pictures of the froxel reference, the mean over viewers; shadow errors are shares of what shadows change in froxels. Errors of the reference itself are against the exact picture up to the range of the froxels, for the first viewer alone.".to_owned(),
    ];
    if context.preset == Preset::Smoke {
        notes.push("The columned hall stands in for every scene.".into());
    } else if context.setups.has_folder() && context.preset == Preset::Quick {
        notes.push("The street stands in for San Miguel and Bistro, the gas station for Battle of the Trash God, and the paper's figures are not theirs; longer presets have Bistro itself.".into());
    } else if context.setups.has_folder() {
        notes.push("The street stands in for San Miguel, and the gas station for Battle of the Trash God; part of Bistro's exterior is missing.".into());
    } else {
        notes.push("No scenes folder was given: the street stands in for San Miguel and Bistro, the columned hall for Battle of the Trash God and Sponza, and the paper's figures are not theirs.".into());
    }
    notes
}

/// Sides of voxels as the paper has them; four times as large in the shortest preset, where nothing is as large as the paper's.
pub(super) fn voxel(context: &Context, metres: f32) -> f32 {
    if context.preset == Preset::Smoke { 4.0 * metres } else { metres }
}
