//! `wyman-fig5`: the march over the whole cone beside the hybrid at equal samples, at equal cost and at equal quality.

use scene::AirlightModel;

use super::counts::{Counts, LIT_NOTE};
use super::equal_error::interpolate;
use super::measure::{Arena, Measured, Setting};
use super::shown::{clock_note, display_scale, slug};
use super::wyman_bench::{self, at_error, lit, model_name, panels};
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
    lit: Arena,
    sweep: Vec<Measured>,
    hybrid: Measured,
    /// The march with as many steps, in as much time, and with as small an error, as far as it gets there.
    equal: [Option<Measured>; 3],
}

/// What is equal.
const EQUAL: [&str; 3] = ["equal samples", "equal cost", "equal quality"];

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
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
        let lit = lit(context, title, setup, [plan.side, plan.map], f64::INFINITY)?;
        let case = measure(context, &plan, lit)?;
        let matched = case.equal.iter().flatten();
        for result in case.sweep.iter().chain([&case.hybrid]).chain(matched.clone()) {
            found.rows.push(result.row(&case.lit.title, case.lit.triangles()));
        }
        for result in [&case.hybrid].into_iter().chain(matched) {
            table.push(vec![
                case.lit.title.clone(),
                result.setting.name.clone(),
                report::figure(result.steps()),
                report::figure(result.lookups()),
                report::time(result.ms()),
                report::error(result.on_geometry.rel_rmse),
                report::error(result.on_map.map(|on_map| on_map.rel_rmse)),
                report::error(result.on_geometry.shadow_err),
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
    Setting::new(name, Technique::BruteForce, Options { samples: Some(samples), ..base })
}

fn hybrid(base: Options) -> Setting {
    let options = Options { samples: Some(HYBRID_SAMPLES), ..base };
    Setting::new(format!("hybrid, {HYBRID_SAMPLES} samples"), Technique::Hybrid, options)
}

/// First a sweep, in which the step counts are found; then the hybrid in turns with the marches that equal it.
fn measure(context: &Context, plan: &Plan, mut lit: Arena) -> Outcome<Case> {
    let base = lit.base;
    let sweep =
        plan.sweep.iter().map(|&samples| march(base, samples, format!("brute force, {samples} samples")));
    let sweep: Vec<Setting> = sweep.chain([hybrid(base)]).collect();
    let mut sweep = wyman_bench::measure(context, &mut lit, &sweep)?;
    let Some(first) = sweep.pop() else {
        return Err(crate::failure::Failure::program("a sweep without a hybrid"));
    };
    let samples = |found: &Measured| f64::from(found.samples());
    // falling curves: times grow with the steps
    let cost = interpolate(sweep.iter().map(|found| (samples(found), 1.0 / found.ms())), 1.0 / first.ms());
    let quality = at_error(sweep.iter(), samples, first.on_geometry.rel_rmse);
    let counts = [first.counts.map(Counts::most), cost, quality];
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
    let mut measured = wyman_bench::measure(context, &mut lit, &settings)?.into_iter();
    let hybrid = measured.next().unwrap_or(first);
    let mut equal = [None, None, None];
    for (i, found) in which.into_iter().zip(measured) {
        equal[i] = Some(found);
    }
    Ok(Case { lit, sweep, hybrid, equal })
}

fn equal_error(case: &Case) -> EqualError {
    let [_, _, quality] = &case.equal;
    let (march, hybrid) = (quality.as_ref().map(Measured::ms), case.hybrid.ms());
    EqualError {
        scene: case.lit.title.clone(),
        metric: "rel_rmse".into(),
        target: case.hybrid.on_geometry.rel_rmse,
        ms: [("brute-force".to_owned(), march), ("hybrid".to_owned(), Some(hybrid))].into(),
        speedup_over_brute_force: [("hybrid".to_owned(), march.map(|march| march / hybrid))].into(),
    }
}

fn checks(case: &Case) -> Vec<Check> {
    let [samples, cost, quality] = &case.equal;
    let title = &case.lit.title;
    let paper = "Figure 5: higher quality for equal sampling, a speed improvement at equal quality";
    let error = |found: &Measured| found.on_geometry.rel_rmse;
    let times_error = |found: &Option<Measured>| Some(error(found.as_ref()?) / error(&case.hybrid));
    let note = |check: &mut Check, found: &Option<Measured>| {
        check.note = found.as_ref().map(|found| {
            format!(
                "march {} at {} with {:.0} steps a pixel; hybrid {} at {} with {:.0} steps and {:.0} lookups",
                report::time(found.ms()),
                report::error(error(found)),
                found.steps(),
                report::time(case.hybrid.ms()),
                report::error(error(&case.hybrid)),
                case.hybrid.steps(),
                case.hybrid.lookups()
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
        ("steps", quality.as_ref().map(|found| found.steps() / case.hybrid.steps())),
        ("lookups", quality.as_ref().map(|found| found.lookups() / case.hybrid.lookups())),
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
    let point = |found: &Measured| (found.ms(), found.on_geometry.rel_rmse);
    let matched: Vec<&Measured> = case.equal.iter().flatten().collect();
    Plot {
        file: format!("{}.svg", slug(&case.lit.title)),
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
    let mut pictures: Vec<Panel> = panels(lit, &case.hybrid)?.into();
    for found in case.equal.iter().flatten() {
        pictures.extend(panels(lit, found)?);
    }
    pictures.push(Panel::new(
        format!("{}-exact.png", slug(&lit.title)),
        "exact",
        format!("Airlight of {}, exact", lit.title),
        &to_srgb8(&lit.exact, display_scale(&lit.exact, 95)),
        PanelKind::Plain,
    )?);
    Ok(PictureRow { caption: format!("{}, airlight only", lit.title), panels: pictures })
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium; map {1}².", plan.side, plan.map),
        format!("The hybrid takes {HYBRID_SAMPLES} steps between the faces and half as many in each lit segment beside them, six bisections a boundary, and mips of the window. Equal samples: the march takes as many as the hybrid has steps or lookups on average, whichever are more."),
        "Equal cost and equal quality are interpolated in a sweep; the marches found are then measured in turns with the hybrid. A march that does not get there in 4000 steps is not measured.".into(),
        LIT_NOTE.into(),
    ];
    notes.extend(clock_note(context));
    notes
}
