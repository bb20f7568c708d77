//! A scene with viewers of it, for the grid experiments.

use froxel_grid::Froxels;
use gpu_backend::GpuBvh;
use scene::{Bvh, Camera, Scene};

use super::Context;
use super::grid_scenes::device;
use super::references::References;
use crate::airlight::Stage;
use crate::failure::{Failure, Outcome};
use crate::froxels::{self, Casters, Engine, Eye, World};
use crate::image_file::Image;
use crate::maps::Maps;
use crate::scene_args::Setup;
use crate::technique::{Options, Technique};
use crate::viewers::Viewer;

/// A scene with its lights, and viewers of it.
pub(super) struct Stand {
    pub(super) title: String,
    pub(super) setup: Setup,
    pub(super) bvh: Bvh,
    hierarchy: Option<GpuBvh>,
    references: References,
    pub(super) size: (u32, u32),
    /// Pixels along the side of a froxel.
    tile: u32,
    /// Where froxels end; units: m.
    pub(super) range: f32,
    pub(super) viewers: Vec<Viewer>,
    /// The exact airlight of the first viewers up to the range.
    pub(super) exact: Vec<Image>,
    /// The froxels' airlight where nothing casts a shadow, by viewer.
    pub(super) open: Vec<Image>,
}

impl Stand {
    /// Builds the hierarchies; froxels end with the scene unless `range` says where (m).
    pub(super) fn new(
        context: &Context,
        title: impl Into<String>,
        setup: Setup,
        (size, tile): ((u32, u32), u32),
        range: Option<f32>,
    ) -> Outcome<Self> {
        let bvh = Bvh::build(&setup.scene).map_err(Failure::input)?;
        let hierarchy = device(context).map(|gpu| froxels::hierarchy(gpu, &setup.scene)).transpose()?;
        let range = range.unwrap_or_else(|| froxels::range(&setup, &bvh));
        let (viewers, exact, open) = Default::default();
        let references = context.references.clone();
        Ok(Self {
            title: title.into(),
            setup,
            bvh,
            hierarchy,
            references,
            size,
            tile,
            range,
            viewers,
            exact,
            open,
        })
    }

    /// Triangles of the scene.
    pub(super) fn triangles(&self) -> u64 {
        self.setup.scene.triangle_count() as u64
    }

    /// Takes viewers in the place of those before; the first `exact` of them have exact pictures.
    pub(super) fn look(&mut self, cameras: Vec<Camera>, exact: usize) -> Outcome {
        let viewer = |camera| {
            let viewer = Viewer::new(camera, &self.bvh, self.size);
            Viewer { rays: viewer.rays.up_to(self.range), ..viewer }
        };
        self.viewers = cameras.into_iter().map(viewer).collect();
        self.exact =
            self.viewers.iter().take(exact).map(|viewer| self.exact_of(viewer)).collect::<Outcome<_>>()?;
        let mut engine = Engine::new(None, Froxels { tile: self.tile, ..Froxels::new(self.range) })?;
        engine.frame(&self.world(false), &self.eyes(self.viewers.len()), self.size)?;
        self.open = pictures(&engine, self.viewers.len(), self.size)?;
        Ok(())
    }

    /// The exact airlight of a viewer up to the range.
    fn exact_of(&self, viewer: &Viewer) -> Outcome<Image> {
        let Setup { medium, lights, model, scene, .. } = &self.setup;
        let setup = Setup {
            scene: Scene { materials: scene.materials.clone(), ..Scene::default() },
            camera: viewer.camera.clone(),
            medium: medium.clone(),
            lights: lights.clone(),
            model: *model,
            notes: Vec::new(),
        };
        let options =
            Options { airlight_only: true, max_distance: self.range.into(), ..Options::new(self.size) };
        let stage = Stage {
            setup: &setup,
            bvh: &self.bvh,
            options: &options,
            rays: &viewer.rays,
            maps: &Maps::none(lights.len()),
            further: &[],
            tick: &|_| (),
        };
        Ok(self.references.picture(&stage, Technique::Exact)?.image)
    }

    /// What froxels are lit by, with or without shadows.
    pub(super) fn world(&self, casts: bool) -> World<'_> {
        let Setup { medium, lights, model, .. } = &self.setup;
        let casters = casts.then_some(Casters { bvh: &self.bvh, on_gpu: self.hierarchy.as_ref() });
        World { medium, lights, model: *model, casters }
    }

    /// The first `count` viewers.
    pub(super) fn eyes(&self, count: usize) -> Vec<Eye<'_>> {
        let viewers = self.viewers.iter().take(count);
        viewers.map(|viewer| Eye { camera: &viewer.camera, ends: &viewer.rays.ends }).collect()
    }
}

/// Airlight of the first `count` viewers in the last frame.
pub(super) fn pictures(
    engine: &Engine<'_>,
    count: usize,
    (width, height): (u32, u32),
) -> Outcome<Vec<Image>> {
    let image = |viewer| {
        let pixels = engine.picture(viewer)?.into_iter().map(Into::into).collect();
        Ok(Image { width, height, pixels })
    };
    (0..count).map(image).collect()
}
