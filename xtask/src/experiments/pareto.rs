//! `pareto`: every technique and setting on every scene, time against error.
//!
//! All settings of a scene take turns. Errors against the geometry are those of the picture; errors against the map are
//! those of what reads the map that a host has, in the meaning that it is read in.

use serde_json::json;

use super::measure::{Arena, Measured, base};
use super::pareto_settings::{self, Sweep, family};
use super::shown::clock_note;
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::report::Section;
use crate::scene_args::Setup;
use crate::setups::LightKind;

/// How much is measured.
#[derive(Clone, Copy)]
struct Plan {
    side: u32,
    sweep: Sweep,
    kinds: &'static [LightKind],
    media: usize,
    scenes: usize,
}

fn plan(context: &Context) -> Plan {
    let sweep = Sweep {
        map: 512,
        maps: &[256, 512, 1024, 2048],
        samples: &[8, 16, 32, 64, 128, 256, 512],
        hybrid: &[4, 8, 16, 32, 64],
        thresholds: &[1e-2, 1e-3],
        scales: &[2, 4],
        tiles: &[8],
        grid: true,
    };
    let standard = Plan { side: 512, sweep, kinds: &LightKind::ALL, media: 2, scenes: usize::MAX };
    let smoke = Plan {
        side: 64,
        sweep: Sweep {
            map: 128,
            maps: &[64, 128],
            samples: &[8, 64],
            hybrid: &[8],
            thresholds: &[1e-2],
            scales: &[2],
            tiles: &[8],
            grid: false,
        },
        kinds: &[LightKind::Spot],
        media: 1,
        scenes: 1,
    };
    let plan = match context.preset {
        Preset::Smoke => smoke,
        Preset::Quick => Plan {
            side: 256,
            sweep: Sweep { maps: &[256, 512, 1024], samples: &[8, 32, 128, 512], hybrid: &[4, 16, 64], ..sweep },
            scenes: 2,
            media: 1,
            ..standard
        },
        Preset::Standard => standard,
        Preset::Paper => Plan { side: 1024, ..standard },
    };
    if context.gpu.is_some() { plan } else { Plan { side: plan.side.min(64), ..smoke } }
}

/// A scene under a light.
struct Case {
    title: String,
    kind: LightKind,
    medium: String,
    triangles: u64,
    results: Vec<Measured>,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context);
    let mut found = experiment(
        context,
        "pareto",
        "Time against error: every technique and setting on every scene",
        "which technique a scene needs",
    );
    found.adapter = gpu_or_cpu(context);
    let mut cases = Vec::new();
    let media: Vec<(String, f32)> =
        context.setups.media().map(|(name, depth)| (name.to_owned(), depth)).collect();
    let thin_first = media.iter().rev().take(plan.media);
    let sources = context.setups.sources();
    let quick = context.preset < Preset::Standard;
    for source in sources.iter().filter(|source| !quick || source.entry.quick).take(plan.scenes) {
        for (medium, depth) in thin_first.clone() {
            for &kind in plan.kinds {
                let Some(setup) = source.setup_lit(*depth, kind)? else { continue };
                let title = format!("{}, {} light, {medium} medium", source.title(), kind.name());
                cases.push(measure(context, &plan, title, medium.clone(), kind, setup)?);
            }
        }
    }
    for case in &cases {
        found.rows.extend(case.results.iter().map(|result| {
            let mut row = result.row(&case.title, case.triangles);
            row.params.insert("light".into(), json!(case.kind.name()));
            row.params.insert("medium".into(), json!(case.medium));
            row.params.insert("family".into(), json!(family(&result.setting)));
            row
        }));
    }
    found.notes.extend(clock_note(context));
    Ok(Section { experiment: found, ..Section::default() })
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
    let mut arena = Arena::new(title, setup, base(plan.side, plan.sweep.map))?;
    let settings = pareto_settings::all(&plan.sweep, &arena);
    let results = arena.measure(context.gpu.as_ref(), &settings)?;
    let triangles = arena.triangles();
    Ok(Case { title: arena.title, kind, medium, triangles, results })
}
