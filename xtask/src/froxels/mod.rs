//! Froxel fog of any number of viewers: its settings, and frames of it on the CPU or a GPU.

mod engine;
mod gpu;

use froxel_grid::{Counts, FroxelError, Froxels, SharedGrid};
use glam::Vec3;
use gpu_backend::{GpuBvh, GpuContext};
use scene::{Aabb, Bvh, Light};

pub(crate) use engine::{Casters, Engine, Eye, FrameTime, World, brick_bytes};
pub(crate) use gpu::hierarchy;

use crate::airlight::{Airlight, Stage};
use crate::failure::{Failure, Outcome};
use crate::scene_args::Setup;
use crate::technique::{FroxelOptions, Options, Technique};

/// Voxels along the longest side of a scene where none are given.
const VOXELS: f32 = 200.0;

/// Range where nothing says how large a scene is; units: m.
const RANGE_OF_NOTHING: f32 = 100.0;

/// What a frame of froxels cost beside its time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FroxelCost {
    pub(crate) froxels: Froxels,
    pub(crate) viewers: usize,
    pub(crate) counts: Counts,
    /// Memory of froxels, masks and grid; units: bytes.
    pub(crate) bytes: u64,
}

/// Where froxels end if nothing else is said: at the farthest corner of the scene's box, of a box around lights and medium where there
/// is no triangle. Units: m.
pub(crate) fn range(setup: &Setup, bvh: &Bvh) -> f32 {
    let mut bounds = bvh.bounds();
    if bounds.is_empty() {
        bounds = Aabb::around(setup.lights.iter().filter_map(|light| match light {
            Light::Point(light) => Some(light.position),
            Light::Spot(light) => Some(light.position),
            Light::Directional(_) => None,
        }));
        bounds = setup.medium.bounds.map_or(bounds, |medium| bounds.union(&medium));
    }
    let eye = setup.camera.position.as_dvec3();
    let farthest = (bounds.max.as_dvec3() - eye).abs().max((bounds.min.as_dvec3() - eye).abs()).length();
    if bounds.is_empty() || !(farthest > 0.0) { RANGE_OF_NOTHING } else { farthest as f32 }
}

/// The froxels of a technique.
pub(crate) fn settings(technique: Technique, setup: &Setup, bvh: &Bvh, options: &Options) -> Froxels {
    let range = options.froxels.range.unwrap_or_else(|| range(setup, bvh));
    let FroxelOptions { tile, slices, .. } = options.froxels;
    let froxels = Froxels { tile, slices, ..Froxels::new(range) };
    if technique != Technique::SharedGrid {
        return froxels;
    }
    let bounds = bvh.bounds();
    let longest = if bounds.is_empty() { VOXELS } else { (bounds.max - bounds.min).max_element() };
    let usual = if longest > 0.0 { longest / VOXELS } else { 1.0 };
    froxels.with_grid(SharedGrid::marked(options.froxels.voxel_size.unwrap_or(usual)))
}

/// Fails for settings of a technique that make no sense, and for voxels too small for the scene.
pub(crate) fn check(technique: Technique, setup: &Setup, bvh: &Bvh, options: &Options) -> Outcome {
    let froxels = settings(technique, setup, bvh, options);
    froxels.check().map_err(|error| wrong(&error))?;
    let lattice = froxels.grid().map(|grid| grid.lattice(&bvh.bounds())).transpose();
    lattice.map(drop).map_err(|error| wrong(&error))
}

/// A frame of a stage's viewers in froxels, to be rendered as often as its time is asked for.
pub(crate) struct FroxelFrame<'a> {
    stage: &'a Stage<'a>,
    froxels: Froxels,
    engine: Engine<'a>,
    casts: bool,
    hierarchy: Option<GpuBvh>,
}

impl<'a> FroxelFrame<'a> {
    /// Without a GPU it is the CPU's.
    pub(crate) fn new(
        gpu: Option<&'a GpuContext>,
        stage: &'a Stage<'a>,
        technique: Technique,
    ) -> Outcome<Self> {
        let Stage { setup, bvh, options, .. } = stage;
        let froxels = settings(technique, setup, bvh, options);
        let casts = options.shadows_in_medium && !bvh.triangles().is_empty();
        let hierarchy = if casts { gpu.map(|gpu| hierarchy(gpu, &setup.scene)).transpose()? } else { None };
        Ok(Self { stage, froxels, engine: Engine::new(gpu, froxels)?, casts, hierarchy })
    }

    /// Renders the next frame of all viewers.
    ///
    /// Fails for voxels too small for the scene, and if the GPU cannot hold the frame.
    pub(crate) fn render(&mut self) -> Outcome<FrameTime> {
        let Stage { setup, bvh, options, rays, further, .. } = self.stage;
        let casters = self.casts.then_some(Casters { bvh, on_gpu: self.hierarchy.as_ref() });
        let world = World { medium: &setup.medium, lights: &setup.lights, model: setup.model, casters };
        let first = Eye { camera: &setup.camera, ends: &rays.ends };
        let others = further.iter().map(|viewer| Eye { camera: &viewer.camera, ends: &viewer.rays.ends });
        let eyes: Vec<Eye<'_>> = std::iter::once(first).chain(others).collect();
        self.engine.frame(&world, &eyes, options.size)
    }

    /// Whether it is a GPU's.
    pub(crate) fn on_gpu(&self) -> bool {
        matches!(self.engine, Engine::Gpu(_))
    }

    /// The first viewer's airlight in the last frame, row by row.
    pub(crate) fn picture(&self) -> Outcome<Vec<Vec3>> {
        self.engine.picture(0)
    }

    /// What the last frame cost beside its time.
    pub(crate) fn cost(&self) -> Outcome<FroxelCost> {
        let (counts, bytes) = (self.engine.counts()?, self.engine.bytes());
        Ok(FroxelCost { froxels: self.froxels, viewers: 1 + self.stage.further.len(), counts, bytes })
    }
}

/// The airlight of a stage's viewers in froxels; that of the first is the picture. On a GPU the second of two frames, since the first
/// also compiles.
///
/// Fails as [`FroxelFrame::render`] does.
pub(crate) fn airlight(
    stage: &Stage<'_>,
    technique: Technique,
    gpu: Option<&GpuContext>,
) -> Outcome<Airlight> {
    let mut frame = FroxelFrame::new(gpu, stage, technique)?;
    if frame.on_gpu() {
        frame.render()?;
    }
    let time = frame.render()?;
    (stage.tick)(u64::from(stage.options.size.1));
    let cost = frame.cost()?;
    Ok(Airlight {
        radiance: frame.picture()?.into_iter().map(|pixel| pixel.as_dvec3()).collect(),
        ms: time.ms,
        samples: cost.counts.froxels,
        rays: cost.counts.rays(),
        froxels: Some(cost),
        passes: time.passes.into_iter().filter_map(|pass| Some((pass.name, pass.ms?))).collect(),
        ..Airlight::default()
    })
}

/// A setting that makes no sense, or too many voxels: the flag that can mend the latter is named.
fn wrong(error: &FroxelError) -> Failure {
    match error {
        FroxelError::TooManyVoxels { .. } => Failure::input(format!("--voxel-size: {error}")),
        _ => Failure::input(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_args::SceneArgs;

    #[test]
    fn the_range_holds_the_scene() {
        for (name, at_least) in [("procedural:sphere", 3.0), ("procedural:empty", 0.1)] {
            let setup = SceneArgs::default().resolve(name).unwrap();
            let bvh = Bvh::build(&setup.scene).unwrap();
            let range = range(&setup, &bvh);
            assert!(range.is_finite() && range > at_least, "{name}: {range}");
            let options = Options::new((8, 8));
            let grid = settings(Technique::SharedGrid, &setup, &bvh, &options);
            assert!(grid.check().is_ok() && grid.grid().is_some() && grid.range == range);
            assert!(settings(Technique::Froxel, &setup, &bvh, &options).grid().is_none());
        }
    }
}
