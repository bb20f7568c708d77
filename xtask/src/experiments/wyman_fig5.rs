//! `wyman-fig5`: the march over the whole cone beside the hybrid at equal samples, at equal cost and at equal quality.

use scene::AirlightModel;

use super::equal_error::interpolate;
use super::wyman_bench::{self, COUNT_NOTE, Found, Lit, Setting, at_error, model_name};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::image_file::to_srgb8;
use crate::report::data::{Bound, Check, EqualError};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Panel, PanelKind, PictureRow, Plot, Section, Series};
use crate::technique::{Options, Technique};

/// Steps of the hybrid between the faces.
const HYBRID_SAMPLES: u32 = 50;

/// Most steps of the march that is to be as good.
const MOST: f64 = 4000.0;

struct Plan {
    side: u32,
    map: u32,
    /// Steps of the marches from which equal cost and equal quality are found.
    sweep: &'static [u32],
    models: &'static [AirlightModel],
}

fn plan(preset: Preset) -> Plan {
    const BOTH: &[AirlightModel] = &[AirlightModel::HoffmanPreetham, AirlightModel::Sun];
    const SWEEP: &[u32] = &[20, 50, 100, 200, 400, 800, 1600];
    match preset {
        Preset::Smoke => Plan { side: 64, map: 256, sweep: &[20, 100, 400], models: &BOTH[..1] },
        Preset::Quick => Plan { side: 256, map: 1024, sweep: &SWEEP[1..6], models: &BOTH[..1] },
        Preset::Standard => Plan { side: 512, map: 1024, sweep: SWEEP, models: BOTH },
        Preset::Paper => Plan { side: 1024, map: 1024, sweep: SWEEP, models: BOTH },
    }
}

/// One model's pictures.
struct Case {
    lit: Lit,
    sweep: Vec<Found>,
    hybrid: Found,
    /// The march with as many steps, in as much time, and with as small an error, as far as it gets there.
    equal: [Option<Found>; 3],
}

/// What is equal.
const EQUAL: [&str; 3] = ["equal samples", "equal cost", "equal quality"];

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let mut found = experiment(
        context,
        "wyman-fig5",
        "Marching at equal samples, equal cost and equal quality",
        "Wyman & Ramsey 2008, Figure 5",
    );
    found.adapter = gpu_or_cpu(context);
    let source = wyman_bench::source(context, "bunny")?;
    let mut section = Section::default();
    let mut table = Table::new(
        "Beside the hybrid",
        [
            "scene",
            "technique",
            "steps a pixel",
            "lookups a pixel",
            "time",
            "rel_rmse",
            "rel_rmse on the map",
            "shadow error",
        ]
        .iter()
        .enumerate()
        .map(|(i, &name)| if i < 2 { Column::left(name) } else { Column::right(name) })
        .collect(),
    );
    for &model in plan.models {
        let Some(setup) = wyman_bench::textured(&source, wyman_bench::thin(context), model)? else {
            continue;
        };
        let title = format!("{}, stained glass, {}", source.title(), model_name(model));
        let lit = Lit::new(title, setup, plan.side, plan.map)?;
        let case = measure(context, &plan, lit)?;
        let matched = case.equal.iter().flatten();
        for result in case.sweep.iter().chain([&case.hybrid]).chain(matched.clone()) {
            found.rows.push(result.row(&case.lit));
        }
        for result in [&case.hybrid].into_iter().chain(matched) {
            table.push(vec![
                case.lit.title.clone(),
                result.setting.name.clone(),
                report::figure(result.counts.steps),
                report::figure(result.counts.lookups),
                report::time(result.ms()),
                report::error(result.exact.rel_rmse),
                report::error(result.on_map.map(|on_map| on_map.rel_rmse)),
                report::error(result.exact.shadow_err),
            ]);
        }
        found.equal_error.push(equal_error(&case));
        found.checks.extend(checks(&case));
        section.plots.push(plot(&case));
        section.pictures.push(pictures(&case)?);
    }
    section.tables.push(table);
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

fn march(base: Options, samples: u32, name: String) -> Setting {
    Setting { name, technique: Technique::BruteForce, options: Options { samples: Some(samples), ..base } }
}

fn hybrid(base: Options) -> Setting {
    Setting {
        name: format!("hybrid, {HYBRID_SAMPLES} samples"),
        technique: Technique::Hybrid,
        options: Options { samples: Some(HYBRID_SAMPLES), ..base },
    }
}

/// First a sweep, in which the step counts are found; then the hybrid in turns with the marches that equal it.
fn measure(context: &Context, plan: &Plan, lit: Lit) -> Outcome<Case> {
    let base = lit.base();
    let sweep =
        plan.sweep.iter().map(|&samples| march(base, samples, format!("brute force, {samples} samples")));
    let mut sweep = lit.measure(context, sweep.chain([hybrid(base)]).collect())?;
    let Some(first) = sweep.pop() else {
        return Err(crate::failure::Failure::program("a sweep without a hybrid"));
    };
    let samples = |found: &Found| f64::from(found.setting.options.samples.unwrap_or(0));
    // falling curves: times grow with the steps
    let cost = interpolate(sweep.iter().map(|found| (samples(found), 1.0 / found.ms())), 1.0 / first.ms());
    let quality = at_error(sweep.iter(), samples, first.exact.rel_rmse);
    let counts = [Some(first.counts.most()), cost, quality];
    let mut settings = vec![hybrid(base)];
    let mut which = Vec::new();
    for (i, count) in counts.into_iter().enumerate() {
        if let Some(count) = count.filter(|count| *count <= MOST) {
            // as good, not nearly as good
            let count = if i == 2 { count.ceil() } else { count.round() }.max(1.0) as u32;
            settings.push(march(base, count, format!("brute force, {}: {count} samples", EQUAL[i])));
            which.push(i);
        }
    }
    let mut measured = lit.measure(context, settings)?.into_iter();
    let hybrid = measured.next().unwrap_or(first);
    let mut equal = [None, None, None];
    for (i, found) in which.into_iter().zip(measured) {
        equal[i] = Some(found);
    }
    Ok(Case { lit, sweep, hybrid, equal })
}

fn equal_error(case: &Case) -> EqualError {
    let [_, _, quality] = &case.equal;
    let (march, hybrid) = (quality.as_ref().map(Found::ms), case.hybrid.ms());
    EqualError {
        scene: case.lit.title.clone(),
        metric: "rel_rmse".into(),
        target: case.hybrid.exact.rel_rmse,
        ms: [("brute-force".to_owned(), march), ("hybrid".to_owned(), Some(hybrid))].into(),
        speedup_over_brute_force: [("hybrid".to_owned(), march.map(|march| march / hybrid))].into(),
    }
}

fn checks(case: &Case) -> Vec<Check> {
    let [samples, cost, quality] = &case.equal;
    let title = &case.lit.title;
    let paper = "Figure 5: higher quality for equal sampling, a speed improvement at equal quality";
    let error = |found: &Found| found.exact.rel_rmse;
    let times_error = |found: &Option<Found>| Some(error(found.as_ref()?) / error(&case.hybrid));
    let note = |check: &mut Check, found: &Option<Found>| {
        check.note = found.as_ref().map(|found| {
            format!(
                "march {} at {} with {:.0} steps a pixel; hybrid {} at {} with {:.0} steps and {:.0} lookups",
                report::time(found.ms()),
                report::error(error(found)),
                found.counts.steps,
                report::time(case.hybrid.ms()),
                report::error(error(&case.hybrid)),
                case.hybrid.counts.steps,
                case.hybrid.counts.lookups
            )
        });
    };
    let mut checks = Vec::new();
    for (name, found) in [(EQUAL[0], samples), (EQUAL[1], cost)] {
        let claim = format!("{title}, {name}: the march's rel_rmse, times the hybrid's");
        let mut check = Check::new(claim, paper, times_error(found), Bound::AtLeast, 1.0);
        note(&mut check, found);
        checks.push(check);
    }
    let costs = [
        ("steps", quality.as_ref().map(|found| found.counts.steps / case.hybrid.counts.steps)),
        ("lookups", quality.as_ref().map(|found| found.counts.lookups / case.hybrid.counts.lookups)),
        ("time", quality.as_ref().map(|found| found.ms() / case.hybrid.ms())),
    ];
    for (name, ratio) in costs {
        let claim = format!("{title}, {}: the march's {name}, times the hybrid's", EQUAL[2]);
        let mut check = Check::new(claim, paper, ratio, Bound::AtLeast, 1.0);
        note(&mut check, quality);
        checks.push(check);
    }
    checks
}

fn plot(case: &Case) -> Plot {
    let point = |found: &Found| (found.ms(), found.exact.rel_rmse);
    let matched: Vec<&Found> = case.equal.iter().flatten().collect();
    Plot {
        file: format!("{}.svg", wyman_bench::slug(&case.lit.title)),
        title: format!("{}: error against time", case.lit.title),
        caption: "Error is rel_rmse against the exact picture; the map's own error is the floor.".into(),
        x: Axis::new("time of the airlight", "ms"),
        y: Axis::new("relative RMSE", ""),
        series: vec![
            Series {
                label: "brute force".into(),
                points: case.sweep.iter().map(point).collect(),
                joined: true,
            },
            Series {
                label: "brute force, matched".into(),
                points: matched.into_iter().map(point).collect(),
                joined: false,
            },
            Series {
                label: case.hybrid.setting.name.clone(),
                points: vec![point(&case.hybrid)],
                joined: false,
            },
        ],
    }
}

fn pictures(case: &Case) -> Outcome<PictureRow> {
    let lit = &case.lit;
    let mut panels: Vec<Panel> = case.hybrid.panels(lit, &case.hybrid.setting.name)?.into();
    for (found, name) in case.equal.iter().zip(EQUAL) {
        let Some(found) = found else { continue };
        let samples = found.setting.options.samples.unwrap_or(0);
        panels.extend(found.panels(lit, &format!("brute force, {name}, {samples} samples"))?);
    }
    panels.push(Panel::new(
        format!("{}-exact.png", wyman_bench::slug(&lit.title)),
        "exact",
        format!("Airlight of {}, exact", lit.title),
        &to_srgb8(&lit.exact, lit.exposure()),
        PanelKind::Plain,
    )?);
    Ok(PictureRow { caption: format!("{}, airlight only", lit.title), panels })
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium; map {1}².", plan.side, plan.map),
        format!("The hybrid takes {HYBRID_SAMPLES} steps between the faces and half as many in each lit segment beside them, six bisections a boundary, and mips of the window. Equal samples: the march takes as many as the hybrid has steps or lookups on average, whichever are more."),
        "Equal cost and equal quality are interpolated in a sweep; the marches found are then measured in turns with the hybrid. A march that does not get there in 4000 steps is not measured.".into(),
        COUNT_NOTE.into(),
    ];
    notes.extend(wyman_bench::clock_note(context));
    notes
}
