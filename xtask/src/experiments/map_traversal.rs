//! `map-traversal`: the exact traversal of a shadow map on the GPU against the march that looks the same map up.
//!
//! Both have the same compute path, airlight form, scene depth and light extent, and read the very same map. All
//! settings of a scene take turns. Without an adapter the CPU implementations are timed instead.

use std::collections::BTreeMap;

use scene::Bvh;
use serde_json::json;

use super::equal_error::{interpolate, median};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::airlight::{Airlight, Stage};
use crate::airlight_gpu::GpuFrame;
use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, EqualError, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Cost, Panel, PanelKind, PictureRow, Plot, Section, Series};
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source};
use crate::technique::{Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

/// Frames after which a median counts for a ratio.
const WARM_FRAMES: usize = 5;

/// Errors at which times are compared, and how much faster the traversal is to be there.
const TARGETS: [(f64, f64); 2] = [(0.01, 2.0), (0.002, 8.0)];

/// GPU against CPU, as a share of the picture.
const AGREE: f64 = 1e-4;

struct Plan {
    side: u32,
    map: u32,
    samples: &'static [u32],
    /// Sides of the maps of the sweep.
    maps: &'static [u32],
    scenes: usize,
}

fn plan(preset: Preset) -> Plan {
    const MANY: &[u32] = &[10, 20, 40, 80, 150, 300, 600, 1200, 2400];
    match preset {
        Preset::Smoke => Plan { side: 64, map: 128, samples: &[20, 80, 300], maps: &[128, 256], scenes: 1 },
        Preset::Quick => Plan {
            side: 256,
            map: 512,
            samples: &[10, 30, 100, 300, 1000, 2000],
            maps: &[256, 512, 1024, 2048, 4096],
            scenes: 2,
        },
        Preset::Standard => {
            Plan { side: 512, map: 512, samples: MANY, maps: &[256, 512, 1024, 2048, 4096], scenes: 2 }
        }
        Preset::Paper => {
            Plan { side: 1024, map: 512, samples: MANY, maps: &[256, 512, 1024, 2048, 4096], scenes: 2 }
        }
    }
}

/// What is timed on one map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Setting {
    /// The traversal; whether its pyramid is built in every frame.
    Exact {
        rebuilt: bool,
    },
    March(u32),
}

impl Setting {
    fn name(self) -> String {
        match self {
            Self::Exact { rebuilt: false } => "exact-shadow-map".into(),
            Self::Exact { rebuilt: true } => "exact-shadow-map, pyramid rebuilt".into(),
            Self::March(samples) => format!("brute force, {samples} samples"),
        }
    }
}

/// One setting's frames.
struct Result {
    setting: Setting,
    image: Image,
    times: Vec<f64>,
    /// Times of the passes that build the pyramid.
    pyramid_ms: Vec<f64>,
    samples: u64,
    pyramid_bytes: u64,
    /// Against the exact picture of the same map.
    on_map: Metrics,
    /// Against the exact picture of the geometry.
    on_geometry: Metrics,
}

impl Result {
    fn ms(&self) -> Option<f64> {
        median(&self.times)
    }

    fn map_error(&self) -> f64 {
        self.on_map.shadow_err.unwrap_or(f64::NAN)
    }
}

/// A technique that is ready to render one frame after the other.
enum Runner<'a> {
    Gpu(Box<GpuFrame<'a>>),
    Cpu(&'a Stage<'a>, Technique),
}

impl Runner<'_> {
    /// Time of a frame, and of building pyramids where that is known; units: ms.
    fn frame(&mut self, rebuild: bool) -> Outcome<(f64, Option<f64>)> {
        match self {
            Self::Gpu(frame) => {
                let times = frame.render(rebuild)?;
                let building = times.passes.iter().filter(|pass| pass.name.starts_with("pyramid"));
                Ok((times.ms, building.map(|pass| pass.ms).sum()))
            }
            Self::Cpu(stage, technique) => Ok((stage.run(*technique)?.ms, None)),
        }
    }
}

fn image(side: u32, pixels: Vec<[f32; 3]>) -> Image {
    Image { width: side, height: side, pixels }
}

fn narrow(airlight: &Airlight) -> Vec<[f32; 3]> {
    airlight.radiance.iter().map(|radiance| radiance.as_vec3().to_array()).collect()
}

/// A scene, lit and mapped.
struct Case {
    title: String,
    kind: LightKind,
    map: u32,
    triangles: u64,
    map_bytes: u64,
    results: Vec<Result>,
    exact_on_map: Image,
}

impl Case {
    fn exact(&self, rebuilt: bool) -> Option<&Result> {
        self.results.iter().find(|r| r.setting == Setting::Exact { rebuilt })
    }

    fn marches(&self) -> impl Iterator<Item = &Result> {
        self.results.iter().filter(|r| matches!(r.setting, Setting::March(_)))
    }

    /// Time that the march needs for an error on the map.
    fn march_ms(&self, target: f64) -> Option<f64> {
        interpolate(self.marches().filter_map(|r| Some((r.ms()?, r.map_error()))), target)
    }

    /// Steps that the march needs for an error on the map.
    fn march_samples(&self, target: f64) -> Option<f64> {
        let steps = |r: &Result| match r.setting {
            Setting::March(samples) => f64::from(samples),
            Setting::Exact { .. } => 0.0,
        };
        interpolate(self.marches().map(|r| (steps(r), r.map_error())), target)
    }

    fn speedup(&self, target: f64, rebuilt: bool) -> Option<f64> {
        Some(self.march_ms(target)? / self.exact(rebuilt)?.ms()?)
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let mut found = experiment(
        context,
        "map-traversal",
        "Exact traversal of a shadow map against marching on it",
        "the exact baseline of the techniques that are exact with respect to a shadow map",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let depth = context.setups.media().find(|(name, _)| *name == "thin").map_or(0.3, |(_, depth)| depth);
    let mut cases = Vec::new();
    for source in sources(context).iter().take(plan.scenes) {
        for kind in LightKind::ALL {
            let Some(setup) = source.setup_lit(depth, kind)? else { continue };
            let title = format!("{}, {} light", source.title(), kind.name());
            cases.push(measure(context, &plan, title, kind, &setup, plan.map)?);
        }
    }
    let mut sweep = Vec::new();
    for source in sources(context).iter().take(plan.scenes) {
        let Some(setup) = source.setup_lit(depth, LightKind::Spot)? else { continue };
        for &side in plan.maps {
            let title = format!("{}, spot light", source.title());
            sweep.push(measure(context, &plan, title, LightKind::Spot, &setup, side)?);
        }
    }
    for case in cases.iter().chain(&sweep) {
        found.rows.extend(case.results.iter().map(|result| row(case, result)));
        found.equal_error.extend(equal_errors(case));
    }
    section.tables.push(speedups("At equal error, by kind of light", &cases));
    section.tables.push(speedups("At equal error, by side of the map", &sweep));
    found.checks = checks(&cases, &sweep);
    for case in &cases {
        section.plots.push(plot(case));
        section.pictures.push(pictures(case)?);
    }
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

/// The columned hall and, with a folder, sponza.
pub(super) fn sources(context: &Context) -> Vec<Source> {
    let given = context.setups.sources().into_iter().filter(|source| source.entry.id == "sponza");
    let hall = context.setups.stand_ins().into_iter().filter(|source| source.entry.id == "sponza");
    let mut all: Vec<Source> = given.chain(hall).collect();
    all.dedup_by(|a, b| a.title() == b.title());
    all
}

fn measure(
    context: &Context,
    plan: &Plan,
    title: String,
    kind: LightKind,
    setup: &Setup,
    map: u32,
) -> Outcome<Case> {
    tracing::info!("{title}, map {map}²");
    let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
    let size = (plan.side, plan.side);
    let base = Options {
        airlight_only: true,
        visibility: VisibilitySource::Map,
        map: MapOptions { side: map, surface: MapSurface::Step },
        ..Options::new(size)
    };
    let rays = ViewRays::trace(&setup.camera, &bvh, size);
    let (maps, none) = (Maps::draw(setup, &base.map)?, Maps::none(setup.lights.len()));
    let settings: Vec<Setting> = [Setting::Exact { rebuilt: false }, Setting::Exact { rebuilt: true }]
        .into_iter()
        .chain(plan.samples.iter().map(|&samples| Setting::March(samples)))
        .collect();
    let options: Vec<Options> = settings
        .iter()
        .map(|setting| match setting {
            Setting::Exact { .. } => base,
            Setting::March(samples) => Options { samples: Some(*samples), ..base },
        })
        .collect();
    let tick = |_: u64| ();
    let stages: Vec<Stage<'_>> = options
        .iter()
        .map(|options| Stage { setup, bvh: &bvh, options, rays: &rays, maps: &maps, tick: &tick })
        .collect();
    // references, on the CPU and in f64
    let open = Options { shadows_in_medium: false, ..base };
    let unshadowed = Stage { setup, bvh: &bvh, options: &open, rays: &rays, maps: &none, tick: &tick };
    let unshadowed = image(plan.side, narrow(&unshadowed.run(Technique::Exact)?));
    let exact_on_map = image(plan.side, narrow(&stages[0].run(Technique::ExactShadowMap)?));
    let exact = image(plan.side, narrow(&stages[0].run(Technique::Exact)?));

    let mut results = Vec::new();
    let mut runners = Vec::new();
    for (setting, stage) in settings.iter().zip(&stages) {
        let technique = match setting {
            Setting::Exact { .. } => Technique::ExactShadowMap,
            Setting::March(_) => Technique::BruteForce,
        };
        let (pixels, samples, pyramid_bytes, runner) = match &context.gpu {
            Some(gpu) => {
                let mut frame = GpuFrame::new(gpu, stage, technique)?;
                frame.render(false)?;
                let samples = frame.stats().samples;
                (frame.read()?, samples, frame.pyramid_bytes(), Runner::Gpu(Box::new(frame)))
            }
            None => {
                let airlight = stage.run(technique)?;
                let bytes = airlight.pyramid_bytes as u64;
                (narrow(&airlight), airlight.samples, bytes, Runner::Cpu(stage, technique))
            }
        };
        let image = image(plan.side, pixels);
        let on_map = metrics::compare(&image, &exact_on_map, Some(&unshadowed), None)?;
        let on_geometry = metrics::compare(&image, &exact, Some(&unshadowed), None)?;
        results.push(Result {
            setting: *setting,
            image,
            times: Vec::new(),
            pyramid_ms: Vec::new(),
            samples,
            pyramid_bytes,
            on_map,
            on_geometry,
        });
        runners.push(runner);
    }
    // the first frame of each was its warm-up; now they take turns
    for _ in 0..WARM_FRAMES {
        for (result, runner) in results.iter_mut().zip(&mut runners) {
            let (ms, building) = runner.frame(result.setting == Setting::Exact { rebuilt: true })?;
            result.times.push(ms);
            result.pyramid_ms.extend(building.filter(|ms| *ms > 0.0));
        }
    }
    for result in &mut results {
        result.times.sort_by(f64::total_cmp);
        result.pyramid_ms.sort_by(f64::total_cmp);
    }
    let triangles = setup.scene.triangle_count() as u64;
    drop(runners);
    Ok(Case { title, kind, map, triangles, map_bytes: maps.bytes() as u64, results, exact_on_map })
}

fn row(case: &Case, result: &Result) -> Row {
    let mut row = Row::new(&case.title, result.setting.name());
    row.triangles = Some(case.triangles);
    row.ms_scatter = result.ms();
    row.ms_frame = result.ms();
    row.ms_min = result.times.first().copied();
    row.ms_max = result.times.last().copied();
    row.frames = Some(result.times.len() as u32);
    row.set_errors(&result.on_geometry);
    row.shadow_err_map = result.on_map.shadow_err;
    row.map_surface = Some("step".into());
    row.params.insert("map".into(), json!(case.map));
    row.params.insert("light".into(), json!(case.kind.name()));
    if let Some(ms) = median(&result.pyramid_ms) {
        row.stages.insert("pyramid".into(), ms);
    }
    if let Setting::March(samples) = result.setting {
        row.params.insert("samples".into(), json!(samples));
        row.samples = Some(result.samples);
    }
    row.memory_bytes = Some(case.map_bytes + result.pyramid_bytes);
    row
}

fn equal_errors(case: &Case) -> Vec<EqualError> {
    TARGETS
        .iter()
        .map(|&(target, _)| {
            let names = ["exact-shadow-map", "exact-shadow-map, pyramid rebuilt"];
            let exact = |rebuilt| case.exact(rebuilt).and_then(Result::ms);
            let times = [exact(false), exact(true)];
            let march = case.march_ms(target);
            EqualError {
                scene: format!("{}, map {}²", case.title, case.map),
                metric: "shadow_err_map".into(),
                target,
                ms: names
                    .iter()
                    .map(|&name| name.to_owned())
                    .zip(times)
                    .chain([("brute-force".to_owned(), march)])
                    .collect(),
                speedup_over_brute_force: names
                    .iter()
                    .map(|&name| name.to_owned())
                    .zip(times.map(|ms| Some(march? / ms?)))
                    .collect::<BTreeMap<_, _>>(),
            }
        })
        .collect()
}

fn speedups(title: &str, cases: &[Case]) -> Table {
    let mut table = Table::new(
        title,
        vec![
            Column::left("scene"),
            Column::right("map"),
            Column::right("exact"),
            Column::right("its map error"),
            Column::right("with the pyramid rebuilt"),
            Column::right("march for 1 %"),
            Column::right("steps"),
            Column::right("exact is faster by"),
            Column::right("march for 0.2 %"),
            Column::right("steps"),
            Column::right("exact is faster by"),
            Column::right("rebuilt, by"),
        ],
    );
    for case in cases {
        let exact = |rebuilt| case.exact(rebuilt).and_then(Result::ms);
        table.push(vec![
            case.title.clone(),
            format!("{}²", case.map),
            report::time(exact(false)),
            report::error(case.exact(false).map(Result::map_error)),
            report::time(exact(true)),
            report::time(case.march_ms(0.01)),
            report::figure(case.march_samples(0.01)),
            report::ratio(case.speedup(0.01, false)),
            report::time(case.march_ms(0.002)),
            report::figure(case.march_samples(0.002)),
            report::ratio(case.speedup(0.002, false)),
            report::ratio(case.speedup(0.002, true)),
        ]);
    }
    table.note = Some("Errors are shadow_err_map: against the exact picture of the same map in f64, as a share of what shadows change. March times and steps are interpolated between the sample counts measured; a dash where none reaches the error.".into());
    table
}

fn checks(cases: &[Case], sweep: &[Case]) -> Vec<Check> {
    let worst = cases.iter().chain(sweep).filter_map(|case| Some(case.exact(false)?.on_map.rel_rmse));
    let mut checks = vec![Check::new(
        "the traversal equals the CPU's in f64: largest rel_rmse",
        "both walk the same map",
        worst.reduce(f64::max),
        Bound::AtMost,
        AGREE,
    )];
    for (target, bar) in TARGETS {
        for case in cases {
            let mut check = Check::new(
                format!(
                    "{}, map {}², pyramid kept: times less time than the march at {} % shadow_err_map",
                    case.title,
                    case.map,
                    100.0 * target
                ),
                "the honest march on the same map",
                case.speedup(target, false),
                Bound::AtLeast,
                bar,
            );
            if let Some(samples) = case.march_samples(target) {
                check.note = Some(format!("the march needs {samples:.0} steps there"));
            }
            checks.push(check);
        }
    }
    checks
}

fn plot(case: &Case) -> Plot {
    let point = |r: &Result| Some((r.ms()?, r.map_error()));
    Plot {
        file: format!("{}.svg", slug(&case.title)),
        title: format!("{}: error on the map against time", case.title),
        caption: format!("Map {}². The traversal's error is rounding.", case.map),
        x: Axis::new("time of the airlight", "ms"),
        y: Axis::new("shadow error on the map", ""),
        series: vec![
            Series {
                label: "march".into(),
                points: case.marches().filter_map(point).collect(),
                joined: true,
            },
            Series {
                label: "exact traversal".into(),
                points: case.exact(false).and_then(point).into_iter().collect(),
                joined: false,
            },
        ],
    }
}

fn slug(title: &str) -> String {
    title.replace("procedural:", "generated-").replace([' ', ','], "-").replace("--", "-")
}

fn pictures(case: &Case) -> Outcome<PictureRow> {
    let exact = &case.exact_on_map;
    let mut values: Vec<f32> = exact.pixels.iter().flatten().copied().collect();
    values.sort_by(f32::total_cmp);
    let bright = values.get(values.len() * 95 / 100).copied().unwrap_or(1.0);
    let scale = if bright > 0.0 { 0.8 / bright } else { 1.0 };
    let id = slug(&case.title);
    let mut panels = Vec::new();
    let shown = |r: &&Result| match r.setting {
        Setting::Exact { rebuilt } => !rebuilt,
        Setting::March(samples) => (80..=150).contains(&samples),
    };
    for result in case.results.iter().filter(shown) {
        let name = result.setting.name();
        let file = slug(&name);
        panels.push(Panel::new(
            format!("{id}-{file}.png"),
            name.clone(),
            format!("Airlight of {} by {name}", case.title),
            &to_srgb8(&result.image, scale),
            PanelKind::Measured(Cost::new(result.ms().unwrap_or(f64::NAN), &result.on_map)),
        )?);
        panels.push(Panel::new(
            format!("{id}-{file}-error.png"),
            format!("error of {name}"),
            format!("Error of {name} against the exact picture of the same map, pixel by pixel"),
            &error_picture(&result.image, exact)?,
            PanelKind::ErrorMap,
        )?);
    }
    Ok(PictureRow { caption: format!("{}, map {}², airlight only", case.title, case.map), panels })
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium.", plan.side),
        "The march is an honest one: same compute path and airlight form as the traversal, clipped to scene depth, light extent and to what occluders can shadow; one lookup a step at its middle; adjoining lit steps are one evaluation. Both read the same map, which is drawn once and is no part of either's time; neither are view rays.".into(),
        "The traversal walks a min-max pyramid whose blocks grow four times a side from level to level, built in one dispatch up to 512² and in two above. What bounds it: about one and a half times a march's step for every block that a ray visits, 30 to 110 of them in these scenes, nearly all of them next to silhouettes, where blocks are neither lit nor dark as a whole; and one evaluation of airlight for every lit piece, of which the march has as many.".into(),
        "A point light's map is a cube of six such faces.".into(),
    ];
    match &context.gpu {
        Some(gpu) if !crate::gpu::is_hardware(gpu) => notes.push("A software adapter: times are wall times around a submission, and only their ratios within this run mean anything.".into()),
        Some(_) => {}
        None => notes.push("There is no GPU adapter: the CPU implementations were timed.".into()),
    }
    notes
}
