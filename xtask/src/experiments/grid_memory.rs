//! `grid-fig14`: memory by number of viewers, dense and in bricks.

use froxel_grid::{Froxels, Lattice, MaskWidth, SharedGrid, dense_bytes, near_bytes};
use glam::Vec3;
use scene::Aabb;

use super::grid_bench::{Bench, Found};
use super::grid_scenes::{BISTRO, Place, SAN_MIGUEL, Scale, adapter, device, scene_notes};
use super::grid_stand::Stand;
use super::shown::slug;
use super::{Context, Preset, experiment};
use crate::failure::{Failure, Outcome};
use crate::froxels::brick_bytes;
use crate::gpu;
use crate::report::data::{Bound, Check};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Section, Series};

/// Scenes with the sides of voxels in the paper's figure, and in its Table 1; units: m.
const PLACES: [(Place, &[f32]); 2] = [(BISTRO, &[0.5, 0.333]), (SAN_MIGUEL, &[0.125])];

/// Largest binding that every WebGPU device has, of which the grid takes two; units: bytes.
const BINDING: u64 = 128 << 20;

/// The paper's picture.
const FULL: (u32, u32) = (1920, 1080);

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let scale = Scale::many(context);
    let title = "Memory by number of viewers";
    let mut found = experiment(context, "grid-fig14", title, "Stojanovic et al. 2023, Figure 14");
    let gpu = device(context).filter(|gpu| gpu::is_hardware(gpu));
    if gpu.is_some() {
        found.adapter = adapter(context);
    }
    let places = if context.preset == Preset::Smoke { &PLACES[..1] } else { &PLACES[..] };
    let mut section = Section::default();
    for &(place, voxels) in places {
        let stand = place.stand(context, scale, scale.most(), 0)?;
        let cast = scale.cast(stand.range);
        let mut contenders = vec![cast.reference()];
        contenders.extend(voxels.iter().flat_map(|&voxel| [cast.marked(voxel), cast.bricks(voxel)]));
        let mut bench = Bench::new(gpu, contenders)?;
        let mut all = Vec::new();
        for &viewers in scale.viewers {
            all.push(bench.count(&stand, viewers)?);
        }
        found.rows.extend(all.iter().flatten().map(|found| found.row(&stand)));
        found.checks.extend(brick_checks(&stand, &all, voxels)?);
        section.tables.push(table(&stand, &all, voxels)?);
        section.plots.push(plot(&stand, &all, voxels));
    }
    section.tables.push(full_table()?);
    found.checks.extend(checks()?);
    found.notes = vec![
        scale.note(),
        "Masks are packed into words as on a GPU. A froxel of ours holds 32 bytes on a GPU, scattering and what is accumulated in 32-bit floats; the paper's three volumes hold 8 bytes each. Bricks count that are in use; the pool for them is allocated at once.".into(),
        format!("The masks of a dense grid lie in two bindings of at most {} each, the least that WebGPU promises.", report::bytes(BINDING)),
    ];
    found.notes.extend(scene_notes(context));
    section.experiment = found;
    Ok(section)
}

fn dense(stand: &Stand, voxel: f32) -> Outcome<u64> {
    let lattice = SharedGrid::marked(voxel).lattice(&stand.bvh.bounds()).map_err(Failure::input)?;
    Ok(dense_bytes(&lattice, MaskWidth::Eight))
}

fn in_bricks(found: &Found) -> u64 {
    brick_bytes(found.counts.bricks, MaskWidth::Eight.bits())
}

/// The grid's memory, and that of a viewer in the paper's resolution.
fn table(stand: &Stand, all: &[Vec<Found>], voxels: &[f32]) -> Outcome<Table> {
    let mut columns = vec![Column::right("viewers"), Column::right("frustums, 1080p")];
    for voxel in voxels {
        columns.push(Column::right(format!("{voxel} m, dense")));
        columns.push(Column::right(format!("{voxel} m, bricks")));
        columns.push(Column::right("bricks over dense"));
    }
    let mut table = Table::new(format!("{}: memory of shadows", stand.title), columns);
    for line in all {
        let Some(first) = line.first() else { continue };
        let shared = Froxels::new(1.0).with_grid(SharedGrid::marked(1.0));
        let frustums = near_bytes(&shared, FULL) * first.viewers as u64;
        let mut cells = vec![first.viewers.to_string(), report::bytes(frustums)];
        for (index, &voxel) in voxels.iter().enumerate() {
            let (dense, bricks) = (dense(stand, voxel)?, line.get(2 + 2 * index).map(in_bricks));
            cells.push(report::bytes(dense));
            cells.push(report::bytes(bricks));
            cells.push(report::error(bricks.map(|bricks| bricks as f64 / dense as f64)));
        }
        table.push(cells);
    }
    Ok(table)
}

fn plot(stand: &Stand, all: &[Vec<Found>], voxels: &[f32]) -> Plot {
    let names = all.first().into_iter().flatten().map(|found| found.contender.name.clone());
    Plot {
        file: format!("{}-{}.svg", slug(&stand.title), slug(&format!("{voxels:?}"))),
        title: format!("{}: memory of a frame", stand.title),
        caption: "Memory of froxels, frustums and grid, by the number of viewers".into(),
        x: Axis::new("viewers", ""),
        y: Axis::new("memory", "bytes"),
        series: names
            .enumerate()
            .map(|(index, label)| Series {
                label,
                points: all
                    .iter()
                    .filter_map(|line| line.get(index))
                    .map(|found| (found.viewers as f64, found.bytes as f64))
                    .collect(),
                joined: true,
            })
            .collect(),
    }
}

fn brick_checks(stand: &Stand, all: &[Vec<Found>], voxels: &[f32]) -> Outcome<Vec<Check>> {
    let Some(last) = all.last() else { return Ok(Vec::new()) };
    let viewers = last.first().map_or(0, |found| found.viewers);
    let check = |(index, &voxel): (usize, &f32)| {
        let dense = dense(stand, voxel)?;
        let share = last.get(2 + 2 * index).map(|found| in_bricks(found) as f64 / dense as f64);
        let claim = format!(
            "{}, {viewers} viewers, {voxel} m: memory of bricks over that of a dense grid",
            stand.title
        );
        let mut check = Check::new(
            claim,
            "§5.1: the whole grid in memory is impractical",
            share,
            Bound::AtMost,
            1.0 / 3.0,
        );
        let missed: u64 = last.iter().map(|found| found.counts.missed).sum();
        check.note = (missed > 0).then(|| format!("{missed} reads found no brick"));
        Ok(check)
    };
    voxels.iter().enumerate().map(check).collect()
}

/// What the paper states, by formula.
fn full_table() -> Outcome<Table> {
    let columns = ["what", "the paper's", "ours"].map(Column::left).into();
    let mut table = Table::new("Memory by formula", columns);
    for (voxel, paper) in [(0.333, "27 MB"), (0.167, "216 MB")] {
        let what = format!("dense grid, 100 m cube, {voxel} m");
        table.push(vec![what, paper.into(), report::bytes(cube(voxel)?)]);
    }
    let shared = Froxels::new(1.0).with_grid(SharedGrid::paper(1.0));
    table.push(vec![
        "shadow frustum of a viewer, 1080p".into(),
        "0.4 MB".into(),
        report::bytes(near_bytes(&shared, FULL)),
    ]);
    Ok(table)
}

/// A dense grid over a cube of 100 m; units: bytes.
fn cube(voxel: f32) -> Outcome<u64> {
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(100.0) };
    let lattice = Lattice::new(&bounds, voxel).map_err(Failure::input)?;
    Ok(dense_bytes(&lattice, MaskWidth::Eight))
}

fn checks() -> Outcome<Vec<Check>> {
    let shared = Froxels::new(1.0).with_grid(SharedGrid::paper(1.0));
    let megabytes = |bytes: u64| Some(bytes as f64 / 1e6);
    Ok(vec![
        Check::new(
            "dense grid of 0.333 m voxels in a cube of 100 m, MB",
            "§4.3: around 27 MB",
            megabytes(cube(0.333)?),
            Bound::AtMost,
            28.0,
        ),
        Check::new(
            "shadow frustum of a viewer at 1920×1080, MB",
            "§4.3: about 0.4 MB",
            megabytes(near_bytes(&shared, FULL)),
            Bound::AtMost,
            0.45,
        ),
        Check::new(
            "dense grid of 0.167 m voxels in a cube of 100 m over what two bindings hold",
            "§4.3: about 216 MB",
            Some(cube(0.167)? as f64 / (2 * BINDING) as f64),
            Bound::AtMost,
            1.0,
        ),
    ])
}
