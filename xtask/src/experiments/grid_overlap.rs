//! `grid-fig12`: viewers who share a fixed part of what they see.

use super::grid_bench::{Bench, Found, frames_note};
use super::grid_scenes::{BISTRO, Scale, adapter, clock_note, device, scene_notes};
use super::grid_stand::Stand;
use super::{Context, Preset, experiment};
use crate::failure::Outcome;
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};
use crate::viewers::turned;

/// Side of a voxel in the paper's figure; units: m.
const VOXEL: f32 = 0.333;

/// What a viewer may cost who sees what another sees, over one of the reference.
const MARGINAL: f64 = 0.35;

/// All contenders by overlap and number of viewers.
struct Case {
    percent: u32,
    all: Vec<Found>,
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let mut scale = Scale::many(context);
    let percents: &[u32] = match context.preset {
        Preset::Smoke => &[100],
        Preset::Quick => &[10, 100],
        Preset::Standard => &[10, 25, 50, 75, 100],
        Preset::Paper => &[10, 20, 30, 40, 50, 60, 70, 80, 90, 100],
    };
    scale.viewers = match context.preset {
        Preset::Smoke => &[1, 2],
        Preset::Quick => &[1, 8],
        Preset::Standard | Preset::Paper => &[1, 2, 4, 8, 16],
    };
    let title = "Viewers with a fixed overlap";
    let mut found = experiment(context, "grid-fig12", title, "Stojanovic et al. 2023, Figure 12");
    found.adapter = adapter(context);
    let mut stand = BISTRO.stand(context, scale, 1, 0)?;
    let cast = scale.cast(stand.range);
    let contenders = vec![cast.reference(), cast.paper(VOXEL), cast.marked(VOXEL)];
    let mut bench = Bench::new(device(context), contenders)?;
    let mut cases = Vec::new();
    for &percent in percents {
        let overlap = f64::from(percent) / 100.0;
        stand.look(turned(&stand.setup.camera, scale.size, overlap, scale.most()), 1)?;
        for &viewers in scale.viewers {
            tracing::info!("{}, {percent} % overlap, {viewers} viewers", stand.title);
            let all = bench.measure(&stand, viewers)?;
            found.rows.extend(all.iter().map(|found| {
                let mut row = found.row(&stand);
                row.params.insert("overlap".into(), overlap.into());
                row
            }));
            cases.push(Case { percent, all });
        }
    }
    found.checks = checks(&cases, percents);
    found.notes = vec![
        scale.note(),
        frames_note(),
        "One camera is duplicated and turned about its up axis. The overlap is the share of the angle between the left and the right edge of the picture that neighbours have in common; once they have gone around, others overlap too.".into(),
    ];
    found.notes.extend(scene_notes(context));
    found.notes.extend(clock_note(context));
    Ok(Section {
        tables: vec![table(&cases)],
        plots: vec![plot(&stand, &cases, percents)],
        experiment: found,
        ..Section::default()
    })
}

fn table(cases: &[Case]) -> Table {
    let columns = [
        "overlap",
        "viewers",
        "reference",
        "its rays",
        "paper's grid",
        "its rays",
        "its FLIP",
        "marked grid",
        "its rays",
        "its FLIP",
    ];
    let mut table = Table::new(
        format!("Voxels of {VOXEL} m; times and rays of grids over the reference's"),
        columns.map(Column::right).into(),
    );
    for Case { percent, all } in cases {
        let [reference, paper, marked] = &all[..] else { continue };
        let mut cells = vec![
            format!("{percent} %"),
            reference.viewers.to_string(),
            report::time(reference.ms()),
            report::count(reference.counts.rays()),
        ];
        for grid in [paper, marked] {
            cells.push(report::error(grid.ms() / reference.ms()));
            cells.push(report::error(grid.rays() / reference.rays()));
            cells.push(report::figure(grid.errors.map(|errors| errors.flip)));
        }
        table.push(cells);
    }
    table
}

fn plot(stand: &Stand, cases: &[Case], percents: &[u32]) -> Plot {
    let points = |percent: u32, index: usize| {
        let of = cases.iter().filter(move |case| case.percent == percent);
        of.filter_map(move |case| case.all.get(index))
            .map(|found| (found.viewers as f64, found.ms()))
            .collect()
    };
    let (low, high) = (percents.first().copied().unwrap_or(100), percents.last().copied().unwrap_or(100));
    let mut series = vec![Series { label: "reference".into(), points: points(high, 0), joined: true }];
    for percent in if low == high { vec![high] } else { vec![low, high] } {
        for (index, name) in [(1, "paper's grid"), (2, "marked grid")] {
            let label = format!("{name}, {percent} % overlap");
            series.push(Series { label, points: points(percent, index), joined: true });
        }
    }
    Plot {
        file: "time.svg".into(),
        title: format!("{}: time of the fog", stand.title),
        caption: format!("Time of a frame of all viewers with voxels of {VOXEL} m, by how many they are"),
        x: Axis::new("viewers", ""),
        y: Axis::new("time of the fog", "ms"),
        series,
    }
}

/// A figure by its name.
type Named = (&'static str, fn(&Found) -> f64);

const FIGURES: [Named; 2] = [("time", Found::ms), ("shadow rays", Found::rays)];

/// What each viewer adds, between the last two numbers of viewers.
fn marginal(cases: &[Case], percent: u32, index: usize, figure: fn(&Found) -> f64) -> Option<f64> {
    let all: Vec<&Found> =
        cases.iter().filter(|case| case.percent == percent).filter_map(|case| case.all.get(index)).collect();
    let [.., a, b] = &all[..] else { return None };
    Some((figure(b) - figure(a)) / (b.viewers - a.viewers) as f64)
}

fn checks(cases: &[Case], percents: &[u32]) -> Vec<Check> {
    let full = percents.last().copied().unwrap_or(100);
    let mut checks = Vec::new();
    for (name, figure) in FIGURES {
        for (index, grid) in [(1, "the paper's grid"), (2, "the marked grid")] {
            let share = marginal(cases, full, index, figure)
                .zip(marginal(cases, full, 0, figure))
                .map(|(grid, reference)| grid / reference);
            let claim =
                format!("{full} % overlap: {name} that a viewer adds to {grid}, over the reference's");
            checks.push(Check::new(claim, "§4.2: sub-linear in viewers", share, Bound::AtMost, MARGINAL));
        }
    }
    let ratios = |index: usize, from: usize, figure: fn(&Found) -> f64| {
        let of = cases.iter().filter(move |case| case.all.first().is_some_and(|found| found.viewers >= from));
        of.filter_map(move |case| Some(figure(case.all.get(index)?) / figure(case.all.first()?)))
            .reduce(f64::max)
    };
    checks.push(Check::new(
        "most shadow rays of the marked grid over the reference's, any overlap",
        "beyond the paper: §4.2 names the voxels that nothing reads",
        ratios(2, 1, Found::rays),
        Bound::AtMost,
        1.0,
    ));
    checks.push(Check::new(
        "most time of the marked grid over the reference's, two viewers or more, any overlap",
        "beyond the paper",
        ratios(2, 2, Found::ms),
        Bound::AtMost,
        1.0,
    ));
    checks.push(Check::new(
        "most time of the paper's grid over the reference's, 8 viewers or more, any overlap",
        "§4.2: with 8 viewers it wins even at 10 % overlap",
        ratios(1, 8, Found::ms),
        Bound::AtMost,
        1.0,
    ));
    checks
}
