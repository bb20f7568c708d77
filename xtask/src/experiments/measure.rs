//! Settings of one scene measured in turns, each with its errors beside its times.
//!
//! An experiment sets up an [`Arena`] (scene, light, camera and medium, with their exact pictures), lists [`Setting`]s and gets
//! a [`Measured`] for each: on the GPU that it hands over, else by the implementations of the CPU.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use gpu_backend::GpuContext;
use scene::Bvh;

use super::counts::Counts;
use super::references::{ExactPicture, References};
use crate::airlight::{Airlight, Stage};
use crate::airlight_gpu::GpuFrame;
use crate::failure::{Failure, Outcome};
use crate::froxels::FroxelFrame;
use crate::image_file::Image;
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::median::median;
use crate::metrics::{self, Metrics};
use crate::report::data::Row;
use crate::scene_args::Setup;
use crate::technique::{Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

/// Frames after which a median counts for a ratio.
pub(super) const WARM_FRAMES: usize = 5;

/// Options that the settings of an experiment share: a square picture of the airlight alone, and a map to look up.
pub(super) fn base(side: u32, map: u32) -> Options {
    Options {
        airlight_only: true,
        visibility: VisibilitySource::Map,
        map: MapOptions { side: map, surface: MapSurface::Step },
        ..Options::new((side, side))
    }
}

/// What a timed frame on the GPU makes anew of all that belongs to a light: its map's pyramid, its silhouette. The CPU makes
/// all of it anew in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rebuild {
    /// Everything, as where the light moves.
    Always,
    /// Nothing, as where it stands still.
    Never,
    /// Everything, and nothing in further frames, whose times stand beside the others.
    Both,
}

/// A technique with its options, by the name that its row has.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    pub(super) name: String,
    pub(super) technique: Technique,
    /// With the map that is read, of any size and meaning: each is drawn once for all settings.
    pub(super) options: Options,
    pub(super) rebuild: Rebuild,
    /// What is read instead of the map in the options; errors on the map are still those on that one.
    pub(super) own_maps: Option<Arc<Maps>>,
}

impl Setting {
    /// A setting with the light moving.
    pub(super) fn new(name: impl Into<String>, technique: Technique, options: Options) -> Self {
        Self { name: name.into(), technique, options, rebuild: Rebuild::Always, own_maps: None }
    }

    fn reads_map(&self) -> bool {
        self.technique.reads_maps(self.options.visibility)
    }
}

/// One setting's picture, times, counts and errors.
pub(super) struct Measured {
    pub(super) setting: Setting,
    pub(super) image: Image,
    /// Sorted; units: ms.
    pub(super) times: Vec<f64>,
    /// Those of the frames of [`Rebuild::Both`] that make nothing anew.
    pub(super) kept: Vec<f64>,
    /// Of each pass in the frames of `times`, by its kind; sorted.
    passes: BTreeMap<String, Vec<f64>>,
    /// Steps of all rays: at most, as a GPU counts them; those of the CPU are exact.
    all_steps: u64,
    /// Triangles that were made of the light: two for each edge of its silhouette, or the surface of its volume.
    pub(super) mesh_triangles: Option<u64>,
    /// Memory of a frame on the GPU; of the maps and what is made from them on the CPU.
    bytes: u64,
    /// Against the exact picture of the same map, for what reads one.
    pub(super) on_map: Option<Metrics>,
    /// Against the exact picture of the geometry.
    pub(super) on_geometry: Metrics,
    /// Steps and lookups by pixel: counted in the frames of the CPU, beside those of a GPU if at all.
    pub(super) counts: Option<Counts>,
}

impl Measured {
    /// Median; units: ms.
    pub(super) fn ms(&self) -> f64 {
        median(&self.times).unwrap_or(f64::NAN)
    }

    /// Share of what shadows change, against the exact picture of the same map.
    pub(super) fn map_error(&self) -> f64 {
        self.on_map.and_then(|on_map| on_map.shadow_err).unwrap_or(f64::NAN)
    }

    /// Errors against the exact picture of the same map, or of the geometry for what reads no map.
    pub(super) fn nearest_errors(&self) -> &Metrics {
        self.on_map.as_ref().unwrap_or(&self.on_geometry)
    }

    /// Steps along a ray that were asked for.
    pub(super) fn samples(&self) -> u32 {
        self.setting.options.samples.unwrap_or(self.setting.technique.default_samples())
    }

    /// Steps by pixel, as they were counted.
    pub(super) fn steps(&self) -> f64 {
        self.counts.map_or(f64::NAN, |counts| counts.steps)
    }

    /// Times that visibility was asked by pixel, as they were counted.
    pub(super) fn lookups(&self) -> f64 {
        self.counts.map_or(f64::NAN, |counts| counts.lookups)
    }

    /// Median time of each pass; none where they do not make up half of the frame, as the time stamps of some software
    /// adapters do.
    pub(super) fn stages(&self) -> BTreeMap<String, f64> {
        let medians = self.passes.iter().filter_map(|(name, times)| Some((name.clone(), median(times)?)));
        let stages: BTreeMap<String, f64> = medians.collect();
        if stages.values().sum::<f64>() >= 0.5 * self.ms() { stages } else { BTreeMap::new() }
    }

    /// Its line among the measurements; a frame is its airlight, since view rays, maps and black surfaces are given.
    pub(super) fn row(&self, scene: &str, triangles: u64) -> Row {
        let Setting { name, technique, options, .. } = &self.setting;
        let mut row = Row::new(scene, name);
        row.triangles = Some(triangles);
        (row.ms_scatter, row.ms_frame) = (Some(self.ms()), Some(self.ms()));
        (row.ms_min, row.ms_max) = (self.times.first().copied(), self.times.last().copied());
        row.frames = Some(self.times.len() as u32);
        row.stages = self.stages();
        row.set_errors(&self.on_geometry);
        row.samples = (self.all_steps > 0).then_some(self.all_steps);
        row.mesh_triangles = self.mesh_triangles.filter(|triangles| *triangles > 0);
        row.memory_bytes = Some(self.bytes);
        let mut param = |name: &str, value: serde_json::Value| _ = row.params.insert(name.into(), value);
        if let Some(on_map) = &self.on_map {
            param("map", options.map.side.into());
            param("rel_rmse_on_map", on_map.rel_rmse.into());
            row.shadow_err_map = on_map.shadow_err;
            row.map_surface = Some(options.map.surface.name().into());
        }
        if technique.takes_scale() {
            param("samples", self.samples().into());
            param("scattering_scale", options.sampling.scale().into());
        }
        if *technique == Technique::Hybrid {
            param("tile", options.hybrid.tile.into());
            param("refine", options.hybrid.refine.into());
        }
        if let Some(ms) = median(&self.kept) {
            param("ms_light_still", ms.into());
        }
        if let Some(counts) = &self.counts {
            param(&format!("steps_per_{}", counts.per), counts.steps.into());
            param(&format!("lookups_per_{}", counts.per), counts.lookups.into());
            row.samples = Some((counts.steps * counts.pixels).round() as u64);
            row.rays = Some((counts.lookups * counts.pixels).round() as u64);
        }
        row
    }
}

/// A shadow map with the picture that is exact with respect to it.
pub(super) struct Mapped {
    options: MapOptions,
    pub(super) maps: Maps,
    /// Airlight, in f64 on the CPU.
    pub(super) exact: Image,
}

/// A scene with its lights, and what its pictures are compared with.
pub(super) struct Arena {
    pub(super) title: String,
    pub(super) setup: Setup,
    pub(super) bvh: Bvh,
    /// What all settings have in common.
    pub(super) base: Options,
    pub(super) rays: ViewRays,
    /// The map of the common options.
    pub(super) map: Mapped,
    others: Vec<Mapped>,
    none: Maps,
    pub(super) references: References,
    /// The exact airlight of the geometry, in f64 on the CPU.
    pub(super) exact: Image,
    /// Time of that, in the run that computed it; units: ms.
    pub(super) exact_ms: f64,
    /// The same where nothing casts a shadow.
    pub(super) unshadowed: Image,
}

impl Arena {
    /// Traces view rays, draws the map of `base` and computes the references.
    ///
    /// Fails where a map cannot be drawn, and for a medium without an exact picture.
    pub(super) fn new(
        references: &References,
        title: impl Into<String>,
        setup: Setup,
        base: Options,
    ) -> Outcome<Self> {
        let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
        let rays = ViewRays::trace(&setup.camera, &bvh, base.size);
        let (maps, none) = (Maps::draw(&setup, &base.map)?, Maps::none(setup.lights.len()));
        let open = Options { shadows_in_medium: false, ..base };
        let run = |technique, options, maps| {
            let stage =
                Stage { setup: &setup, bvh: &bvh, options, rays: &rays, maps, further: &[], tick: &|_| () };
            references.picture(&stage, technique)
        };
        let ExactPicture { image: exact, ms: exact_ms } = run(Technique::Exact, &base, &none)?;
        let on_map = run(Technique::ExactShadowMap, &base, &maps)?.image;
        let unshadowed = run(Technique::Exact, &open, &none)?.image;
        let map = Mapped { options: base.map, maps, exact: on_map };
        let (title, others, references) = (title.into(), Vec::new(), references.clone());
        Ok(Self { title, setup, bvh, base, rays, map, others, none, references, exact, exact_ms, unshadowed })
    }

    /// Triangles of the scene.
    pub(super) fn triangles(&self) -> u64 {
        self.setup.scene.triangle_count() as u64
    }

    /// What a setting runs in.
    ///
    /// Fails for a map that no setting measured so far has read.
    pub(super) fn stage<'s>(&'s self, setting: &'s Setting) -> Outcome<Stage<'s>> {
        let maps = match &setting.own_maps {
            Some(maps) => maps,
            None if setting.options.shadows_in_medium && setting.reads_map() => {
                &self.mapped(&setting.options.map)?.maps
            }
            None => &self.none,
        };
        let Self { setup, bvh, rays, .. } = self;
        Ok(Stage { setup, bvh, options: &setting.options, rays, maps, further: &[], tick: &|_| () })
    }

    fn mapped(&self, options: &MapOptions) -> Outcome<&Mapped> {
        let mut all = std::iter::once(&self.map).chain(&self.others);
        all.find(|map| map.options == *options)
            .ok_or_else(|| Failure::program(format!("{}: no map for {options:?}", self.title)))
    }

    /// Draws a map unless there is one, and computes what is exact with respect to it.
    fn draw(&mut self, map: MapOptions) -> Outcome {
        if self.mapped(&map).is_err() {
            let maps = Arc::new(Maps::draw(&self.setup, &map)?);
            let options = Options { map, ..self.base };
            let own_maps = Some(Arc::clone(&maps));
            let setting = Setting { own_maps, ..Setting::new("", Technique::ExactShadowMap, options) };
            let exact = self.references.picture(&self.stage(&setting)?, setting.technique)?.image;
            drop(setting);
            self.others.push(Mapped { options: map, maps: Arc::unwrap_or_clone(maps), exact });
        }
        Ok(())
    }

    /// Measures all settings, frame after frame in turns, after a first frame of each, which warms up.
    pub(super) fn measure(
        &mut self,
        gpu: Option<&GpuContext>,
        settings: &[Setting],
    ) -> Outcome<Vec<Measured>> {
        for setting in settings.iter().filter(|setting| setting.reads_map()) {
            self.draw(setting.options.map)?;
        }
        let stages: Vec<Stage<'_>> =
            settings.iter().map(|setting| self.stage(setting)).collect::<Outcome<_>>()?;
        let mut all = Vec::new();
        for (setting, stage) in settings.iter().zip(&stages) {
            let mut runner = Runner::new(gpu, stage, setting.technique)?;
            all.push((self.compared(setting, runner.first()?)?, runner));
        }
        let times = in_turns(&mut all, |(measured, runner)| {
            let rebuild = measured.setting.rebuild;
            let (ms, passes) = runner.frame(rebuild != Rebuild::Never)?;
            for (name, ms) in passes {
                measured.passes.entry(name).or_default().push(ms);
            }
            if rebuild == Rebuild::Both && gpu.is_some() {
                measured.kept.push(runner.frame(false)?.0);
            }
            Ok(ms)
        })?;
        let finish = |((mut measured, _), times): ((Measured, Runner<'_>), Vec<f64>)| {
            measured.kept.sort_by(f64::total_cmp);
            measured.passes.values_mut().for_each(|times| times.sort_by(f64::total_cmp));
            Measured { times, ..measured }
        };
        Ok(all.into_iter().zip(times).map(finish).collect())
    }

    /// A first frame with its errors.
    ///
    /// Fails for values that are not finite.
    fn compared(&self, setting: &Setting, first: First) -> Outcome<Measured> {
        let (width, height) = self.base.size;
        let First { pixels, steps: all_steps, mesh_triangles, bytes, counts } = first;
        let image = Image { width, height, pixels };
        let against = |reference| metrics::compare(&image, reference, Some(&self.unshadowed), None);
        let on_geometry = against(&self.exact)?;
        if on_geometry.nan > 0 {
            let text = format!("{}: {} values are not finite", setting.name, on_geometry.nan);
            return Err(Failure::program(text));
        }
        let on_map = if setting.reads_map() {
            Some(against(&self.mapped(&setting.options.map)?.exact)?)
        } else {
            None
        };
        let (times, kept, passes) = Default::default();
        let setting = setting.clone();
        Ok(Measured {
            setting,
            image,
            times,
            kept,
            passes,
            all_steps,
            mesh_triangles,
            bytes,
            on_map,
            on_geometry,
            counts,
        })
    }
}

/// Times of things that take turns, each sorted; `frame` returns one. Units: ms.
pub(super) fn in_turns<T>(
    all: &mut [T],
    mut frame: impl FnMut(&mut T) -> Outcome<f64>,
) -> Outcome<Vec<Vec<f64>>> {
    let mut times = vec![Vec::new(); all.len()];
    for _ in 0..WARM_FRAMES {
        for (one, times) in all.iter_mut().zip(&mut times) {
            times.push(frame(one)?);
        }
    }
    times.iter_mut().for_each(|times| times.sort_by(f64::total_cmp));
    Ok(times)
}

/// A technique that is ready to render one frame after the other.
pub(super) struct Runner<'a> {
    stage: &'a Stage<'a>,
    technique: Technique,
    /// Without, the CPU does it, but for froxels.
    gpu: Option<Box<GpuFrame<'a>>>,
    /// The frame of techniques with froxels, on either.
    froxels: Option<Box<FroxelFrame<'a>>>,
}

/// What a first frame gives.
pub(super) struct First {
    pub(super) pixels: Vec<[f32; 3]>,
    steps: u64,
    mesh_triangles: Option<u64>,
    bytes: u64,
    counts: Option<Counts>,
}

impl<'a> Runner<'a> {
    /// Fails if the device cannot hold the frame.
    pub(super) fn new(
        gpu: Option<&'a GpuContext>,
        stage: &'a Stage<'a>,
        technique: Technique,
    ) -> Outcome<Self> {
        if technique.has_froxels() {
            let froxels = Some(Box::new(FroxelFrame::new(gpu, stage, technique)?));
            return Ok(Self { stage, technique, gpu: None, froxels });
        }
        // the reference has no other place
        let gpu = gpu.filter(|_| technique != Technique::Exact);
        let gpu = gpu.map(|gpu| GpuFrame::new(gpu, stage, technique).map(Box::new)).transpose()?;
        Ok(Self { stage, technique, gpu, froxels: None })
    }

    /// Whether a GPU does it.
    pub(super) fn on_gpu(&self) -> bool {
        self.gpu.is_some() || self.froxels.as_ref().is_some_and(|froxels| froxels.on_gpu())
    }

    /// A frame, with its picture and counts.
    pub(super) fn first(&mut self) -> Outcome<First> {
        if let Some(froxels) = &mut self.froxels {
            froxels.render()?;
            let cost = froxels.cost()?;
            let pixels = froxels.picture()?.into_iter().map(Vec3::into).collect();
            let steps = cost.counts.froxels;
            return Ok(First { pixels, steps, mesh_triangles: None, bytes: cost.bytes, counts: None });
        }
        let Some(frame) = &mut self.gpu else {
            let airlight = self.stage.run(self.technique)?;
            let bytes = (self.stage.maps.bytes() + airlight.pyramid_bytes) as u64;
            let counts = self.technique.takes_scale().then(|| Counts::of(&airlight));
            let pixels = narrow(&airlight);
            return Ok(First {
                pixels,
                steps: airlight.samples,
                mesh_triangles: airlight.mesh_triangles,
                bytes,
                counts,
            });
        };
        frame.render(true)?;
        let (steps, bytes) = (frame.stats().samples, frame.stats().bytes);
        let mesh_triangles = frame.mesh_triangles()?;
        Ok(First { pixels: frame.read()?, steps, mesh_triangles, bytes, counts: None })
    }

    /// Time of a frame and of its passes by their kind, where those are known; units: ms.
    pub(super) fn frame(&mut self, rebuild: bool) -> Outcome<(f64, BTreeMap<String, f64>)> {
        let mut passes = BTreeMap::new();
        if let Some(froxels) = &mut self.froxels {
            return Ok((froxels.render()?.ms, passes));
        }
        let Some(frame) = &mut self.gpu else { return Ok((self.stage.run(self.technique)?.ms, passes)) };
        let times = frame.render(rebuild)?;
        for pass in times.passes {
            if let Some(ms) = pass.ms {
                *passes.entry(kind_of_pass(&pass.name)).or_default() += ms;
            }
        }
        Ok((times.ms, passes))
    }
}

/// A pass's name without the light and the view that it is for.
fn kind_of_pass(pass: &str) -> String {
    let known = [
        "silhouette",
        "tiles",
        "faces",
        "merge",
        "downsample",
        "upsample",
        "pyramid",
        "criterion",
        "hierarchy",
        "leaves",
        "surface",
    ];
    let name = known.into_iter().find(|name| pass.contains(name));
    name.unwrap_or("march").to_owned()
}

/// Airlight as a picture.
pub(super) fn picture((width, height): (u32, u32), airlight: &Airlight) -> Image {
    Image { width, height, pixels: narrow(airlight) }
}

fn narrow(airlight: &Airlight) -> Vec<[f32; 3]> {
    airlight.radiance.iter().map(|radiance| radiance.as_vec3().to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_args::SceneArgs;

    #[test]
    fn each_setting_is_compared_with_its_own_map() {
        let setup = SceneArgs::default().resolve("procedural:sphere").unwrap();
        let mut arena = Arena::new(&References::default(), "sphere", setup, base(16, 64)).unwrap();
        let exact = |side, surface| {
            let options = Options { map: MapOptions { side, surface }, ..arena.base };
            Setting::new(format!("{side}, {surface:?}"), Technique::ExactShadowMap, options)
        };
        let (fine, coarse) = (exact(64, MapSurface::Step), exact(8, MapSurface::Step));
        let coarse_maps = Some(Arc::new(Maps::draw(&arena.setup, &coarse.options.map).unwrap()));
        let other = Setting { name: "the coarse one's map".into(), own_maps: coarse_maps, ..fine.clone() };
        let rays = Options { visibility: VisibilitySource::Bvh, ..arena.base };
        let rays = Setting::new("rays", Technique::BruteForce, rays);
        let settings = [fine, coarse, exact(8, MapSurface::Linear), other, rays];
        assert!(arena.stage(&settings[1]).is_err(), "its map is drawn by measuring");
        let measured = arena.measure(None, &settings).unwrap();
        let errors: Vec<f64> = measured.iter().map(Measured::map_error).collect();
        // pictures are in f32
        assert!(errors[..3].iter().all(|error| *error < 1e-6), "{errors:?}");
        assert!(errors[3] > 0.01 && errors[4].is_nan(), "{errors:?}");
        let geometry = |i: usize| measured[i].on_geometry.shadow_err.unwrap();
        assert!(geometry(0) < geometry(1) && geometry(1) == geometry(3), "{} {}", geometry(0), geometry(1));
        for measured in &measured {
            let row = measured.row("sphere", arena.triangles());
            assert_eq!((measured.times.len(), row.frames), (WARM_FRAMES, Some(5)));
            assert!(measured.times.is_sorted() && measured.kept.is_empty());
            assert_eq!(row.samples.is_some(), measured.setting.name == "rays", "only marches have steps");
            assert_eq!(row.shadow_err_map.is_some(), measured.setting.name != "rays");
        }
    }

    #[test]
    fn turns_are_sorted_apart() {
        let mut left = [(0.0, -1.0), (10.0, 1.0)];
        let times = in_turns(&mut left, |(next, step)| {
            *next += *step;
            Ok(*next)
        });
        assert_eq!(times.unwrap(), [[-5.0, -4.0, -3.0, -2.0, -1.0], [11.0, 12.0, 13.0, 14.0, 15.0]]);
    }
}
