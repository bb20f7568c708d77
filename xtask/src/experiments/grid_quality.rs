//! `grid-fig6` and `grid-fig7`: how far the grid is from the froxel reference, by the size of its voxels.

use super::equal_error::interpolate;
use super::grid_bench::{Bench, Contender, Found, frames_note};
use super::grid_scenes::{
    BISTRO, OLD_SPONZA, Place, SIBENIK, SPONZA, Scale, adapter, clock_note, device, scene_notes,
};
use super::grid_stand::Stand;
use super::grid_table::CLOSE;
use super::shown::{Shown, display_scale, slug};
use super::{Context, Preset, experiment};
use crate::failure::Outcome;
use crate::image_file::to_srgb8;
use crate::report::data::{Bound, Check, Experiment};
use crate::report::{self, Axis, Panel, PanelKind, PictureRow, Plot, Section, Series};
use froxel_grid::{GridReads, Near, SharedGrid};

/// Sides of voxels in the paper's Figure 6, and smaller ones until the grid is close enough; units: m.
const FIG_6: &[f32] = &[4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625];

/// Those of Figure 7.
const FIG_7: &[f32] = &[0.5, 0.25, 0.1];

/// Slices of the paper's frustum.
const FRUSTUM: u32 = 43;

/// Most voxels of a dense grid here.
const MOST_VOXELS: f64 = 3e8;

pub(super) fn fig6(context: &Context) -> Outcome<Section> {
    let voxels = match context.preset {
        Preset::Smoke => &FIG_6[..3],
        Preset::Quick => &FIG_6[..6],
        Preset::Standard | Preset::Paper => FIG_6,
    };
    let title = "Error against the size of voxels";
    let found = experiment(context, "grid-fig6", title, "Stojanovic et al. 2023, Figure 6");
    run(context, found, &[BISTRO], voxels)
}

pub(super) fn fig7(context: &Context) -> Outcome<Section> {
    let places: &[Place] = match context.preset {
        Preset::Standard | Preset::Paper if context.setups.has_folder() => &[SPONZA, OLD_SPONZA, SIBENIK],
        _ => &[SPONZA],
    };
    let voxels = if context.preset == Preset::Smoke { &FIG_7[..1] } else { FIG_7 };
    let title = "Light shafts by the size of voxels";
    let found = experiment(context, "grid-fig7", title, "Stojanovic et al. 2023, Figure 7");
    run(context, found, places, voxels)
}

fn run(context: &Context, mut found: Experiment, places: &[Place], voxels: &[f32]) -> Outcome<Section> {
    let scale = Scale::one(context);
    found.adapter = adapter(context);
    let mut section = Section::default();
    for place in places {
        let stand = place.stand(context, scale, 1, 1)?;
        let all = measure(context, &stand, scale, voxels)?;
        found.rows.extend(all.iter().map(|one| one.row(&stand)));
        found.checks.extend(checks(&stand, &all));
        section.plots.extend(plots(&stand, &all));
        section.pictures.push(pictures(&stand, &all)?);
    }
    found.notes = vec![scale.note(), frames_note()];
    found.notes.push("Froxels next to the viewer read the shadow frustum, whose cells are twice as wide as froxels: its error stays, however small the voxels are.".into());
    found.notes.extend(scene_notes(context));
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

/// The reference, then by voxel size the marked grid read at the nearest voxel, then the same read at eight.
fn measure(context: &Context, stand: &Stand, scale: Scale, voxels: &[f32]) -> Outcome<Vec<Found>> {
    let cast = scale.cast(stand.range);
    let bounds = stand.bvh.bounds();
    let volume = (bounds.max - bounds.min).as_dvec3();
    let fits = |voxel: f32| volume.x * volume.y * volume.z / f64::from(voxel).powi(3) < MOST_VOXELS;
    let sizes: Vec<f32> = voxels.iter().copied().filter(|&voxel| fits(voxel)).collect();
    let mut contenders = vec![cast.reference()];
    contenders.extend(sizes.iter().map(|&voxel| cast.marked(voxel)));
    contenders.extend(sizes.iter().map(|&voxel| {
        let grid = SharedGrid { reads: GridReads::Trilinear, ..SharedGrid::marked(voxel) };
        Contender::new(format!("marked grid, trilinear, {voxel} m"), cast.0.with_grid(grid))
    }));
    // what bounds the error once voxels are small: the frustum's cells, here as wide as froxels
    contenders.extend(sizes.last().map(|&voxel| {
        let near = Near::Frustum { side: 1, slices: FRUSTUM };
        cast.near(&format!("marked grid, frustum as fine as froxels, {voxel} m"), voxel, near)
    }));
    Bench::new(device(context), contenders)?.measure(stand, 1)
}

/// Whether its frustum has the paper's cells.
fn is_papers(found: &Found) -> bool {
    found.contender.froxels.near_volume().0 == 2
}

fn is_trilinear(found: &Found) -> bool {
    found.contender.froxels.grid().is_some_and(|grid| grid.reads == GridReads::Trilinear)
}

/// Voxel size and error of one way of reading, the coarsest first.
fn curve(all: &[Found], trilinear: bool, error: fn(&Found) -> Option<f64>) -> Vec<(f64, f64)> {
    let of = all.iter().filter(|found| is_trilinear(found) == trilinear && is_papers(found));
    of.filter_map(|found| Some((f64::from(found.contender.voxel_size()?), error(found)?))).collect()
}

/// An error by its name.
type Named = (&'static str, fn(&Found) -> Option<f64>);

const ERRORS: [Named; 2] = [("FLIP", flip), ("shadow error", shadow)];

fn flip(found: &Found) -> Option<f64> {
    Some(found.errors?.flip)
}

fn shadow(found: &Found) -> Option<f64> {
    found.errors?.shadow_err
}

fn checks(stand: &Stand, all: &[Found]) -> Vec<Check> {
    let mut checks = Vec::new();
    for ((name, error), bar) in ERRORS.into_iter().zip(CLOSE) {
        let curve = curve(all, false, error);
        let least = curve.iter().map(|(_, error)| *error).reduce(f64::min);
        let claim = format!("{}: least {name} of the marked grid against the reference", stand.title);
        let paper = "§4.1: smaller voxels come closer to the reference";
        let mut check = Check::new(claim, paper, least, Bound::AtMost, bar);
        let reached = curve.iter().find(|(_, error)| *error <= bar).map(|(voxel, _)| *voxel);
        let between = interpolate(curve.iter().copied(), bar);
        let finest = all.iter().rfind(|found| found.contender.voxel_size().is_some() && !is_papers(found));
        let finest = finest.and_then(error).map_or_else(String::new, |least| {
            format!("; {} with frustums as fine as froxels and the smallest voxels", report::figure(least))
        });
        let reached = match (reached, between) {
            (Some(voxel), Some(between)) => {
                format!("reached with voxels of {voxel:.3} m; on the curve, at {between:.3} m")
            }
            _ => "no size that was measured reaches it".into(),
        };
        check.note = Some(reached + &finest);
        checks.push(check);
        let rises = curve.windows(2).filter(|pair| pair[1].1 > pair[0].1).count();
        let claim = format!("{}: steps to smaller voxels at which the {name} grows", stand.title);
        checks.push(Check::new(claim, paper, Some(rises as f64), Bound::AtMost, 0.0));
    }
    checks
}

fn plots(stand: &Stand, all: &[Found]) -> Vec<Plot> {
    let plot = |(name, error): Named| Plot {
        file: format!("{}-{}.svg", slug(&stand.title), slug(name)),
        title: format!("{}: {name}", stand.title),
        caption: format!("Mean {name} of the marked grid against the reference, by the side of its voxels"),
        x: Axis::new("voxel size", "m"),
        y: Axis::new(name, ""),
        series: [(false, "nearest voxel"), (true, "eight voxels")]
            .map(|(trilinear, label)| Series {
                label: label.into(),
                points: curve(all, trilinear, error),
                joined: true,
            })
            .into(),
    };
    ERRORS.map(plot).into()
}

fn pictures(stand: &Stand, all: &[Found]) -> Outcome<PictureRow> {
    let Some(reference) = all.first() else { return Ok(PictureRow::default()) };
    let brightness = display_scale(&reference.image, 95);
    let mut panels = vec![Panel::new(
        format!("{}-froxels.png", slug(&stand.title)),
        "froxels",
        format!("Airlight of {} by the froxel reference", stand.title),
        &to_srgb8(&reference.image, brightness),
        PanelKind::Plain,
    )?];
    for found in all.iter().skip(1).filter(|found| !is_trilinear(found) && is_papers(found)) {
        let Some(errors) = &found.errors else { continue };
        let shown = Shown {
            scene: &stand.title,
            what: &format!("Airlight of {}", stand.title),
            name: &found.contender.name,
            image: &found.image,
            scale: brightness,
            ms: found.ms(),
            errors,
            reference: &reference.image,
        };
        panels.extend(shown.panels()?);
    }
    let caption = format!("{}, airlight only; errors against the froxel reference", stand.title);
    Ok(PictureRow { caption, panels })
}
