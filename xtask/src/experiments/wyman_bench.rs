//! Marches on one scene and one shadow map, measured in turns.

use std::sync::Arc;

use scene::{AirlightModel, Bvh, Light};
use serde_json::json;

use super::Context;
use super::equal_error::{interpolate, median};
use crate::airlight::{Airlight, Stage};
use crate::airlight_gpu::GpuFrame;
use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::metrics::{self, Metrics};
use crate::report::data::Row;
use crate::report::{Cost, Panel, PanelKind};
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source};
use crate::stained_glass::stained_glass;
use crate::technique::{Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

/// Frames of which a time is the median.
const WARM_FRAMES: usize = 5;

/// Lookups are counted on pictures with so many times fewer pixels a side.
const COUNTED: u32 = 4;

/// A technique with its options.
pub(super) struct Setting {
    pub(super) name: String,
    pub(super) technique: Technique,
    pub(super) options: Options,
}

/// What a march costs for each pixel that the light can reach, counted on the CPU.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts {
    /// Evaluations of a step's airlight.
    pub(super) steps: f64,
    /// Questions for visibility, bisections included.
    pub(super) lookups: f64,
}

impl Counts {
    /// The greater of the two: what a march without bisections would be called a march of so many steps by.
    pub(super) fn most(self) -> f64 {
        self.steps.max(self.lookups)
    }
}

/// One setting's frames.
pub(super) struct Found {
    pub(super) setting: Setting,
    pub(super) image: Image,
    /// Sorted; units: ms.
    pub(super) times: Vec<f64>,
    /// Against the exact picture.
    pub(super) exact: Metrics,
    /// Against the exact picture of the same map.
    pub(super) on_map: Option<Metrics>,
    pub(super) counts: Counts,
}

impl Found {
    pub(super) fn ms(&self) -> f64 {
        median(&self.times).unwrap_or(f64::NAN)
    }

    /// A row of `data.json`.
    pub(super) fn row(&self, lit: &Lit) -> Row {
        let mut row = Row::new(&lit.title, &self.setting.name);
        row.triangles = Some(lit.setup.scene.triangle_count() as u64);
        row.ms_scatter = Some(self.ms());
        row.ms_frame = row.ms_scatter;
        row.ms_min = self.times.first().copied();
        row.ms_max = self.times.last().copied();
        row.frames = Some(self.times.len() as u32);
        row.set_errors(&self.exact);
        if let Some(on_map) = &self.on_map {
            row.shadow_err_map = on_map.shadow_err;
            row.map_surface = Some("step".into());
            row.params.insert("map".into(), json!(lit.map.side));
            row.params.insert("rel_rmse_on_map".into(), json!(on_map.rel_rmse));
        }
        row.params.insert("steps_per_covered_pixel".into(), json!(self.counts.steps));
        row.params.insert("lookups_per_covered_pixel".into(), json!(self.counts.lookups));
        let samples = self.setting.options.samples.unwrap_or(self.setting.technique.default_samples());
        row.params.insert("samples".into(), json!(samples));
        row.samples = Some((self.counts.steps * lit.covered) as u64);
        row.rays = Some((self.counts.lookups * lit.covered) as u64);
        row
    }

    /// The picture with its time and errors, and its error map.
    pub(super) fn panels(&self, lit: &Lit, title: &str) -> Outcome<[Panel; 2]> {
        let name = &self.setting.name;
        let file = slug(&format!("{} {title}", lit.title));
        let picture = Panel::new(
            format!("{file}.png"),
            title,
            format!("Airlight of {} by {name}", lit.title),
            &to_srgb8(&self.image, lit.exposure()),
            PanelKind::Measured(Cost::new(self.ms(), &self.exact)),
        )?;
        let error = Panel::new(
            format!("{file}-error.png"),
            format!("error of {title}"),
            format!("Error of {name} against the exact picture, pixel by pixel"),
            &error_picture(&self.image, &lit.exact)?,
            PanelKind::ErrorMap,
        )?;
        Ok([picture, error])
    }
}

/// The value that `x` has where the error of a series first reaches `target`.
pub(super) fn at_error<'a>(
    series: impl Iterator<Item = &'a Found>,
    x: impl Fn(&Found) -> f64,
    target: f64,
) -> Option<f64> {
    interpolate(series.map(|found| (x(found), found.exact.rel_rmse)), target)
}

/// A scene with its light, its map and its exact pictures.
pub(super) struct Lit {
    pub(super) title: String,
    pub(super) setup: Setup,
    pub(super) bvh: Bvh,
    pub(super) size: (u32, u32),
    pub(super) exact: Image,
    /// Time of the exact picture on the CPU; units: ms.
    pub(super) exact_ms: f64,
    pub(super) unshadowed: Image,
    /// How far a ray that hits nothing is integrated; units: m.
    pub(super) max_distance: f64,
    /// Pixels that the light can reach.
    pub(super) covered: f64,
    map: MapOptions,
    exact_on_map: Image,
    maps: Maps,
    rays: ViewRays,
    counted_rays: ViewRays,
}

impl Lit {
    /// Draws the map and computes the exact pictures; rays that hit nothing have no end.
    pub(super) fn new(title: String, setup: Setup, side: u32, map: u32) -> Outcome<Self> {
        Self::within(title, setup, side, map, f64::INFINITY)
    }

    /// The same with rays that end after `max_distance` metres.
    pub(super) fn within(
        title: String,
        setup: Setup,
        side: u32,
        map: u32,
        max_distance: f64,
    ) -> Outcome<Self> {
        tracing::info!("{title}");
        let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
        let size = (side, side);
        let map = MapOptions { side: map, surface: MapSurface::Step };
        let maps = Maps::draw(&setup, &map)?;
        let rays = ViewRays::trace(&setup.camera, &bvh, size);
        let counted = (side.div_ceil(COUNTED), side.div_ceil(COUNTED));
        let counted_rays = ViewRays::trace(&setup.camera, &bvh, counted);
        let empty = Image { width: side, height: side, pixels: Vec::new() };
        let mut lit = Self {
            title,
            setup,
            bvh,
            size,
            exact: empty.clone(),
            exact_ms: 0.0,
            unshadowed: empty.clone(),
            max_distance,
            covered: 0.0,
            map,
            exact_on_map: empty,
            maps,
            rays,
            counted_rays,
        };
        let base = lit.base();
        let exact = lit.on_cpu(Technique::Exact, &base, &lit.rays)?;
        (lit.exact_ms, lit.exact) = (exact.ms, lit.image(&exact));
        lit.exact_on_map = lit.image(&lit.on_cpu(Technique::ExactShadowMap, &base, &lit.rays)?);
        let open = Options { shadows_in_medium: false, ..base };
        lit.unshadowed = lit.image(&lit.on_cpu(Technique::Exact, &open, &lit.rays)?);
        let one = Options { samples: Some(1), size: counted, ..base };
        let reached = lit.on_cpu(Technique::BruteForce, &one, &lit.counted_rays)?.samples;
        lit.covered = reached as f64 * f64::from(COUNTED * COUNTED);
        Ok(lit)
    }

    /// Options that all settings share.
    pub(super) fn base(&self) -> Options {
        Options {
            airlight_only: true,
            max_distance: self.max_distance,
            visibility: VisibilitySource::Map,
            map: self.map,
            ..Options::new(self.size)
        }
    }

    /// What makes the picture bright enough to look at.
    pub(super) fn exposure(&self) -> f32 {
        let mut values: Vec<f32> = self.exact.pixels.iter().flatten().copied().collect();
        values.sort_by(f32::total_cmp);
        let bright = values.get(values.len() * 95 / 100).copied().unwrap_or(1.0);
        if bright > 0.0 { 0.8 / bright } else { 1.0 }
    }

    fn image(&self, airlight: &Airlight) -> Image {
        let pixels = airlight.radiance.iter().map(|radiance| radiance.as_vec3().to_array()).collect();
        Image { width: self.size.0, height: self.size.1, pixels }
    }

    fn on_cpu(&self, technique: Technique, options: &Options, rays: &ViewRays) -> Outcome<Airlight> {
        let tick = |_: u64| ();
        let stage =
            Stage { setup: &self.setup, bvh: &self.bvh, options, rays, maps: &self.maps, tick: &tick };
        stage.run(technique)
    }

    /// How far the ray of a pixel is integrated; units: m.
    pub(super) fn end(&self, x: u32, y: u32) -> f64 {
        self.rays.end((y * self.size.0 + x) as usize, self.max_distance)
    }

    /// Costs of a setting for each pixel that the light can reach.
    pub(super) fn counts(&self, technique: Technique, options: &Options) -> Outcome<Counts> {
        let side = |side: u32| side.div_ceil(COUNTED);
        let mut counted = *options;
        counted.size = (side(options.size.0), side(options.size.1));
        // tiles that cover as much of the picture
        counted.hybrid.tile = side(options.hybrid.tile);
        counted.scattering_scale = 1;
        let marched = self.on_cpu(technique, &counted, &self.counted_rays)?;
        // two layers for each block
        let blocks = 2.0 / f64::from(options.scattering_scale.pow(2));
        let share = if options.scattering_scale > 1 { blocks } else { 1.0 };
        let per_pixel =
            |count: u64| share * count as f64 * f64::from(COUNTED * COUNTED) / self.covered.max(1.0);
        Ok(Counts { steps: per_pixel(marched.samples), lookups: per_pixel(marched.rays) })
    }

    /// Measures settings in turns, on the GPU where there is one.
    pub(super) fn measure(&self, context: &Context, settings: Vec<Setting>) -> Outcome<Vec<Found>> {
        let tick = |_: u64| ();
        let stages: Vec<Stage<'_>> = settings
            .iter()
            .map(|setting| Stage {
                setup: &self.setup,
                bvh: &self.bvh,
                options: &setting.options,
                rays: &self.rays,
                maps: &self.maps,
                tick: &tick,
            })
            .collect();
        let mut runners = Vec::new();
        let mut images = Vec::new();
        for (setting, stage) in settings.iter().zip(&stages) {
            let (runner, pixels) = match &context.gpu {
                Some(gpu) => {
                    let mut frame = GpuFrame::new(gpu, stage, setting.technique)?;
                    frame.render(true)?;
                    let pixels = frame.read()?;
                    (Some(frame), pixels)
                }
                None => (None, self.image(&stage.run(setting.technique)?).pixels),
            };
            runners.push(runner);
            images.push(Image { width: self.size.0, height: self.size.1, pixels });
        }
        // the first frame of each was its warm-up; now they take turns
        let mut times = vec![Vec::new(); settings.len()];
        for _ in 0..WARM_FRAMES {
            for (i, runner) in runners.iter_mut().enumerate() {
                times[i].push(match runner {
                    Some(frame) => frame.render(true)?.ms,
                    None => stages[i].run(settings[i].technique)?.ms,
                });
            }
        }
        drop(runners);
        let mut all = Vec::new();
        drop(stages);
        for ((setting, image), mut times) in settings.into_iter().zip(images).zip(times) {
            times.sort_by(f64::total_cmp);
            let exact = metrics::compare(&image, &self.exact, Some(&self.unshadowed), None)?;
            let reads_map = setting.options.visibility == VisibilitySource::Map;
            let compared = || metrics::compare(&image, &self.exact_on_map, Some(&self.unshadowed), None);
            let on_map = reads_map.then(compared).transpose()?;
            let counts = self.counts(setting.technique, &setting.options)?;
            all.push(Found { setting, image, times, exact, on_map, counts });
        }
        Ok(all)
    }
}

/// A scene's spot with a window of stained glass in front of it; `None` where the scene has no spot.
pub(super) fn textured(source: &Source, depth: f32, model: AirlightModel) -> Outcome<Option<Setup>> {
    let Some(mut setup) = source.setup_lit(depth, LightKind::Spot)? else { return Ok(None) };
    let window = Arc::new(stained_glass());
    for light in &mut setup.lights {
        if let Light::Spot(spot) = light {
            spot.texture = Some(Arc::clone(&window));
        }
    }
    setup.model = model;
    Ok(Some(setup))
}

/// Optical depth of the view in the thin medium.
pub(super) fn thin(context: &Context) -> f32 {
    context.setups.media().find(|(name, _)| *name == "thin").map_or(0.3, |(_, depth)| depth)
}

/// The scene of an entry: from the folder where it is there, else the generated one.
pub(super) fn source(context: &Context, id: &str) -> Outcome<Source> {
    let setups = &context.setups;
    let mut all = setups.sources().into_iter().chain(setups.stand_ins());
    all.find(|source| source.entry.id == id).ok_or_else(|| Failure::program(format!("scenes.toml: no {id}")))
}

/// The generated scene of an entry.
pub(super) fn generated(context: &Context, id: &str) -> Outcome<Source> {
    let mut all = context.setups.stand_ins().into_iter();
    all.find(|source| source.entry.id == id)
        .ok_or_else(|| Failure::program(format!("scenes.toml: no stand-in for {id}")))
}

/// Name of a model of airlight.
pub(super) fn model_name(model: AirlightModel) -> &'static str {
    match model {
        AirlightModel::Sun => "Sun",
        AirlightModel::HoffmanPreetham => "Hoffman-Preetham",
    }
}

/// A file's name from a title.
pub(super) fn slug(title: &str) -> String {
    let mut name = String::new();
    for letter in title.replace("procedural:", "generated ").chars() {
        match letter {
            'a'..='z' | '0'..='9' => name.push(letter),
            'A'..='Z' => name.push(letter.to_ascii_lowercase()),
            _ if !name.ends_with('-') => name.push('-'),
            _ => {}
        }
    }
    name.trim_matches('-').to_owned()
}

/// What the times are worth.
pub(super) fn clock_note(context: &Context) -> Option<String> {
    match &context.gpu {
        Some(gpu) if crate::gpu::is_hardware(gpu) => None,
        Some(_) => Some("A software adapter: times are wall times around a submission, and only their ratios within this run mean anything.".into()),
        None => Some("There is no GPU adapter: the CPU implementations were timed.".into()),
    }
}

/// How costs were counted.
pub(super) const COUNT_NOTE: &str = "Steps and lookups are counted on the CPU, bisections and the lookups at the ends of segments included, on a picture of a sixteenth of the pixels, and given for each pixel that the light's cone (or what can be shadowed, for a point light) covers.";
