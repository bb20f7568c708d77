//! Settings of one scene measured in turns, each with its errors beside its times.

use std::collections::BTreeMap;

use scene::{AirlightModel, Bvh};

use super::Context;
use super::equal_error::median;
use crate::airlight::{Airlight, Stage};
use crate::airlight_gpu::GpuFrame;
use crate::failure::{Failure, Outcome};
use crate::image_file::Image;
use crate::maps::Maps;
use crate::metrics::{self, Metrics};
use crate::report::data::Row;
use crate::scene_args::Setup;
use crate::technique::{Options, Technique};
use crate::view_rays::ViewRays;

/// Frames after which a median counts for a ratio.
pub(super) const WARM_FRAMES: usize = 5;

/// Steps of the picture without shadows in the model that has no closed form along a ray.
const OPEN_STEPS: u32 = 600;

/// A technique with its options, by the name that its row has.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    pub(super) name: String,
    pub(super) technique: Technique,
    pub(super) options: Options,
    /// Whether its frames with the light standing still are timed as well.
    pub(super) still: bool,
}

/// One setting's picture, times and errors.
pub(super) struct Measured {
    pub(super) setting: Setting,
    pub(super) image: Image,
    /// Sorted times of frames in which the light has moved; units: ms.
    pub(super) moved: Vec<f64>,
    /// The same where it stands still.
    pub(super) still: Vec<f64>,
    /// Times of each pass in the frames of `moved`, sorted.
    passes: BTreeMap<String, Vec<f64>>,
    /// Steps at most, as the GPU counts them; those of the CPU are exact.
    pub(super) steps: u64,
    bytes: u64,
    /// Silhouette edges, where a shadow volume is extruded.
    pub(super) edges: u64,
    /// Against the exact picture of the same map.
    pub(super) on_map: Metrics,
    /// Against the exact picture of the geometry.
    pub(super) on_geometry: Metrics,
}

impl Measured {
    /// Median time with the light moved; units: ms.
    pub(super) fn ms(&self) -> Option<f64> {
        median(&self.moved)
    }

    /// Error against the exact picture of the same map.
    pub(super) fn error(&self) -> f64 {
        self.on_map.shadow_err.unwrap_or(f64::NAN)
    }

    /// Median time of each pass with the light moved; none where they do not make up half of the frame, as the time
    /// stamps of some software adapters do.
    pub(super) fn stages(&self) -> BTreeMap<String, f64> {
        let medians = self.passes.iter().filter_map(|(name, times)| Some((name.clone(), median(times)?)));
        let stages: BTreeMap<String, f64> = medians.collect();
        let known = stages.values().sum::<f64>() >= 0.5 * self.ms().unwrap_or(0.0);
        if known { stages } else { BTreeMap::new() }
    }

    /// The row of this setting; a frame is its airlight, since view rays, maps and black surfaces are given.
    pub(super) fn row(&self, scene: &str, triangles: u64) -> Row {
        let mut row = Row::new(scene, &self.setting.name);
        row.triangles = Some(triangles);
        row.ms_scatter = self.ms();
        row.ms_frame = self.ms();
        row.ms_min = self.moved.first().copied();
        row.ms_max = self.moved.last().copied();
        row.frames = Some(self.moved.len() as u32);
        row.stages = self.stages();
        row.set_errors(&self.on_geometry);
        row.shadow_err_map = self.on_map.shadow_err;
        row.map_surface = Some(self.setting.options.map.surface.name().into());
        row.samples = (self.steps > 0).then_some(self.steps);
        row.mesh_triangles = (self.edges > 0).then_some(2 * self.edges);
        row.memory_bytes = Some(self.bytes);
        let params = &mut row.params;
        params.insert("map".into(), self.setting.options.map.side.into());
        params.insert("scattering_scale".into(), self.setting.options.scattering_scale.into());
        if let Some(samples) = self.setting.options.samples {
            params.insert("samples".into(), samples.into());
        }
        if self.setting.technique == Technique::Hybrid {
            params.insert("tile".into(), self.setting.options.hybrid.tile.into());
            params.insert("refine".into(), self.setting.options.hybrid.refine.into());
            if let Some(ms) = median(&self.still) {
                params.insert("ms_light_still".into(), ms.into());
            }
        }
        row
    }
}

/// A scene with a light, and what its pictures are compared with.
pub(super) struct Arena<'a> {
    pub(super) setup: &'a Setup,
    pub(super) bvh: &'a Bvh,
    pub(super) rays: ViewRays,
    pub(super) maps: Maps,
    none: Maps,
    /// Airlight exact with respect to the map, in f64.
    pub(super) exact_on_map: Image,
    exact: Image,
    unshadowed: Image,
}

impl<'a> Arena<'a> {
    /// Traces view rays, draws maps and computes the references; `base` has the size and the map of all settings.
    pub(super) fn new(setup: &'a Setup, bvh: &'a Bvh, base: &Options) -> Outcome<Self> {
        let rays = ViewRays::trace(&setup.camera, bvh, base.size);
        let (maps, none) = (Maps::draw(setup, &base.map)?, Maps::none(setup.lights.len()));
        let tick = |_: u64| ();
        let stage = Stage { setup, bvh, options: base, rays: &rays, maps: &maps, tick: &tick };
        let exact_on_map = image(base.size, narrow(&stage.run(Technique::ExactShadowMap)?));
        let exact = image(base.size, narrow(&stage.run(Technique::Exact)?));
        // only the weight of shadows is measured with it: where it has no closed form, a long march is enough
        let (technique, samples) = match setup.model {
            AirlightModel::Sun => (Technique::Exact, base.samples),
            AirlightModel::HoffmanPreetham => (Technique::BruteForce, Some(OPEN_STEPS)),
        };
        let open = Options { shadows_in_medium: false, samples, ..*base };
        let unshadowed = Stage { options: &open, maps: &none, ..stage };
        let unshadowed = image(base.size, narrow(&unshadowed.run(technique)?));
        Ok(Self { setup, bvh, rays, maps, none, exact_on_map, exact, unshadowed })
    }

    /// The stage in which a technique with these options runs.
    pub(super) fn stage<'s>(&'s self, options: &'s Options, tick: &'s (dyn Fn(u64) + Sync)) -> Stage<'s> {
        let maps = if options.shadows_in_medium { &self.maps } else { &self.none };
        Stage { setup: self.setup, bvh: self.bvh, options, rays: &self.rays, maps, tick }
    }

    /// Measures all settings, frame after frame in turns.
    pub(super) fn measure(&self, context: &Context, settings: &[Setting]) -> Outcome<Vec<Measured>> {
        let tick = |_: u64| ();
        let stages: Vec<Stage<'_>> =
            settings.iter().map(|setting| self.stage(&setting.options, &tick)).collect();
        let mut all = Vec::new();
        let mut runners = Vec::new();
        for (setting, stage) in settings.iter().zip(&stages) {
            let mut runner = match &context.gpu {
                Some(gpu) => Runner::Gpu(Box::new(GpuFrame::new(gpu, stage, setting.technique)?)),
                None => Runner::Cpu(stage, setting.technique),
            };
            all.push(self.first(setting, &mut runner)?);
            runners.push(runner);
        }
        // the first frame of each was its warm-up; now they take turns
        for _ in 0..WARM_FRAMES {
            for (measured, runner) in all.iter_mut().zip(&mut runners) {
                let (ms, passes) = runner.frame(true)?;
                measured.moved.push(ms);
                for (name, ms) in passes {
                    measured.passes.entry(name).or_default().push(ms);
                }
                if measured.setting.still && context.gpu.is_some() {
                    measured.still.push(runner.frame(false)?.0);
                }
            }
        }
        for measured in &mut all {
            measured.moved.sort_by(f64::total_cmp);
            measured.still.sort_by(f64::total_cmp);
            measured.passes.values_mut().for_each(|times| times.sort_by(f64::total_cmp));
        }
        Ok(all)
    }

    /// The warm-up frame: its picture and errors.
    fn first(&self, setting: &Setting, runner: &mut Runner<'_>) -> Outcome<Measured> {
        let maps = if setting.options.shadows_in_medium { self.maps.bytes() as u64 } else { 0 };
        let (pixels, steps, bytes, edges) = match runner {
            Runner::Gpu(frame) => {
                frame.render(true)?;
                (frame.read()?, frame.stats().samples, frame.stats().bytes, frame.silhouette_edges()?)
            }
            Runner::Cpu(stage, technique) => {
                let airlight = stage.run(*technique)?;
                (narrow(&airlight), airlight.samples, maps, 0)
            }
        };
        let image = image(setting.options.size, pixels);
        let on_map = metrics::compare(&image, &self.exact_on_map, Some(&self.unshadowed), None)?;
        let on_geometry = metrics::compare(&image, &self.exact, Some(&self.unshadowed), None)?;
        if on_map.nan > 0 {
            return Err(Failure::program(format!("{}: {} values are not finite", setting.name, on_map.nan)));
        }
        let (moved, still, passes) = Default::default();
        let setting = setting.clone();
        Ok(Measured { setting, image, moved, still, passes, steps, bytes, edges, on_map, on_geometry })
    }
}

/// A technique that is ready to render one frame after the other.
enum Runner<'a> {
    Gpu(Box<GpuFrame<'a>>),
    Cpu(&'a Stage<'a>, Technique),
}

impl Runner<'_> {
    /// Time of a frame and of its passes, where those are known; units: ms.
    fn frame(&mut self, moved: bool) -> Outcome<(f64, BTreeMap<String, f64>)> {
        let mut passes = BTreeMap::new();
        let ms = match self {
            Self::Gpu(frame) => {
                let times = frame.render(moved)?;
                for pass in times.passes {
                    if let Some(ms) = pass.ms {
                        *passes.entry(stage_name(&pass.name)).or_default() += ms;
                    }
                }
                times.ms
            }
            Self::Cpu(stage, technique) => stage.run(*technique)?.ms,
        };
        Ok((ms, passes))
    }
}

/// A pass's name without the light and the view that it is for.
fn stage_name(pass: &str) -> String {
    let known = ["silhouette", "tiles", "faces", "merge", "downsample", "upsample", "pyramid"];
    let name = known.iter().find(|name| pass.contains(**name));
    name.map_or_else(|| "march".to_owned(), |name| (*name).to_owned())
}

fn image((width, height): (u32, u32), pixels: Vec<[f32; 3]>) -> Image {
    Image { width, height, pixels }
}

fn narrow(airlight: &Airlight) -> Vec<[f32; 3]> {
    airlight.radiance.iter().map(|radiance| radiance.as_vec3().to_array()).collect()
}
