//! `grid-fig13`: what each stage takes, and tracing's share.

use std::collections::BTreeMap;

use froxel_grid::{Near, SharedGrid};

use super::grid_bench::{Bench, Cast, Contender, Found, frames_note};
use super::grid_scenes::{BISTRO, Scale, adapter, clock_note, device, scene_notes};
use super::grid_stand::Stand;
use super::{Context, experiment};
use crate::failure::Outcome;
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Section};

/// Side of a voxel in the paper's figure; units: m.
const VOXEL: f32 = 0.333;

/// Tracing's share of the reference's time, by the paper.
const SHARE: f64 = 0.8;

/// Stages that trace shadows or find out which are needed.
const SHADOWS: [&str; 3] = ["near shadows", "marks", "grid shadows"];

/// What takes turns: the reference, its froxels without shadows, and two grids with and without frustums.
fn contenders(cast: Cast) -> Vec<Contender> {
    let open = Contender { casts: false, ..Contender::new("froxels, nothing casts a shadow", cast.0) };
    let without = |name: &str, grid: SharedGrid| {
        let grid = SharedGrid { near: Near::Grid, ..grid };
        Contender::new(format!("{name} without frustums, {VOXEL} m"), cast.0.with_grid(grid))
    };
    vec![
        cast.reference(),
        open,
        cast.paper(VOXEL),
        without("paper's grid", SharedGrid::paper(VOXEL)),
        cast.marked(VOXEL),
        without("marked grid", SharedGrid::marked(VOXEL)),
    ]
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let scale = Scale::many(context);
    let title = "Time of each stage";
    let mut found = experiment(context, "grid-fig13", title, "Stojanovic et al. 2023, Figure 13");
    found.adapter = adapter(context);
    let stand = BISTRO.stand(context, scale, scale.most(), 1)?;
    let mut bench = Bench::new(device(context), contenders(scale.cast(stand.range)))?;
    let mut lines = Vec::new();
    for &viewers in scale.viewers {
        tracing::info!("{}, {viewers} viewers", stand.title);
        let all = bench.measure(&stand, viewers)?;
        let stages: Vec<BTreeMap<String, f64>> =
            [(0, 1), (2, 3), (4, 5)].map(|(whole, part)| stages(&all, whole, part)).into();
        for (index, found_one) in all.iter().enumerate() {
            let mut row = found_one.row(&stand);
            if index % 2 == 0 {
                row.stages = stages[index / 2].clone();
            }
            found.rows.push(row);
        }
        lines.push((viewers, all, stages));
    }
    found.checks = checks(&lines);
    let stamped = lines.iter().any(|(_, all, _)| !all[0].stages().is_empty());
    found.notes = vec![scale.note(), frames_note(), how(stamped)];
    found.notes.extend(scene_notes(context));
    found.notes.extend(clock_note(context));
    let table = table(&stand, &lines);
    Ok(Section { tables: vec![table], experiment: found, ..Section::default() })
}

/// How stages were timed.
fn how(stamped: bool) -> String {
    if stamped {
        "Stages are the time stamps of their passes.".into()
    } else {
        "There are no time stamps to rely on: stages are differences of frames. Lighting, march and the rest are a frame in which nothing casts a shadow; the reference's tracing is what it takes beyond that. The grid's tracing is what a grid without frustums takes beyond it, reads included, and the frustums are what they add.".into()
    }
}

/// Stages of a contender: stamped, or differences from the frame without its frustums and from the one without shadows.
fn stages(all: &[Found], whole: usize, part: usize) -> BTreeMap<String, f64> {
    let (Some(found), Some(part_of), Some(open)) = (all.get(whole), all.get(part), all.get(1)) else {
        return BTreeMap::new();
    };
    let stamped = found.stages();
    if !stamped.is_empty() {
        return stamped;
    }
    // noise may make a stage take less than nothing
    let beyond = |ms: f64, base: f64| (ms - base).max(0.0);
    let mut stages: BTreeMap<String, f64> = [("lighting, march and the rest".to_owned(), open.ms())].into();
    if whole == 0 {
        stages.insert("near shadows".into(), beyond(found.ms(), open.ms()));
    } else {
        stages.insert("grid shadows".into(), beyond(part_of.ms(), open.ms()));
        stages.insert("near shadows".into(), beyond(found.ms(), part_of.ms()));
    }
    stages
}

type Line = (usize, Vec<Found>, Vec<BTreeMap<String, f64>>);

/// Shadows' share of a contender's stages.
fn share(stages: &BTreeMap<String, f64>) -> Option<f64> {
    let all: f64 = stages.values().sum();
    let shadows: f64 = SHADOWS.iter().filter_map(|stage| stages.get(*stage)).sum();
    (all > 0.0).then(|| shadows / all)
}

fn table(stand: &Stand, lines: &[Line]) -> Table {
    let columns = vec![
        Column::right("viewers"),
        Column::left("technique"),
        Column::right("frustums, or the reference's rays"),
        Column::right("marks"),
        Column::right("voxels"),
        Column::right("the rest"),
        Column::right("shadows' share"),
        Column::right("shadow error"),
    ];
    let mut table = Table::new(format!("{}: time of each stage, voxels of {VOXEL} m", stand.title), columns);
    for (viewers, all, stages) in lines {
        for (found, stages) in all.iter().step_by(2).zip(stages) {
            let rest: f64 =
                stages.iter().filter(|(name, _)| !SHADOWS.contains(&name.as_str())).map(|(_, ms)| ms).sum();
            let mut cells = vec![viewers.to_string(), found.contender.name.clone()];
            cells.extend(SHADOWS.map(|stage| report::time(stages.get(stage).copied())));
            cells.push(report::time(rest));
            cells.push(report::error(share(stages)));
            cells.push(report::error(found.errors.and_then(|errors| errors.shadow_err)));
            table.push(cells);
        }
    }
    table.without_empty_columns()
}

fn checks(lines: &[Line]) -> Vec<Check> {
    let Some((viewers, _, stages)) = lines.last() else { return Vec::new() };
    let claim = format!("{viewers} viewers: tracing's share of the reference's time");
    let paper = "§3: roughly 80 % of the total cost";
    let mut check = Check::new(claim, paper, stages.first().and_then(share), Bound::AtLeast, SHARE);
    let first = lines.first().and_then(|(viewers, _, stages)| Some((viewers, share(stages.first()?)?)));
    check.note = first.map(|(viewers, share)| format!("with {viewers}: {}", report::error(share)));
    vec![check]
}
