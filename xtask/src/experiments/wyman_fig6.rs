//! `wyman-fig6`: error and time against samples per ray under a textured spot, for the march over the whole cone and the
//! hybrid's three segments.

use hybrid_march::Placement;
use scene::AirlightModel;

use super::counts::{Counts, LIT_NOTE};
use super::measure::{Arena, Measured, Setting};
use super::shown::{clock_note, slug};
use super::wyman_bench::{self, at_error, lit, model_name, panels};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::report::data::{Bound, Check, EqualError};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, PictureRow, Plot, Section, Series};
use crate::technique::{HybridOptions, Options, Technique};

/// Errors at which costs are compared.
const TARGETS: [f64; 2] = [0.02, 0.005];

/// How many times fewer steps the hybrid is to need there.
const FEWER: f64 = 2.0;

/// How near to each other's least error "the best that both reach" is, as a factor.
const NEARLY: f64 = 1.02;

/// A figure of a measurement.
type Figure = fn(&Measured) -> f64;

struct Plan {
    side: u32,
    map: u32,
    /// Of the march.
    samples: &'static [u32],
    /// Of the hybrid, as it comes, and of its other placements.
    hybrid: [&'static [u32]; 2],
}

fn plan(preset: Preset) -> Plan {
    const MANY: &[u32] = &[10, 20, 40, 75, 100, 150, 200, 300, 400, 600, 800];
    match preset {
        Preset::Smoke => Plan { side: 64, map: 256, samples: &[10, 75, 300], hybrid: [&[10, 75], &[]] },
        Preset::Quick => Plan {
            side: 256,
            map: 1024,
            samples: &[10, 20, 40, 75, 150, 300, 600],
            hybrid: [&[10, 20, 40, 75], &[20, 75]],
        },
        Preset::Standard => Plan { side: 512, map: 1024, samples: MANY, hybrid: [MANY, &[10, 40, 100, 300]] },
        Preset::Paper => Plan { side: 1024, map: 1024, samples: MANY, hybrid: [MANY, MANY] },
    }
}

impl Plan {
    fn of(&self, variant: Variant, model: AirlightModel) -> &'static [u32] {
        match variant {
            Variant::BruteForce => self.samples,
            _ if variant == Variant::default_for(model) => self.hybrid[0],
            Variant::Hybrid(..) => self.hybrid[1],
        }
    }
}

/// A way to place and colour the steps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Variant {
    BruteForce,
    Hybrid(Placement, bool),
}

impl Variant {
    const ALL: [Self; 5] = [
        Self::BruteForce,
        Self::Hybrid(Placement::EqualDistance, false),
        Self::Hybrid(Placement::EqualDistance, true),
        Self::Hybrid(Placement::EqualAngle, false),
        Self::Hybrid(Placement::EqualAngle, true),
    ];

    /// What the hybrid takes where nothing else is asked for.
    fn default_for(model: AirlightModel) -> Self {
        Self::Hybrid(HybridOptions::default().placement(model), true)
    }

    fn name(self) -> String {
        let Self::Hybrid(placement, mips) = self else { return "brute-force".into() };
        let placement = match placement {
            Placement::EqualDistance => "equal distance",
            Placement::EqualAngle => "equal angle",
        };
        format!("hybrid, {placement}, {}", if mips { "mips" } else { "no mips" })
    }

    fn setting(self, base: Options, samples: u32) -> Setting {
        let mut options = Options { samples: Some(samples), ..base };
        let technique = match self {
            Self::BruteForce => Technique::BruteForce,
            Self::Hybrid(placement, mips) => {
                options.hybrid.placement = Some(placement);
                options.hybrid.mips = mips.then_some(0.0);
                Technique::Hybrid
            }
        };
        Setting::new(format!("{}, {samples} samples", self.name()), technique, options)
    }
}

/// All samples of one model.
struct Case {
    model: AirlightModel,
    lit: Arena,
    found: Vec<(Variant, Measured)>,
}

impl Case {
    fn series(&self, variant: Variant) -> impl Iterator<Item = &Measured> {
        self.found.iter().filter(move |(of, _)| *of == variant).map(|(_, found)| found)
    }

    fn best(&self, variant: Variant) -> f64 {
        self.series(variant).map(|found| found.on_geometry.rel_rmse).fold(f64::INFINITY, f64::min)
    }

    /// The error at which costs are compared: the wanted one, or the best that both reach.
    fn reachable(&self, target: f64) -> f64 {
        let best = [Variant::BruteForce, Variant::default_for(self.model)].map(|v| self.best(v));
        let least = best[0].max(best[1]);
        if least <= target { target } else { NEARLY * least }
    }

    /// Brute force's value of `x` over a variant's at equal error.
    fn ratio(&self, variant: Variant, target: f64, x: impl Fn(&Measured) -> f64) -> Option<f64> {
        Some(
            at_error(self.series(Variant::BruteForce), &x, target)?
                / at_error(self.series(variant), &x, target)?,
        )
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let plan = Plan { side: context.marched_side(plan.side), ..plan };
    let mut found = experiment(
        context,
        "wyman-fig6",
        "Error and time against samples per ray, textured spot light",
        "Wyman & Ramsey 2008, Figure 6",
    );
    found.adapter = gpu_or_cpu(context);
    let source = wyman_bench::source(context, "sphere")?;
    let mut cases = Vec::new();
    for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
        let Some(setup) = wyman_bench::textured(&source, wyman_bench::thin(context), model)? else {
            continue;
        };
        let title = format!("{}, stained glass, {}", source.title(), model_name(model));
        let mut lit = lit(context, title, setup, [plan.side, plan.map], f64::INFINITY)?;
        let pairs: Vec<(Variant, u32)> = Variant::ALL
            .into_iter()
            .flat_map(|variant| plan.of(variant, model).iter().map(move |&samples| (variant, samples)))
            .collect();
        let settings: Vec<Setting> =
            pairs.iter().map(|(variant, samples)| variant.setting(lit.base, *samples)).collect();
        let measured = wyman_bench::measure(context, &mut lit, &settings)?;
        let found = pairs.into_iter().map(|(variant, _)| variant).zip(measured).collect();
        cases.push(Case { model, lit, found });
    }
    let mut section = Section::default();
    for case in &cases {
        let row = |(_, result): &(Variant, Measured)| result.row(&case.lit.title, case.lit.triangles());
        found.rows.extend(case.found.iter().map(row));
        found.equal_error.extend(TARGETS.iter().map(|&target| equal_error(case, target)));
        found.checks.extend(TARGETS.iter().flat_map(|&target| checks(case, target)));
        section.tables.push(table(case));
        section.plots.extend(plots(case));
        section.pictures.extend(pictures(case)?);
    }
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

fn equal_error(case: &Case, target: f64) -> EqualError {
    let target = case.reachable(target);
    let variants: Vec<Variant> =
        Variant::ALL.into_iter().filter(|&variant| case.series(variant).next().is_some()).collect();
    EqualError {
        scene: case.lit.title.clone(),
        metric: "rel_rmse".into(),
        target,
        ms: variants.iter().map(|v| (v.name(), at_error(case.series(*v), Measured::ms, target))).collect(),
        speedup_over_brute_force: variants
            .iter()
            .filter(|v| **v != Variant::BruteForce)
            .map(|v| (v.name(), case.ratio(*v, target, Measured::ms)))
            .collect(),
    }
}

fn checks(case: &Case, wanted: f64) -> Vec<Check> {
    let target = case.reachable(wanted);
    let variant = Variant::default_for(case.model);
    let percent = |error: f64| format!("{:.3} %", 100.0 * error);
    let costs: [(&str, Figure, f64); 3] =
        [("steps", Measured::steps, FEWER), ("lookups", Measured::lookups, FEWER), ("ms", Measured::ms, 1.0)];
    costs
        .into_iter()
        .map(|(name, cost, bar)| {
            let mut check = Check::new(
                format!(
                    "{}: times fewer {name} than marching the whole cone, at rel_rmse {}",
                    case.lit.title,
                    percent(target)
                ),
                "Figure 6: more than 300 samples against 75 to 100",
                case.ratio(variant, target, cost),
                Bound::AtLeast,
                bar,
            );
            let at = |variant| at_error(case.series(variant), cost, target);
            let mut note = format!(
                "{} of the march, {} of {}; ratio of times {}",
                report::figure(at(Variant::BruteForce)),
                report::figure(at(variant)),
                variant.name(),
                report::ratio(case.ratio(variant, target, Measured::ms))
            );
            if target != wanted {
                let best = [Variant::BruteForce, variant].map(|v| percent(case.best(v)));
                note += &format!(
                    "; {} is not reached by both: at {NEARLY} times the best that both reach (the march {}, the hybrid {})",
                    percent(wanted),
                    best[0],
                    best[1]
                );
            }
            check.note = Some(note);
            check
        })
        .collect()
}

fn table(case: &Case) -> Table {
    let mut table = Table::new(
        format!("{}: error and time by samples", case.lit.title),
        [
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
        .map(|(i, &name)| if i == 0 { Column::left(name) } else { Column::right(name) })
        .collect(),
    );
    for (_, found) in &case.found {
        table.push(vec![
            found.setting.name.clone(),
            report::figure(found.steps()),
            report::figure(found.lookups()),
            report::time(found.ms()),
            report::error(found.on_geometry.rel_rmse),
            report::error(found.on_map.map(|on_map| on_map.rel_rmse)),
            report::error(found.on_geometry.shadow_err),
        ]);
    }
    table
}

fn plots(case: &Case) -> Vec<Plot> {
    let axes: [(&str, Axis, Figure); 3] = [
        ("samples", Axis::new("samples per ray", ""), |found| f64::from(found.samples())),
        ("steps", Axis::new("steps or lookups per covered pixel, the greater", ""), |found| {
            found.counts.map_or(f64::NAN, Counts::most)
        }),
        ("time", Axis::new("time of the airlight", "ms"), Measured::ms),
    ];
    axes.into_iter()
        .map(|(name, x, of)| Plot {
            file: format!("{}-{name}.svg", slug(&case.lit.title)),
            title: format!("{}: error against {name}", case.lit.title),
            caption: "Error is rel_rmse against the exact picture; the map's own error is the floor.".into(),
            x,
            y: Axis::new("relative RMSE", ""),
            series: Variant::ALL
                .into_iter()
                .map(|variant| Series {
                    label: variant.name(),
                    points: case
                        .series(variant)
                        .map(|found| (of(found), found.on_geometry.rel_rmse))
                        .collect(),
                    joined: true,
                })
                .filter(|series| !series.points.is_empty())
                .collect(),
        })
        .collect()
}

/// The paper's pairs: the march at 75 and 300 or so, the hybrid at 75.
fn pictures(case: &Case) -> Outcome<Option<PictureRow>> {
    let mut pictures = Vec::new();
    for (variant, samples) in
        [(Variant::BruteForce, 75), (Variant::BruteForce, 300), (Variant::default_for(case.model), 75)]
    {
        let mut series = case.series(variant);
        let Some(found) = series.find(|found| found.setting.options.samples == Some(samples)) else {
            continue;
        };
        pictures.extend(panels(&case.lit, found)?);
    }
    Ok(Some(PictureRow { caption: format!("{}, airlight only", case.lit.title), panels: pictures })
        .filter(|row| !row.panels.is_empty()))
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium; map {1}².", plan.side, plan.map),
        "N samples of the hybrid are N between the faces of the shadow volumes and N/2 in each lit segment beside them; boundaries are bisected six times. The march takes N over the whole cone.".into(),
        LIT_NOTE.into(),
        "The window is of 128² texels: one look at the picture in the middle of a step misses panes that a mean over the step does not.".into(),
    ];
    notes.extend(clock_note(context));
    notes
}
