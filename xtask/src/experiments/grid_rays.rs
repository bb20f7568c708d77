//! `grid-fig11`: shadow rays by number of viewers, counted with as many froxels as the paper's where there is time.

use super::grid_bench::{Bench, Found};
use super::grid_scenes::{Scale, TRASH_GOD, VIEWERS, adapter, device, scene_notes};
use super::grid_stand::Stand;
use super::{Context, Preset, experiment};
use crate::failure::Outcome;
use crate::gpu;
use crate::report::data::{Bound, Check};
use crate::report::{Axis, Plot, Section, Series};

/// Sides of voxels in the paper's figure; units: m.
const VOXELS: [f32; 2] = [0.333, 0.25];

fn scale(context: &Context) -> Scale {
    let of = |size, viewers| Scale { size, tile: 1, viewers };
    match context.preset {
        Preset::Smoke => of((16, 9), &[1, 2]),
        Preset::Quick => of((64, 36), &[1, 2, 4, 8, 16]),
        Preset::Standard => of((120, 68), VIEWERS),
        Preset::Paper => of((240, 135), VIEWERS),
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let scale = scale(context);
    let title = "Shadow rays by number of viewers";
    let mut found = experiment(context, "grid-fig11", title, "Stojanovic et al. 2023, Figure 11");
    // counts are the same on both, and software rasterisers are no faster
    let gpu = device(context).filter(|gpu| gpu::is_hardware(gpu));
    if gpu.is_some() {
        found.adapter = adapter(context);
    }
    let stand = TRASH_GOD.stand(context, scale, scale.most(), 0)?;
    let cast = scale.cast(stand.range);
    let mut contenders = vec![cast.reference()];
    contenders.extend(VOXELS.iter().flat_map(|&voxel| [cast.paper(voxel), cast.marked(voxel)]));
    let mut bench = Bench::new(gpu, contenders)?;
    let mut all = Vec::new();
    for &viewers in scale.viewers {
        tracing::info!("{}, {viewers} viewers", stand.title);
        all.push(bench.count(&stand, viewers)?);
    }
    found.rows.extend(all.iter().flatten().map(|found| found.row(&stand)));
    found.checks = checks(&all);
    found.notes = vec![scale.note(), "Rays are counted, not timed; the marked grid does not trace a light for a voxel that it cannot reach, nor does the reference for a froxel.".into()];
    found.notes.extend(scene_notes(context));
    Ok(Section { plots: vec![plot(&stand, &all)], experiment: found, ..Section::default() })
}

fn plot(stand: &Stand, all: &[Vec<Found>]) -> Plot {
    let names = all.first().into_iter().flatten().map(|found| found.contender.name.clone());
    Plot {
        file: "rays.svg".into(),
        title: format!("{}: shadow rays", stand.title),
        caption: "Shadow rays of a frame of all viewers, by how many they are".into(),
        x: Axis::new("viewers", ""),
        y: Axis::new("shadow rays", ""),
        series: names
            .enumerate()
            .map(|(index, label)| Series {
                label,
                points: all
                    .iter()
                    .filter_map(|line| line.get(index))
                    .map(|found| (found.viewers as f64, found.rays()))
                    .collect(),
                joined: true,
            })
            .collect(),
    }
}

fn checks(all: &[Vec<Found>]) -> Vec<Check> {
    let share = |line: &[Found], index: usize| Some(line.get(index)?.rays() / line.first()?.rays());
    let Some(last) = all.last() else { return Vec::new() };
    let most = last.first().map_or(0, |found| found.viewers);
    let mut checks = Vec::new();
    for (index, voxel) in VOXELS.iter().enumerate() {
        let saved = share(last, 1 + 2 * index).map(|share| 1.0 - share);
        let claim = format!("{most} viewers, {voxel} m: share of shadow rays that the paper's scheme saves");
        checks.push(Check::new(claim, "Figure 11: 40 to 60 % fewer", saved, Bound::AtLeast, 0.4));
    }
    let worst = all
        .iter()
        .flat_map(|line| (0..VOXELS.len()).filter_map(move |index| share(line, 2 + 2 * index)))
        .reduce(f64::max);
    checks.push(Check::new(
        "most shadow rays of the marked grid over the reference's",
        "beyond the paper: §4.2 names the voxels that nothing reads",
        worst,
        Bound::AtMost,
        1.0,
    ));
    checks
}
