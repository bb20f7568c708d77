//! `grid-scale`: one to 256 viewers, and scenes of 50 m to 1 km: how rays and memory grow.

use froxel_grid::{GridMemory, MaskWidth, SharedGrid, dense_bytes};

use super::grid_bench::{Bench, Contender, Found, exponent};
use super::grid_scenes::Scale;
use super::grid_stand::Stand;
use super::grid_town::town;
use super::{Context, Preset, experiment};
use crate::failure::{Failure, Outcome};
use crate::froxels::brick_bytes;
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};
use crate::viewers::scattered;

/// Side of a voxel; units: m.
const VOXEL: f32 = 0.25;

/// Where froxels end; units: m.
const RANGE: f32 = 128.0;

/// Room for so many bricks: 67 million voxels.
const MOST: u32 = 1 << 17;

/// What is varied, and what stays while the other is.
struct Plan {
    scale: Scale,
    /// Units: m.
    extents: &'static [f32],
    /// Extent at which viewers are varied; units: m.
    extent: f32,
    /// Viewers at which the extent is varied.
    viewers: usize,
}

fn plan(preset: Preset) -> Plan {
    let of = |size, tile, viewers, extents, at| Plan {
        scale: Scale { size, tile, viewers },
        extents,
        extent: 250.0,
        viewers: at,
    };
    let all: &[f32] = &[50.0, 100.0, 250.0, 500.0, 1000.0];
    match preset {
        Preset::Smoke => of((16, 9), 1, &[1, 2], &all[..2], 2),
        Preset::Quick => of((40, 22), 1, &[1, 4, 16, 64], all, 4),
        Preset::Standard => of((64, 36), 1, &[1, 4, 16, 64, 256], all, 16),
        Preset::Paper => of((120, 68), 1, &[1, 4, 16, 64, 256], all, 16),
    }
}

/// One count.
struct Case {
    extent: f32,
    viewers: usize,
    reference: Found,
    bricks: Found,
    /// What a dense grid would take; units: bytes.
    dense: u64,
}

impl Case {
    fn brick_bytes(&self) -> u64 {
        brick_bytes(self.bricks.counts.bricks, MaskWidth::Eight.bits())
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let title = "Viewers and extent of the scene";
    let mut found =
        experiment(context, "grid-scale", title, "beyond Stojanovic et al. 2023, §5.1: large scenes");
    let (by_extent, rows) = by_extent(context, &plan)?;
    found.rows.extend(rows);
    let (by_viewers, rows) = by_viewers(context, &plan)?;
    found.rows.extend(rows);
    found.checks = checks(&by_viewers, &by_extent);
    found.notes = vec![
        plan.scale.note(),
        format!("A town of houses on a square ground, voxels of {VOXEL} m in bricks, froxels up to {RANGE} m, a lamp and the sun. Viewers walk from its middle crossing, at most 25 m from one another, however large the town is. Everything is counted on the CPU, nothing is timed."),
        "Exponents are slopes of a line through the counts in logarithms. Froxels that are far apart read voxels of their own, which nobody shares: the fewer froxels a viewer has, the more rays grow with viewers.".into(),
    ];
    let viewers = table("By number of viewers", &by_viewers);
    let extents = table("By extent of the scene", &by_extent);
    let plots = vec![
        plot("viewers", "viewers", "", &by_viewers, |case| case.viewers as f64),
        plot("extent", "extent of the scene", "m", &by_extent, |case| case.extent.into()),
    ];
    Ok(Section { tables: vec![viewers, extents], plots, experiment: found, ..Section::default() })
}

fn by_extent(context: &Context, plan: &Plan) -> Outcome<(Vec<Case>, Vec<Row>)> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    for &extent in plan.extents {
        let (stand, mut bench) = stand(context, plan, extent, plan.viewers)?;
        let (case, both) = count(&stand, &mut bench, extent, plan.viewers)?;
        cases.push(case);
        rows.extend(both);
    }
    Ok((cases, rows))
}

fn by_viewers(context: &Context, plan: &Plan) -> Outcome<(Vec<Case>, Vec<Row>)> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let (stand, mut bench) = stand(context, plan, plan.extent, plan.scale.most())?;
    for &viewers in plan.scale.viewers {
        tracing::info!("{}, {viewers} viewers", stand.title);
        let (case, both) = count(&stand, &mut bench, plan.extent, viewers)?;
        cases.push(case);
        rows.extend(both);
    }
    Ok((cases, rows))
}

fn stand(context: &Context, plan: &Plan, extent: f32, viewers: usize) -> Outcome<(Stand, Bench<'static>)> {
    let title = format!("town of {extent} m");
    tracing::info!("{title}");
    let scale = plan.scale;
    let mut stand = Stand::new(context, title, town(extent)?, (scale.size, scale.tile), Some(RANGE))?;
    stand.look(scattered(&stand.setup.cameras(), &stand.bvh, viewers), 0)?;
    let cast = scale.cast(RANGE);
    let grid = SharedGrid { memory: GridMemory::Bricks { most: MOST }, ..SharedGrid::marked(VOXEL) };
    let bricks = Contender::new(format!("marked grid in bricks, {VOXEL} m"), cast.0.with_grid(grid));
    Ok((stand, Bench::new(None, vec![cast.reference(), bricks])?))
}

fn count(stand: &Stand, bench: &mut Bench<'_>, extent: f32, viewers: usize) -> Outcome<(Case, Vec<Row>)> {
    let all = bench.count(stand, viewers)?;
    let rows = all.iter().map(|found| found.row(stand)).collect();
    let lattice = SharedGrid::marked(VOXEL).lattice(&stand.bvh.bounds()).map_err(Failure::input)?;
    let dense = dense_bytes(&lattice, MaskWidth::Eight);
    let Ok([reference, bricks]) = <[Found; 2]>::try_from(all) else {
        return Err(Failure::program("grid-scale counts two contenders"));
    };
    Ok((Case { extent, viewers, reference, bricks, dense }, rows))
}

fn table(title: &str, cases: &[Case]) -> Table {
    let columns = vec![
        Column::right("extent"),
        Column::right("viewers"),
        Column::right("froxels"),
        Column::right("reference's rays"),
        Column::right("grid's rays"),
        Column::right("over the reference's"),
        Column::right("of voxels"),
        Column::right("bricks"),
        Column::right("their memory"),
        Column::right("dense"),
        Column::right("missed"),
    ];
    let mut table = Table::new(title, columns);
    for case in cases {
        let (reference, bricks) = (&case.reference, &case.bricks);
        table.push(vec![
            format!("{} m", case.extent),
            case.viewers.to_string(),
            report::count(reference.counts.froxels),
            report::count(reference.counts.rays()),
            report::count(bricks.counts.rays()),
            report::error(bricks.rays() / reference.rays()),
            report::count(bricks.counts.grid_rays),
            report::count(bricks.counts.bricks),
            report::bytes(case.brick_bytes()),
            report::bytes(case.dense),
            report::count(bricks.counts.missed),
        ]);
    }
    table
}

fn plot(file: &str, label: &str, unit: &str, cases: &[Case], x: fn(&Case) -> f64) -> Plot {
    let series = |label: &str, y: &dyn Fn(&Case) -> f64| Series {
        label: label.into(),
        points: cases.iter().map(|case| (x(case), y(case))).collect(),
        joined: true,
    };
    Plot {
        file: format!("{file}.svg"),
        title: format!("Rays and memory by {label}"),
        caption: format!("Shadow rays of a frame and bytes of the grid by {label}"),
        x: Axis::new(label, unit),
        y: Axis::new("rays, or bytes", ""),
        series: vec![
            series("rays of the reference", &|case| case.reference.rays()),
            series("rays with the grid", &|case| case.bricks.rays()),
            series("rays of voxels", &|case| case.bricks.counts.grid_rays as f64),
            series("bytes in bricks", &|case| case.brick_bytes() as f64),
            series("bytes if dense", &|case| case.dense as f64),
        ],
    }
}

fn checks(by_viewers: &[Case], by_extent: &[Case]) -> Vec<Check> {
    let fit = |cases: &[Case], x: fn(&Case) -> f64, y: fn(&Case) -> f64| {
        exponent(cases.iter().map(|case| (x(case), y(case))))
    };
    let viewers: fn(&Case) -> f64 = |case| case.viewers as f64;
    let extent: fn(&Case) -> f64 = |case| case.extent.into();
    let rays: fn(&Case) -> f64 = |case| case.bricks.rays();
    let voxels: fn(&Case) -> f64 = |case| case.bricks.counts.grid_rays as f64;
    let bricks: fn(&Case) -> f64 = |case| case.brick_bytes() as f64;
    let dense: fn(&Case) -> f64 = |case| case.dense as f64;
    let check = |claim: &str, measured, bar| {
        Check::new(claim, "beyond §5.1: cost grows with what is visible", measured, Bound::AtMost, bar)
    };
    let reference = fit(by_viewers, viewers, |case| case.reference.rays());
    let mut in_viewers = check(
        "exponent of shadow rays in viewers, over the reference's",
        fit(by_viewers, viewers, rays).zip(reference).map(|(ours, reference)| ours / reference),
        1.0,
    );
    in_viewers.note = Some(format!(
        "{} for the grid with its frustums, {} for its voxels alone, {} for the reference",
        report::figure(fit(by_viewers, viewers, rays)),
        report::figure(fit(by_viewers, viewers, voxels)),
        report::figure(reference)
    ));
    let mut in_extent =
        check("exponent of the bricks' memory in the extent", fit(by_extent, extent, bricks), 1.0);
    in_extent.note = Some(format!("{} for a dense grid", report::figure(fit(by_extent, extent, dense))));
    vec![
        in_viewers,
        check("exponent of the bricks' memory in viewers", fit(by_viewers, viewers, bricks), 0.9),
        check("exponent of shadow rays in the extent", fit(by_extent, extent, rays), 0.5),
        in_extent,
        check(
            "reads that found no brick, as a share of froxels",
            by_viewers
                .iter()
                .chain(by_extent)
                .map(|case| case.bricks.counts.missed as f64 / case.bricks.counts.froxels.max(1) as f64)
                .reduce(f64::max),
            0.0,
        ),
    ]
}
