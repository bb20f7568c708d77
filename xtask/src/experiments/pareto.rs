//! `pareto`: every technique and setting on every scene, time against error.
//!
//! All settings of a scene take turns. Errors against the geometry are those of the picture; errors against the map are
//! those of what reads the map that a host has, in the meaning that it is read in.
//!
//! `pareto-speedup` is the part of it that is compared with the march at the papers' resolution.

use serde_json::json;

use super::measure::{Arena, Measured, base};
use super::pareto_picks::{self, Metric, Pick};
use super::pareto_report as told;
use super::pareto_settings::{self, Sweep, family};
use super::shown::clock_note;
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::planned;
use crate::report::Section;
use crate::report::data::{Check, Row};
use crate::scene_args::Setup;
use crate::setups::LightKind;

/// How much is measured.
#[derive(Clone, Copy)]
struct Plan {
    side: u32,
    sweep: Sweep,
    kinds: &'static [LightKind],
    media: usize,
    /// Which scenes, by their ids; all without.
    scenes: Option<&'static [&'static str]>,
}

/// Scenes that are compared with the march: round, thin, fine, full of leaves, and large ones.
const SPEEDUP_SCENES: &[&str] = &["sphere", "spring", "bunny", "fairy", "sponza"];

fn plan(context: &Context) -> Plan {
    let sweep = Sweep {
        map: 512,
        maps: &[256, 512, 1024, 2048],
        samples: &[8, 16, 32, 64, 128, 256, 512],
        hybrid: &[4, 8, 16, 32, 64],
        thresholds: &[1e-2, 1e-3],
        scales: &[2, 4],
        adaptive: &[0.05, 0.01, 0.002],
        tiles: &[8],
        grid: true,
    };
    let standard = Plan { side: 512, sweep, kinds: &LightKind::ALL, media: 2, scenes: None };
    let smoke = Plan {
        side: 64,
        sweep: Sweep {
            map: 128,
            maps: &[64, 128],
            samples: &[8, 64],
            hybrid: &[8],
            thresholds: &[1e-2],
            scales: &[2],
            adaptive: &[0.01],
            tiles: &[8],
            grid: false,
        },
        kinds: &[LightKind::Spot],
        media: 1,
        scenes: Some(&["bunny"]),
    };
    let plan = match context.preset {
        Preset::Smoke => smoke,
        Preset::Quick => Plan {
            side: 256,
            sweep: Sweep { maps: &[256, 1024], samples: &[8, 32, 128, 512], hybrid: &[16, 64], ..sweep },
            scenes: Some(&["bunny", "sponza"]),
            media: 1,
            ..standard
        },
        Preset::Standard => standard,
        Preset::Paper => Plan { side: 1024, ..standard },
    };
    if context.gpu.is_some() { plan } else { Plan { side: plan.side.min(64), ..smoke } }
}

/// A scene under a light.
pub(super) struct Case {
    pub(super) title: String,
    kind: LightKind,
    medium: String,
    triangles: u64,
    /// Side of the map that is given.
    pub(super) map: u32,
    pub(super) results: Vec<Measured>,
    /// What the planner expected of each; units: ms.
    pub(super) predicted: Vec<Option<f64>>,
    pub(super) picks: Vec<Pick>,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context);
    let title = "Time against error: every technique and setting on every scene";
    tell(context, &plan, "pareto", title, told::checks)
}

/// The planner's choices against the march alone.
pub(super) fn speedup(context: &Context) -> Outcome<Section> {
    let usual = plan(context);
    let full = context.preset >= Preset::Standard && context.gpu.is_some();
    let sweep = Sweep {
        maps: &[],
        samples: if full { &[32, 128, 512, 1536] } else { &[32, 256, 1024] },
        hybrid: &[],
        thresholds: &[],
        scales: &[],
        adaptive: &[0.05, 0.01, 0.002],
        tiles: &[],
        ..usual.sweep
    };
    let scenes = match context.preset {
        _ if full => Some(SPEEDUP_SCENES),
        // the other one is in the larger table
        Preset::Quick if context.gpu.is_some() => Some(&["sponza"][..]),
        _ => usual.scenes,
    };
    let plan = Plan { side: if full { 1024 } else { usual.side }, media: 1, scenes, sweep, ..usual };
    let title = "The planner's choice against marching at equal error";
    tell(context, &plan, "pareto-speedup", title, told::speedup_checks)
}

fn tell(
    context: &Context,
    plan: &Plan,
    id: &str,
    title: &str,
    checks: fn(&[Case]) -> Vec<Check>,
) -> Outcome<Section> {
    let mut found = experiment(context, id, title, "which technique a scene needs");
    found.adapter = gpu_or_cpu(context);
    let (cases, metrics) = (cases(context, plan)?, plan.sweep.metrics());
    let mut section = Section::default();
    for case in &cases {
        found.rows.extend(rows(case));
        found.equal_error.extend(told::equal_errors(metrics, case));
        section.plots.extend(metrics.iter().map(|metric| told::plot(*metric, case)));
    }
    section.tables.extend(metrics.iter().map(|metric| told::ways(*metric, &cases)));
    section.tables.push(told::predictions(&cases));
    found.checks = checks(&cases);
    found.notes = notes(context, plan);
    section.experiment = found;
    Ok(section)
}

/// Measures every set-up that the plan has.
fn cases(context: &Context, plan: &Plan) -> Outcome<Vec<Case>> {
    let mut cases = Vec::new();
    let media: Vec<(String, f32)> =
        context.setups.media().map(|(name, depth)| (name.to_owned(), depth)).collect();
    // the thin medium comes first
    let media: Vec<&(String, f32)> = media.iter().rev().take(plan.media).collect();
    let sources = context.setups.sources();
    let wanted = |id: &str| plan.scenes.is_none_or(|ids| ids.contains(&id));
    for source in sources.iter().filter(|source| wanted(&source.entry.id)) {
        for (medium, depth) in &media {
            for &kind in plan.kinds {
                let Some(setup) = source.setup_lit(*depth, kind)? else { continue };
                let title = format!("{}, {} light, {medium} medium", source.title(), kind.name());
                cases.push(measure(context, plan, title, medium.clone(), kind, setup)?);
            }
        }
    }
    Ok(cases)
}

fn measure(
    context: &Context,
    plan: &Plan,
    title: String,
    medium: String,
    kind: LightKind,
    setup: Setup,
) -> Outcome<Case> {
    tracing::info!("{title}");
    let map = plan.sweep.map;
    let mut arena = Arena::new(&context.references, title, setup, base(plan.side, map))?;
    let mut settings = pareto_settings::all(&plan.sweep, &arena);
    let picks = pareto_picks::choose(&arena, map, plan.sweep.metrics(), context.gpu.as_ref(), &mut settings)?;
    let predict = |setting: &super::measure::Setting| {
        planned::predict(&arena.setup, &arena.bvh, setting.technique, &setting.options)
    };
    let predicted = settings.iter().map(predict).collect();
    let mut results = arena.measure(context.gpu.as_ref(), &settings)?;
    // their errors are known, and some hundred pictures of a megapixel are not to be kept
    results.iter_mut().for_each(|result| result.image.pixels = Vec::new());
    let triangles = arena.triangles();
    Ok(Case { title: arena.title, kind, medium, triangles, map, results, predicted, picks })
}

fn rows(case: &Case) -> impl Iterator<Item = Row> {
    let frontier = Metric::ALL.map(|metric| case.frontier(metric));
    case.results.iter().zip(&case.predicted).map(move |(result, predicted)| {
        let mut row = result.row(&case.title, case.triangles);
        let mut param = |name: &str, value| _ = row.params.insert(name.into(), value);
        param("light", json!(case.kind.name()));
        param("medium", json!(case.medium));
        param("family", json!(family(&result.setting)));
        param("predicted_ms", json!(predicted));
        for (metric, frontier) in Metric::ALL.into_iter().zip(&frontier) {
            let on_it = frontier.iter().any(|(other, _)| std::ptr::eq(*other, result));
            param(&format!("frontier_{}", metric.name()), json!(on_it));
        }
        for pick in case.picks.iter().filter(|pick| std::ptr::eq(&case.results[pick.setting], result)) {
            let blind = if pick.pilot_ms.is_some() { "" } else { "_without_a_pilot" };
            let name = format!("chosen_for_{}_{}{blind}", pick.metric.name(), pick.target);
            param(&name, json!({"predicted_error": pick.predicted_error, "pilot_ms": pick.pilot_ms}));
        }
        row
    })
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only. All settings of a set-up take turns, the light moving in every frame: pyramids, silhouettes and tessellations are made anew.", plan.side),
        format!("Errors against the map are those of what reads the given map of {0}² texels (of each face), against the exact picture of that map in the meaning that it is read in. Against the geometry, any map may be drawn; drawing it is no part of the time, as for all techniques.", plan.sweep.map),
        "The planner is asked for 5, 1 and 0.2 %. A pilot measures the error of its candidates on 16 384 rays, or 65 536 where those leave a doubt, and on the picture or tiles of it what interpolation between few rays errs by and how many they are; without a pilot it goes by the errors that techniques usually have, and counts interpolation as all that it is allowed. What it chooses is measured with the others; choosing is no part of the time.".into(),
        "Froxels end with the scene: light that is scattered behind it, as far as view rays go, is part of their error.".into(),
    ];
    notes.extend(clock_note(context));
    notes
}
