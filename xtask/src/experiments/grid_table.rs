//! `grid-table1` to `grid-table3`: Stojanovic et al.'s tables, the froxel reference against the shared grid by number of viewers.

use super::grid_bench::{Bench, Cast, Contender, Found, frames_note};
use super::grid_scenes::{
    BISTRO, Place, SAN_MIGUEL, Scale, TRASH_GOD, adapter, clock_note, device, scene_notes, voxel,
};
use super::grid_stand::Stand;
use super::{Context, Preset, experiment};
use crate::failure::Outcome;
use crate::gpu;
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};

/// Largest errors of the grid against the reference: mean FLIP, and share of what shadows change.
pub(super) const CLOSE: [f64; 2] = [0.02, 0.1];

/// One of the paper's tables.
#[derive(Debug, Clone, Copy)]
struct Paper<'a> {
    id: &'static str,
    number: u32,
    scene: &'static str,
    place: Place,
    /// Sides of voxels, the coarsest first; units: m.
    voxels: &'a [f32],
    /// By number of viewers: the reference, and the grid of each voxel size; units: ms.
    ms: &'static [(usize, &'static [f64])],
}

const TABLE_1: Paper<'static> = Paper {
    id: "grid-table1",
    number: 1,
    scene: "San Miguel",
    place: SAN_MIGUEL,
    voxels: &[0.125],
    ms: &[
        (1, &[1.10, 0.91]),
        (2, &[2.13, 1.57]),
        (3, &[3.17, 2.17]),
        (4, &[4.06, 2.73]),
        (6, &[5.54, 3.57]),
        (8, &[6.94, 4.57]),
        (12, &[10.68, 6.54]),
        (16, &[14.39, 8.57]),
    ],
};

const TABLE_2: Paper<'static> = Paper {
    id: "grid-table2",
    number: 2,
    scene: "Bistro (Exterior)",
    place: BISTRO,
    voxels: &[0.5, 0.333],
    ms: &[
        (1, &[4.58, 4.37, 7.82]),
        (2, &[9.44, 6.56, 13.73]),
        (3, &[13.77, 8.96, 18.41]),
        (4, &[17.84, 11.20, 22.28]),
        (6, &[26.53, 14.98, 27.48]),
        (8, &[34.89, 17.88, 32.28]),
        (12, &[52.02, 22.27, 37.60]),
        (16, &[68.86, 26.92, 44.37]),
    ],
};

const TABLE_3: Paper<'static> = Paper {
    id: "grid-table3",
    number: 3,
    scene: "Battle of the Trash God",
    place: TRASH_GOD,
    voxels: &[0.333, 0.25],
    ms: &[
        (1, &[2.41, 3.64, 7.12]),
        (2, &[6.17, 5.91, 10.69]),
        (3, &[9.53, 8.27, 14.52]),
        (4, &[19.97, 12.88, 21.11]),
        (6, &[25.43, 15.63, 24.30]),
        (8, &[31.87, 18.57, 27.83]),
        (12, &[45.68, 23.70, 32.96]),
        (16, &[67.53, 30.49, 39.88]),
    ],
};

pub(super) fn table1(context: &Context) -> Outcome<Section> {
    run(context, &TABLE_1)
}

pub(super) fn table2(context: &Context) -> Outcome<Section> {
    run(context, &TABLE_2)
}

pub(super) fn table3(context: &Context) -> Outcome<Section> {
    run(context, &TABLE_3)
}

/// The contenders for some viewers: the reference, then for each voxel size the paper's scheme and the marked grid.
struct Line(Vec<Found>);

impl Line {
    fn viewers(&self) -> usize {
        self.0.first().map_or(0, |found| found.viewers)
    }

    fn reference(&self) -> Option<&Found> {
        self.0.first()
    }

    /// The paper's scheme with the voxels of an index.
    fn paper(&self, voxel: usize) -> Option<&Found> {
        self.0.get(1 + 2 * voxel)
    }

    fn marked(&self, voxel: usize) -> Option<&Found> {
        self.0.get(2 + 2 * voxel)
    }

    /// A contender's figure over the reference's.
    fn over_reference(&self, found: Option<&Found>, figure: impl Fn(&Found) -> f64) -> Option<f64> {
        Some(figure(found?) / figure(self.reference()?))
    }
}

fn run(context: &Context, paper: &Paper<'_>) -> Outcome<Section> {
    let voxels: Vec<f32> = paper.voxels.iter().map(|&metres| voxel(context, metres)).collect();
    let paper = &Paper { voxels: &voxels, ..*paper };
    let scale = Scale::many(context);
    let mut found = experiment(
        context,
        paper.id,
        &format!("Shared shadow grid against the froxel reference, {}", paper.scene),
        &format!("Stojanovic et al. 2023, Table {}", paper.number),
    );
    found.adapter = adapter(context);
    let stand = paper.place.stand(context, scale, scale.most(), 1)?;
    let mut bench = Bench::new(device(context), contenders(paper, scale.cast(stand.range)))?;
    let mut lines = Vec::new();
    for &viewers in scale.viewers {
        tracing::info!("{}, {viewers} viewers", stand.title);
        lines.push(Line(bench.measure(&stand, viewers)?));
    }
    for line in &lines {
        found.rows.extend(line.0.iter().enumerate().map(|(index, one)| {
            let mut row = one.row(&stand);
            // both of our grids stand beside the paper's one
            let column = index.div_ceil(2);
            let ms = paper.ms.iter().find(|(viewers, _)| *viewers == line.viewers());
            let ms = ms.and_then(|(_, ms)| ms.get(column));
            row.paper = ms.map(|&ms| [("ms".to_owned(), ms.into())].into_iter().collect());
            row
        }));
    }
    let full = if context.preset == Preset::Standard { Some(full(context, paper)?) } else { None };
    if let Some((stand, line)) = &full {
        found.rows.extend(line.0.iter().map(|one| {
            let mut row = one.row(stand);
            row.params.insert("columns".into(), Scale::FULL.size.0.into());
            row
        }));
    }
    found.checks = checks(paper, &lines, full.as_ref().map(|(_, line)| line));
    found.notes = vec![scale.note(), frames_note()];
    found.notes.extend(scene_notes(context));
    found.notes.extend(clock_note(context));
    Ok(Section {
        tables: vec![table(paper, &lines)],
        plots: vec![
            plot(paper, &lines, "time", Axis::new("time of the fog", "ms"), Found::ms),
            plot(paper, &lines, "rays", Axis::new("shadow rays", ""), Found::rays),
        ],
        experiment: found,
        ..Section::default()
    })
}

/// Rays of the most viewers with as many froxels as the paper's, which are counted alone.
fn full(context: &Context, paper: &Paper<'_>) -> Outcome<(Stand, Line)> {
    let scale = Scale::FULL;
    let stand = paper.place.stand(context, scale, scale.most(), 0)?;
    let gpu = device(context).filter(|gpu| gpu::is_hardware(gpu));
    let mut all = Vec::new();
    for contender in contenders(paper, scale.cast(stand.range)) {
        tracing::info!("{}, {} viewers, rays of {}", stand.title, scale.most(), contender.name);
        // one after the other: the froxels of one take gigabytes
        all.extend(Bench::new(gpu, vec![contender])?.count(&stand, scale.most())?);
    }
    Ok((stand, Line(all)))
}

/// The reference, then for each voxel size the paper's scheme and the marked grid.
fn contenders(paper: &Paper<'_>, cast: Cast) -> Vec<Contender> {
    let grids = paper.voxels.iter().flat_map(|&voxel| [cast.paper(voxel), cast.marked(voxel)]);
    std::iter::once(cast.reference()).chain(grids).collect()
}

/// The paper's table with ours beside it: times as shares of the reference's.
fn table(paper: &Paper<'_>, lines: &[Line]) -> Table {
    let mut columns = vec![Column::right("viewers"), Column::right("reference"), Column::right("its rays")];
    for voxel in paper.voxels {
        for name in
            ["paper", "paper's scheme", "its rays", "marked", "its rays", "its FLIP", "its shadow error"]
        {
            columns.push(Column::right(format!("{voxel} m: {name}")));
        }
    }
    let mut table = Table::new("Time and rays, of grids as shares of the reference's", columns);
    for line in lines {
        let Some(reference) = line.reference() else { continue };
        let mut cells = vec![
            line.viewers().to_string(),
            report::time(reference.ms()),
            report::count(reference.counts.rays()),
        ];
        let published = paper.ms.iter().find(|(viewers, _)| *viewers == line.viewers());
        for index in 0..paper.voxels.len() {
            let ours = published.and_then(|(_, ms)| Some(ms.get(1 + index)? / ms.first()?));
            cells.push(report::error(ours));
            for found in [line.paper(index), line.marked(index)] {
                cells.push(report::error(line.over_reference(found, Found::ms)));
                cells.push(report::error(line.over_reference(found, Found::rays)));
            }
            let errors = line.marked(index).and_then(|found| found.errors);
            cells.push(report::figure(errors.map(|errors| errors.flip)));
            cells.push(report::error(errors.and_then(|errors| errors.shadow_err)));
        }
        table.push(cells);
    }
    table
}

fn plot(paper: &Paper<'_>, lines: &[Line], what: &str, y: Axis, figure: fn(&Found) -> f64) -> Plot {
    let count = lines.first().map_or(0, |line| line.0.len());
    let series = (0..count).map(|index| Series {
        label: lines
            .first()
            .and_then(|line| line.0.get(index))
            .map_or_else(String::new, |f| f.contender.name.clone()),
        points: lines
            .iter()
            .filter_map(|line| Some((line.viewers() as f64, figure(line.0.get(index)?))))
            .collect(),
        joined: true,
    });
    Plot {
        file: format!("{what}.svg"),
        title: format!("{}: {}", paper.scene, y.label),
        caption: format!("{} of a frame of all viewers, by how many they are", y.label),
        x: Axis::new("viewers", ""),
        y,
        series: series.collect(),
    }
}

fn checks(paper: &Paper<'_>, lines: &[Line], full: Option<&Line>) -> Vec<Check> {
    let (Some(last), Some(first)) = (lines.last(), lines.first()) else { return Vec::new() };
    let (most, finest) = (last.viewers(), paper.voxels.len() - 1);
    let mut checks = Vec::new();
    for (index, voxel) in paper.voxels.iter().enumerate().take(1) {
        // savings need many froxels for every voxel: those of the paper's pictures where they were counted
        let line = full.unwrap_or(last);
        let saved = |found| line.over_reference(found, Found::rays).map(|share| 1.0 - share);
        let of = if full.is_some() { ", froxels as many as the paper's" } else { "" };
        let claim = format!(
            "{} viewers, {voxel} m{of}: share of shadow rays that the paper's scheme saves",
            line.viewers()
        );
        let claimed = "§4.2, Figure 11: 40 to 60 %";
        let mut check = Check::new(claim, claimed, saved(line.paper(index)), Bound::AtLeast, 0.4);
        check.note = Some(format!("the marked grid saves {}", report::error(saved(line.marked(index)))));
        checks.push(check);
        let time = last.over_reference(last.paper(index), Found::ms);
        let claim = format!("{most} viewers, {voxel} m: time of the paper's scheme over the reference's");
        let mut check = Check::new(claim, "§4.2: an increase of 40 to 60 %", time, Bound::AtMost, 1.0);
        let published = paper.ms.last().and_then(|(_, ms)| Some(ms.get(1 + index)? / ms.first()?));
        check.note = published.map(|ratio| format!("the paper's own: {}", report::error(ratio)));
        checks.push(check);
    }
    if paper.voxels.len() > 1
        && let Some(voxel) = paper.voxels.last()
    {
        let loss = first.over_reference(first.paper(finest), Found::ms);
        let claim = format!(
            "{} viewers, {voxel} m: time of the paper's scheme over the reference's, a loss",
            first.viewers()
        );
        checks.push(Check::new(claim, "§4.2: small voxels lose with few viewers", loss, Bound::AtLeast, 1.0));
    }
    let every = |from: usize, figure: fn(&Found) -> f64| {
        let of_line = move |line: &Line| -> Vec<f64> {
            (0..paper.voxels.len()).filter_map(|i| line.over_reference(line.marked(i), figure)).collect()
        };
        let lines = lines.iter().filter(|line| line.viewers() >= from);
        lines.flat_map(of_line).reduce(f64::max)
    };
    let beyond = "beyond the paper: §4.2 names the voxels that nothing reads";
    checks.extend([
        Check::new(
            "most shadow rays of the marked grid over the reference's, any number of viewers and voxel size",
            beyond,
            every(1, Found::rays),
            Bound::AtMost,
            1.0,
        ),
        Check::new(
            "most time of the marked grid over the reference's, two viewers or more",
            beyond,
            every(2, Found::ms),
            Bound::AtMost,
            1.0,
        ),
        Check::new(
            format!("{most} viewers: most time of the marked grid over the reference's"),
            beyond,
            every(most, Found::ms),
            Bound::AtMost,
            0.35,
        ),
    ]);
    let worst = |error: fn(&Found) -> Option<f64>| {
        let found = lines.iter().flat_map(|line| (0..paper.voxels.len()).filter_map(|i| line.marked(i)));
        found.filter_map(error).reduce(f64::max)
    };
    let flip = worst(|found| Some(found.errors?.flip));
    let shadow = worst(|found| found.errors?.shadow_err);
    let close = "§4.2: closely approximates the quality of the reference";
    checks.extend([
        Check::new(
            "largest FLIP of the marked grid against the reference",
            close,
            flip,
            Bound::AtMost,
            CLOSE[0],
        ),
        Check::new(
            "largest shadow error of the marked grid against the reference",
            close,
            shadow,
            Bound::AtMost,
            CLOSE[1],
        ),
    ]);
    checks
}
