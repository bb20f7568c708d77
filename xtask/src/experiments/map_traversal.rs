//! `map-traversal`: the exact traversal of a shadow map on the GPU against the march that looks the same map up.
//!
//! Both have the same compute path, airlight form, scene depth and light extent, and read the very same map. All
//! settings of a scene take turns. Without an adapter the CPU implementations are timed instead.

use std::collections::BTreeMap;

use serde_json::json;

use super::equal_error::interpolate;
use super::measure::{Arena, Measured, Rebuild, Setting, base};
use super::shown::{self, clock_note, display_scale, slug};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::Image;
use crate::report::data::{Bound, Check, EqualError, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, PictureRow, Plot, Section, Series};
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source};
use crate::technique::{Options, Technique};

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
            maps: &[256, 2048],
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

/// The traversal's name; whether its pyramid is built in every frame.
fn exact_name(rebuilt: bool) -> &'static str {
    if rebuilt { "exact-shadow-map, pyramid rebuilt" } else { "exact-shadow-map" }
}

/// A scene, lit and mapped.
struct Case {
    title: String,
    kind: LightKind,
    map: u32,
    triangles: u64,
    results: Vec<Measured>,
    exact_on_map: Image,
}

impl Case {
    fn exact(&self, rebuilt: bool) -> Option<&Measured> {
        self.results.iter().find(|r| r.setting.name == exact_name(rebuilt))
    }

    fn marches(&self) -> impl Iterator<Item = &Measured> {
        self.results.iter().filter(|r| r.setting.technique == Technique::BruteForce)
    }

    /// Time that the march needs for an error on the map.
    fn march_ms(&self, target: f64) -> Option<f64> {
        interpolate(self.marches().map(|r| (r.ms(), r.map_error())), target)
    }

    /// Steps that the march needs for an error on the map.
    fn march_samples(&self, target: f64) -> Option<f64> {
        interpolate(self.marches().map(|r| (f64::from(r.samples()), r.map_error())), target)
    }

    fn speedup(&self, target: f64, rebuilt: bool) -> Option<f64> {
        Some(self.march_ms(target)? / self.exact(rebuilt)?.ms())
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
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
            cases.push(measure(context, &plan, title, kind, setup, plan.map)?);
        }
    }
    let mut sweep = Vec::new();
    for source in sources(context).iter().take(plan.scenes) {
        let Some(setup) = source.setup_lit(depth, LightKind::Spot)? else { continue };
        for &side in plan.maps {
            let title = format!("{}, spot light", source.title());
            sweep.push(measure(context, &plan, title, LightKind::Spot, setup.clone(), side)?);
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
    setup: Setup,
    map: u32,
) -> Outcome<Case> {
    tracing::info!("{title}, map {map}²");
    let mut arena = Arena::new(&context.references, title, setup, base(plan.side, map))?;
    let base = arena.base;
    let exact = [Rebuild::Never, Rebuild::Always].map(|rebuild| {
        let name = exact_name(rebuild == Rebuild::Always);
        Setting { rebuild, ..Setting::new(name, Technique::ExactShadowMap, base) }
    });
    let march = |&samples: &u32| {
        let options = Options { samples: Some(samples), ..base };
        Setting::new(format!("brute force, {samples} samples"), Technique::BruteForce, options)
    };
    let settings: Vec<Setting> = exact.into_iter().chain(plan.samples.iter().map(march)).collect();
    let results = arena.measure(context.gpu.as_ref(), &settings)?;
    let triangles = arena.triangles();
    Ok(Case { title: arena.title, kind, map, triangles, results, exact_on_map: arena.map.exact })
}

fn row(case: &Case, result: &Measured) -> Row {
    let mut row = result.row(&case.title, case.triangles);
    row.params.insert("light".into(), json!(case.kind.name()));
    row
}

fn equal_errors(case: &Case) -> Vec<EqualError> {
    TARGETS
        .iter()
        .map(|&(target, _)| {
            let names = [false, true].map(exact_name);
            let exact = |rebuilt| case.exact(rebuilt).map(Measured::ms);
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
        let exact = |rebuilt| case.exact(rebuilt).map(Measured::ms);
        table.push(vec![
            case.title.clone(),
            format!("{}²", case.map),
            report::time(exact(false)),
            report::error(case.exact(false).map(Measured::map_error)),
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
    let worst = cases.iter().chain(sweep).filter_map(|case| Some(case.exact(false)?.on_map?.rel_rmse));
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
    let point = |r: &Measured| (r.ms(), r.map_error());
    Plot {
        file: format!("{}.svg", slug(&case.title)),
        title: format!("{}: error on the map against time", case.title),
        caption: format!("Map {}². The traversal's error is rounding.", case.map),
        x: Axis::new("time of the airlight", "ms"),
        y: Axis::new("shadow error on the map", ""),
        series: vec![
            Series { label: "march".into(), points: case.marches().map(point).collect(), joined: true },
            Series {
                label: "exact traversal".into(),
                points: case.exact(false).map(point).into_iter().collect(),
                joined: false,
            },
        ],
    }
}

fn pictures(case: &Case) -> Outcome<PictureRow> {
    let exact = &case.exact_on_map;
    let scale = display_scale(exact, 95);
    let mut panels = Vec::new();
    let marches = case.marches().filter(|r| (80..=150).contains(&r.samples()));
    for result in case.exact(false).into_iter().chain(marches) {
        panels.extend(shown::panels(&case.title, result, (exact, result.nearest_errors()), scale)?);
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
    notes.extend(clock_note(context));
    notes
}
