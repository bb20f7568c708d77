//! `hard-cases`: every technique on every scene on which techniques fail first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use gpu_backend::GpuContext;
use rayon::prelude::*;
use serde_json::json;

use super::hard_case_list::{Case, Weight, cases};
use super::hard_case_range::Ranged;
use super::hard_case_ways::{SAMPLES, Way, volume_map};
use super::measure::{Arena, Runner, Setting, WARM_FRAMES, base, in_turns};
use super::shown::clock_note;
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::airlight::Stage;
use crate::airlight_gpu::{GpuFrame, lacks};
use crate::failure::Outcome;
use crate::image_file::Image;
use crate::maps::{MapOptions, MapSurface, Maps};
use crate::median::median;
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Section};
use crate::technique::{self, Options, Technique};

/// How much greater the hybrid's error may be than that of a march of as many steps, before the case is named: this
/// many times, and so much of what shadows change.
const WORSE: (f64, f64) = (2.0, 0.01);

/// Relative RMSE, and share of what shadows change, by which a light volume of all cells may differ from the exact
/// picture of the same map.
const VOLUME_BARS: (f64, f64) = (1e-3, 2e-3);

/// Relative RMSE, and share of what shadows change: froxels claim to be below one of the two.
const FROXEL_BARS: (f64, f64) = (0.3, 0.5);

/// Relative RMSE that f32 makes of any picture.
const ROUNDING: f64 = 1e-5;

/// What became of one technique on one case.
enum Cell {
    Measured(Box<Measured>),
    Refused(String),
    Panicked(String),
}

struct Measured {
    ms: f64,
    /// Why the CPU had to do it, if it did beside a GPU.
    not_on_gpu: Option<String>,
    on_gpu: bool,
    on_map: Metrics,
    on_geometry: Metrics,
    negative: u64,
}

impl Cell {
    fn measured(&self) -> Option<&Measured> {
        if let Self::Measured(measured) = self { Some(measured) } else { None }
    }

    fn not_finite(&self) -> u64 {
        self.measured().map_or(0, |m| m.on_map.nan + m.on_geometry.nan)
    }

    fn text(&self, reads_map: bool) -> String {
        match self {
            Self::Refused(text) => format!("refused: {text}"),
            Self::Panicked(text) => format!("PANIC: {text}"),
            Self::Measured(m) if self.not_finite() > 0 => format!("NOT FINITE, {}", report::time(m.ms)),
            Self::Measured(m) => {
                let mut text = format!(
                    "{}, shadow {}",
                    report::error(m.on_geometry.rel_rmse),
                    report::error(m.on_geometry.shadow_err)
                );
                if reads_map {
                    text += &format!(", map {}", report::error(m.on_map.shadow_err));
                }
                let place = if m.on_gpu { "" } else { " CPU" };
                format!("{text}; {}{place}", report::time(m.ms))
            }
        }
    }
}

/// A case with all its cells.
struct Done {
    name: String,
    triangles: u64,
    cells: Vec<(Way, Cell)>,
    /// What the GPU says to a frame of it that it cannot hold.
    gpu_refusal: Option<String>,
    lights: usize,
}

impl Done {
    fn of(&self, column: Way) -> Option<&Measured> {
        self.cells.iter().find(|(c, _)| *c == column).and_then(|(_, cell)| cell.measured())
    }

    /// The cells of ways that take a map in this meaning; those that read none stand beside the steps.
    fn reading(&self, surface: MapSurface) -> impl Iterator<Item = &(Way, Cell)> {
        self.cells.iter().filter(move |(way, _)| way.surface() == surface)
    }

    /// The hybrid's error and the march's in words, where the former is much the greater.
    fn worse(&self, hybrid: Way, march: Way) -> Option<String> {
        let error = |column: Way| {
            let m = self.of(column)?;
            if column.reads_map() { m.on_map.shadow_err } else { m.on_geometry.shadow_err }
        };
        let geometry = |way: Way| report::error(self.of(way).and_then(|m| m.on_geometry.shadow_err));
        let (ours, theirs) = (error(hybrid)?, error(march)?);
        let mut text = format!("{}: {} against {}", self.name, report::error(ours), report::error(theirs));
        if hybrid.reads_map() {
            text += &format!(" on the map, {} against {} on the geometry", geometry(hybrid), geometry(march));
        }
        (ours.is_finite() && ours > WORSE.0 * theirs + WORSE.1).then_some(text)
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    // odd, so that one pixel looks exactly where the camera does
    let (side, map, most) = match context.preset {
        Preset::Smoke => (17, 128, Weight::Always),
        Preset::Quick => (33, 256, Weight::Usual),
        Preset::Standard => (65, 1024, Weight::Large),
        Preset::Paper => (129, 1024, Weight::Large),
    };
    let mut found = experiment(
        context,
        "hard-cases",
        "Scenes on which techniques fail first",
        "what the papers leave out",
    );
    found.adapter = gpu_or_cpu(context);
    let mut all = Vec::new();
    for case in cases().iter().filter(|case| case.weight <= most) {
        tracing::info!("{}", case.name);
        all.push(measure(context, case, side, map)?);
    }
    let mut section = Section::default();
    let tables = [("Every case", MapSurface::Step), ("Every case, light volumes", MapSurface::Linear)];
    section.tables.extend(tables.map(|(title, surface)| table(&all, title, surface)));
    found.rows = all.iter().flat_map(rows).collect();
    found.checks = checks(context, &all);
    found.notes = notes(context, side, map);
    section.experiment = found;
    Ok(section)
}

/// What a call returns, or the text of its panic.
fn caught<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "without a word".into())
    })
}

fn measure(context: &Context, case: &Case, side: u32, map: u32) -> Outcome<Done> {
    let arena = Arena::new(&context.references, &*case.name, (case.build)()?, base(side, map))?;
    let (maps, on_linear) = linear(&arena)?;
    let ranged = Ranged::new(&arena)?;
    let ways = Way::of_context(context);
    let base = |way: Way| if way.has_froxels() { ranged.options(arena.base) } else { arena.base };
    let settings: Vec<Setting> = ways.iter().map(|way| way.setting(base(*way), &maps)).collect();
    let mut stages: Vec<Stage<'_>> = Vec::new();
    for (way, setting) in ways.iter().zip(&settings) {
        let stage = arena.stage(setting)?;
        stages.push(if way.has_froxels() { ranged.stage(stage) } else { stage });
    }
    let cells = run_cells(context, &arena, &on_linear, &ranged, &ways, &stages)?;
    let gpu_refusal = match &context.gpu {
        Some(gpu) if lacks(&arena.setup, Technique::BruteForce).is_some() => {
            stages.first().and_then(|stage| {
                caught(|| GpuFrame::new(gpu, stage, Technique::BruteForce).err().map(|f| f.to_string()))
                    .unwrap_or_else(|text| Some(format!("PANIC: {text}")))
            })
        }
        _ => None,
    };
    Ok(Done {
        name: case.name.clone(),
        triangles: arena.triangles(),
        cells,
        gpu_refusal,
        lights: arena.setup.lights.len(),
    })
}

/// The maps in the meaning that light volumes enclose, and what is exact with respect to them.
fn linear(arena: &Arena) -> Outcome<(Arc<Maps>, Image)> {
    let options = Options { map: MapOptions { surface: MapSurface::Linear, ..arena.base.map }, ..arena.base };
    let maps = Arc::new(Maps::draw(&arena.setup, &options.map)?);
    let own_maps = Some(Arc::clone(&maps));
    let setting = Setting { own_maps, ..Setting::new("", Technique::ExactShadowMap, options) };
    let exact = arena.references.picture(&arena.stage(&setting)?, setting.technique)?.image;
    Ok((maps, exact))
}

/// The GPU for a way, if there is one and it takes the case; else why it does not.
fn gpu_for<'a>(context: &'a Context, arena: &Arena, way: Way) -> (Option<&'a GpuContext>, Option<String>) {
    let Some(gpu) = context.gpu.as_ref().filter(|_| !way.on_cpu()) else { return (None, None) };
    match lacks(&arena.setup, way.technique()) {
        Some(why) => (None, Some(why)),
        None => (Some(gpu), None),
    }
}

/// A ready technique with its first picture.
type Ready<'a> = (Runner<'a>, Vec<[f32; 3]>);

/// One technique: why it is not on the GPU, and what came of making it ready, or the text of its panic.
type Prepared<'a> = (Way, Option<String>, Result<Outcome<Ready<'a>>, String>);

fn run_cells<'a>(
    context: &'a Context,
    arena: &'a Arena,
    on_linear: &Image,
    ranged: &Ranged,
    ways: &[Way],
    stages: &'a [Stage<'a>],
) -> Outcome<Vec<(Way, Cell)>> {
    // compiling takes most of the time, so all are prepared side by side, and timed in turns afterwards
    let prepare = |(way, stage): (&Way, &'a Stage<'a>)| -> Prepared<'a> {
        let technique = way.technique();
        let (gpu, not_on_gpu) = gpu_for(context, arena, *way);
        let start = caught(|| -> Outcome<Ready<'a>> {
            technique::check(&arena.setup, technique, "--technique")?;
            let mut runner = Runner::new(gpu, stage, technique)?;
            let first = runner.first()?;
            Ok((runner, first.pixels))
        });
        (*way, not_on_gpu, start)
    };
    let mut ready: Vec<Prepared<'a>> = ways.par_iter().zip(stages).map(prepare).collect();
    let times = in_turns(&mut ready, |(_, _, start)| match start {
        Ok(Ok((runner, _))) => Ok(runner.frame(true)?.0),
        _ => Ok(f64::NAN),
    })?;
    let (width, height) = arena.base.size;
    let mut cells = Vec::new();
    for ((way, not_on_gpu, start), times) in ready.into_iter().zip(times) {
        let cell = match start {
            Err(text) => Cell::Panicked(text),
            Ok(Err(failure)) => Cell::Refused(failure.to_string()),
            Ok(Ok((runner, pixels))) => {
                let image = Image { width, height, pixels };
                let (exact, open) = if way.has_froxels() {
                    (&ranged.exact, &ranged.open)
                } else {
                    (&arena.exact, &arena.unshadowed)
                };
                let compare = |reference| metrics::compare(&image, reference, Some(open), None);
                Cell::Measured(Box::new(Measured {
                    ms: median(&times).unwrap_or(f64::NAN),
                    on_gpu: runner.on_gpu(),
                    not_on_gpu,
                    on_map: compare(if way.surface() == MapSurface::Linear {
                        on_linear
                    } else {
                        &arena.map.exact
                    })?,
                    on_geometry: compare(exact)?,
                    negative: image.pixels.iter().flatten().filter(|value| **value < 0.0).count() as u64,
                }))
            }
        };
        cells.push((way, cell));
    }
    Ok(cells)
}

fn rows(done: &Done) -> impl Iterator<Item = Row> + '_ {
    done.cells.iter().map(|(column, cell)| {
        let mut row = Row::new(&done.name, column.name());
        row.triangles = Some(done.triangles);
        row.params.insert("lights".into(), json!(done.lights));
        match cell {
            Cell::Measured(m) => {
                row.ms_scatter = Some(m.ms);
                row.ms_frame = Some(m.ms);
                row.frames = Some(WARM_FRAMES as u32);
                row.set_errors(&m.on_geometry);
                if column.reads_map() {
                    row.shadow_err_map = m.on_map.shadow_err;
                    row.map_surface = Some(column.surface().name().into());
                }
                row.params.insert("backend".into(), json!(if m.on_gpu { "gpu" } else { "cpu" }));
                row.params.insert("not finite".into(), json!(cell.not_finite()));
                if let Some(why) = &m.not_on_gpu {
                    row.params.insert("not on the gpu".into(), json!(why));
                }
            }
            Cell::Refused(text) => _ = row.params.insert("refused".into(), json!(text)),
            Cell::Panicked(text) => _ = row.params.insert("panic".into(), json!(text)),
        }
        row
    })
}

fn table(all: &[Done], title: &str, surface: MapSurface) -> Table {
    let mut columns = vec![Column::left("case")];
    columns.extend(
        all.first()
            .into_iter()
            .flat_map(|done| done.reading(surface))
            .map(|(way, _)| Column::left(way.name())),
    );
    columns.push(Column::left("the GPU says"));
    let mut table = Table::new(title, columns);
    for done in all {
        let mut line = vec![done.name.clone()];
        line.extend(done.reading(surface).map(|(way, cell)| cell.text(way.reads_map())));
        line.push(done.gpu_refusal.clone().unwrap_or_default());
        table.push(line);
    }
    table.note = Some(format!(
        "In a cell: relative RMSE and shadow error against the exact picture of the geometry; map error against the exact picture of the same map; time. Both marches take {SAMPLES} steps. A shadow error of ∞ stands where shadows change nothing and so nothing can be a share of it. What a map cannot resolve, every technique that reads it misses alike: the columns with shadow rays read none."
    ));
    table.without_empty_columns()
}

fn checks(context: &Context, all: &[Done]) -> Vec<Check> {
    let cells = || all.iter().flat_map(|done| done.cells.iter().map(move |(c, cell)| (done, c, cell)));
    let named = |bad: &dyn Fn(&Cell) -> bool| -> (f64, Option<String>) {
        let names: Vec<String> = cells()
            .filter(|(_, _, cell)| bad(cell))
            .map(|(done, column, _)| format!("{} by {}", done.name, column.name()))
            .collect();
        (names.len() as f64, (!names.is_empty()).then(|| names.join("; ")))
    };
    let none = |claim: &str, bad: &dyn Fn(&Cell) -> bool| {
        let (count, note) = named(bad);
        let mut check =
            Check::new(claim, "every input that makes sense has a picture", Some(count), Bound::AtMost, 0.0);
        check.note = note;
        check
    };
    let mut checks = vec![
        none("cells with values that are not finite", &|cell| cell.not_finite() > 0),
        none("cells that panic", &|cell| matches!(cell, Cell::Panicked(_))),
        none("cells with negative radiance", &|cell| cell.measured().is_some_and(|m| m.negative > 0)),
        none("cells that are refused", &|cell| matches!(cell, Cell::Refused(_))),
    ];
    for (hybrid, march) in
        [(Way::Hybrid, Way::March), (Way::PlainHybrid, Way::March), (Way::HybridByRays, Way::MarchByRays)]
    {
        if all.iter().all(|done| done.of(hybrid).is_none() || done.of(march).is_none()) {
            continue;
        }
        let worse: Vec<String> = all.iter().filter_map(|done| done.worse(hybrid, march)).collect();
        let claim = format!(
            "cases in which the error of {} is more than {} times that of {} at as many samples, and {} more",
            hybrid.name(),
            WORSE.0,
            march.name(),
            report::error(WORSE.1)
        );
        let count = Some(worse.len() as f64);
        let mut check =
            Check::new(claim, "§4: higher quality for equivalent sampling", count, Bound::AtMost, 0.0);
        check.note = (!worse.is_empty()).then(|| worse.join("; "));
        checks.push(check);
    }
    checks.extend(
        [Way::StaticVolume, Way::StaticVolumeOnCpu].into_iter().filter_map(|way| exactness(all, way)),
    );
    checks.extend(Way::ALL.into_iter().filter(|way| way.has_froxels()).filter_map(|way| closeness(all, way)));
    let refusal = all.iter().find(|done| done.lights == 9).and_then(|done| done.gpu_refusal.clone());
    let typed = refusal.as_ref().map(|text| f64::from(u8::from(!text.starts_with("PANIC"))));
    let mut check = Check::new(
        "nine lights on the GPU are refused in words",
        "a clear error where the input makes no sense",
        context.gpu.as_ref().and(typed),
        Bound::AtLeast,
        1.0,
    );
    check.note = refusal;
    checks.push(check);
    checks
}

/// Whether a light volume of all cells is what its map says; `None` where none was measured.
fn exactness(all: &[Done], way: Way) -> Option<Check> {
    let mut measured = all.iter().filter_map(|done| Some((done, done.of(way)?))).peekable();
    measured.peek()?;
    let wrong: Vec<String> = measured
        .filter_map(|(done, m)| {
            let (rmse, shadow) = (m.on_map.rel_rmse, m.on_map.shadow_err);
            // where all is dark nothing is a share of the picture, and where all but nothing is lit, of the shadows
            let off = (rmse.is_finite() && rmse > VOLUME_BARS.0)
                || (rmse > ROUNDING && shadow.is_some_and(|shadow| shadow > VOLUME_BARS.1));
            let text = || format!("{}: {}, shadow {}", done.name, report::error(rmse), report::error(shadow));
            off.then(text)
        })
        .collect();
    let (rmse, shadow) = (report::error(VOLUME_BARS.0), report::error(VOLUME_BARS.1));
    let claim = format!(
        "cases in which {} is farther from the exact picture of the same map than {rmse}, or {shadow} of what shadows change",
        way.name()
    );
    let count = Some(wrong.len() as f64);
    let mut check =
        Check::new(claim, "§6: always exact with respect to the shadow map", count, Bound::AtMost, 0.0);
    check.note = (!wrong.is_empty()).then(|| wrong.join("; "));
    Some(check)
}

/// Whether froxels are in the class of errors that they claim; `None` where none was measured.
fn closeness(all: &[Done], way: Way) -> Option<Check> {
    let mut measured = all.iter().filter_map(|done| Some((done, done.of(way)?))).peekable();
    measured.peek()?;
    let far: Vec<String> = measured
        .filter_map(|(done, m)| {
            let Metrics { rel_rmse, shadow_err, .. } = m.on_geometry;
            let off = rel_rmse > FROXEL_BARS.0 && shadow_err.is_none_or(|shadow| shadow > FROXEL_BARS.1);
            let text = || {
                format!("{}: {}, shadow {}", done.name, report::error(rel_rmse), report::error(shadow_err))
            };
            off.then(text)
        })
        .collect();
    let claim = format!(
        "cases in which {} are off by more than {} and by more than {} of what shadows change, up to their range",
        way.name(),
        report::error(FROXEL_BARS.0),
        report::error(FROXEL_BARS.1)
    );
    let count = Some(far.len() as f64);
    let mut check = Check::new(claim, "a class of errors: froxels sample", count, Bound::AtMost, 0.0);
    check.note = (!far.is_empty()).then(|| far.join("; "));
    Some(check)
}

fn notes(context: &Context, side: u32, map: u32) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {side}×{side}, an odd side, so that the middle pixel looks exactly where the camera does; maps are {map}², those of light volumes {}².", volume_map(map)),
        "On the GPU wherever it takes a case, else on the CPU, which the cell says. Silhouettes and pyramids are made anew in every frame.".into(),
        "Froxels are of one pixel and 128 slices. They end at the farthest corner of the scene, and so do the exact pictures that they are compared with; the shared grid has 200 voxels along the longest side.".into(),
    ];
    if Way::leaves_out_static(context) {
        notes.push(
            "Light volumes of all texels are left to the longer presets, or to a GPU of hardware.".into(),
        );
    }
    notes.extend(clock_note(context));
    notes
}
