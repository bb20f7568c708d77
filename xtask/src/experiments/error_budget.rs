//! `error-budget`: what the error of each technique is made of, one source after the other made exact.

use hybrid_march::Sampling;
use scene::Bvh;

use super::measure::{Arena, Measured, Setting, base};
use super::shown::{clock_note, display_scale, panels, slug};
use super::wyman_bench::{source, thin};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::{Failure, Outcome};
use crate::froxels;
use crate::image_file::to_srgb8;
use crate::maps::{MapOptions, MapSurface};
use crate::metrics;
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Bar, Bars, Panel, PanelKind, PictureRow, Quantity, Section};
use crate::setups::LightKind;
use crate::technique::{Options, Technique, Tessellation, VisibilitySource};

/// Steps of the marches, as many as the hybrid of Wyman and Ramsey 2008 has.
const SAMPLES: u32 = 50;

/// Pixels along the side of the blocks for which marches compute airlight.
const SCALE: u32 = 4;

/// How many times more steps a march takes in place of an exact integral.
const MORE_SAMPLES: u32 = 16;

/// How many times more texels a side stand for an exact map.
const FINER: u32 = 4;

/// Bisections of a boundary in place of an exact one.
const MORE_BISECTIONS: u32 = 16;

/// Most slices of froxels.
const MORE_SLICES: u32 = froxel_grid::MAX_SLICES;

/// Largest part of what shadows change that rounding may have.
const ROUNDING: f64 = 2e-3;

/// What an error comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// Texels, voxels.
    Visibility,
    /// Triangles of a light volume that are left out.
    Tessellation,
    /// Steps along the ray.
    Integration,
    /// Blocks of pixels.
    Upsampling,
    /// `f32` on the GPU.
    Precision,
}

impl Source {
    fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::Tessellation => "tessellation",
            Self::Integration => "integration",
            Self::Upsampling => "upsampling",
            Self::Precision => "float precision",
        }
    }
}

/// A technique as it is, or with one source of its error made exact.
struct Part {
    technique: Technique,
    /// What is exact, and what stands in its place; nothing for the technique as it is.
    exact: Option<(Source, String)>,
    setting: Setting,
    on_cpu: bool,
}

/// A part with what was measured.
struct Found {
    part: Part,
    measured: Measured,
    /// What the source amounts to: the difference from the technique as it is, as a share of what shadows change.
    amount: Option<f64>,
}

impl Found {
    fn error(&self) -> f64 {
        self.measured.on_geometry.shadow_err.unwrap_or(f64::NAN)
    }

    fn of(&self, technique: Technique, source: Option<Source>) -> bool {
        self.part.technique == technique && self.part.exact.as_ref().map(|(source, _)| *source) == source
    }
}

/// How large things are.
struct Plan {
    side: u32,
    map: u32,
    /// Pixels along the side of a froxel, and of one that stands for a value at each pixel.
    tiles: [u32; 2],
    setups: &'static [(&'static str, LightKind)],
}

impl Plan {
    fn new(context: &Context) -> Self {
        const POINT: (&str, LightKind) = ("sphere", LightKind::Point);
        const HALL: (&str, LightKind) = ("sponza", LightKind::Spot);
        const ALL: &[(&str, LightKind)] = &[POINT, HALL, ("sponza", LightKind::Point)];
        match context.preset {
            Preset::Smoke => Self { side: 32, map: 32, tiles: [4, 2], setups: &[POINT] },
            _ if context.gpu.is_none() => Self { side: 64, map: 64, tiles: [4, 2], setups: &[POINT] },
            Preset::Quick => Self { side: 128, map: 128, tiles: [4, 2], setups: &[POINT, HALL] },
            Preset::Standard => Self { side: 512, map: 256, tiles: [8, 4], setups: ALL },
            Preset::Paper => Self { side: 1024, map: 512, tiles: [8, 2], setups: ALL },
        }
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = Plan::new(context);
    let mut found =
        experiment(context, "error-budget", "What errors are made of", "all three papers: where they err");
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut all = Vec::new();
    for (id, kind) in plan.setups {
        let source = source(context, id)?;
        let Some(setup) = source.setup_lit(thin(context), *kind)? else { continue };
        let title = format!("{}, {} light", source.title(), kind.name());
        tracing::info!("{title}");
        let range = froxels::range(&setup, &Bvh::build(&setup.scene).map_err(Failure::program)?);
        let mut options = Options { max_distance: range.into(), ..base(plan.side, plan.map) };
        (options.froxels.range, options.froxels.tile) = (Some(range), plan.tiles[0]);
        let mut arena = Arena::new(&context.references, title, setup, options)?;
        let parts = measure(context, &mut arena, parts(&plan, &options, context.gpu.is_some()))?;
        found.rows.extend(parts.iter().map(|part| row(&arena, part)));
        section.tables.push(table(&arena.title, &parts));
        section.bars.push(bars(&arena.title, &parts));
        if all.is_empty() {
            section.pictures.push(pictures(&arena, &parts)?);
        }
        all.push((arena.title.clone(), parts));
    }
    found.checks = checks(&all);
    found.notes = vec![
        format!("Pictures are {0}×{0}, airlight only, in the thin medium, up to the range of the froxels. Marches have {SAMPLES} steps for blocks of {SCALE}×{SCALE} pixels and look up a map of {1}² texels (of each face under a point light); froxels are {2} pixels wide and 128 slices deep.", plan.side, plan.map, plan.tiles[0]),
        format!("Each source is made exact by itself, the others stay: shadow rays in place of a march's map and of voxels; a map {FINER} times as fine a side where the technique is made of its map; all cells in place of a quadtree; {MORE_SAMPLES} times the steps (and {MORE_BISECTIONS} bisections of the hybrid's boundaries), {MORE_SLICES} slices; a value for each pixel, or froxels of {} px; the CPU's f64 in place of the GPU's f32 (marches have f64 distances there and f32 closed forms). A source that cannot be made exact alone is missing: the exact traversal and light volumes integrate in closed form, and froxels are f32 on both devices.", plan.tiles[1]),
        "An amount is how far making the source exact moves the picture, as a share of what shadows change. Amounts are lengths of differences and need not add up; where two sources cancel, the error can grow as one of them goes.".into(),
    ];
    found.notes.extend(clock_note(context));
    section.experiment = found;
    Ok(section)
}

/// All techniques as they are, each followed by its sources made exact.
fn parts(plan: &Plan, base: &Options, on_gpu: bool) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut add =
        |technique: Technique, exact: Option<(Source, String)>, runs: Technique, options: Options| {
            let on_cpu = exact.as_ref().is_some_and(|(source, _)| *source == Source::Precision);
            if on_cpu && !on_gpu {
                return;
            }
            let what = exact.as_ref().map(|(source, to)| format!(", {}: {to}", source.name()));
            let name = format!("{}{}", technique.name(), what.unwrap_or_default());
            let setting = Setting::new(name, runs, options);
            parts.push(Part { technique, exact, setting, on_cpu });
        };
    let f64s = |text: &str| Some((Source::Precision, text.to_owned()));
    let finer = Some((Source::Visibility, format!("map {}²", FINER * plan.map)));

    let march = Options { samples: Some(SAMPLES), sampling: Sampling::blocks(SCALE), ..*base };
    for technique in [Technique::BruteForce, Technique::Hybrid] {
        let steps = MORE_SAMPLES * SAMPLES;
        let mut converged = Options { samples: Some(steps), ..march };
        converged.hybrid.refine = MORE_BISECTIONS;
        add(technique, None, technique, march);
        let rays = Options { visibility: VisibilitySource::Bvh, ..march };
        add(technique, Some((Source::Visibility, "shadow rays".into())), technique, rays);
        add(technique, Some((Source::Integration, format!("{steps} steps"))), technique, converged);
        let every = Options { sampling: Sampling::Pixels, ..march };
        add(technique, Some((Source::Upsampling, "every pixel".into())), technique, every);
        add(technique, f64s("f64 distances, on the CPU"), technique, march);
    }

    let fine =
        |options: Options| Options { map: MapOptions { side: FINER * plan.map, ..options.map }, ..options };
    let technique = Technique::ExactShadowMap;
    add(technique, None, technique, *base);
    add(technique, finer.clone(), technique, fine(*base));
    add(technique, f64s("f64, on the CPU"), technique, *base);

    let technique = Technique::LightVolume;
    let linear = Options { map: MapOptions { surface: MapSurface::Linear, ..base.map }, ..*base };
    let all_cells = Options { tessellation: Tessellation::Static { indexed: true }, ..linear };
    add(technique, None, technique, linear);
    add(technique, finer, technique, fine(linear));
    add(technique, Some((Source::Tessellation, "all cells".into())), technique, all_cells);
    add(technique, f64s("f64, on the CPU"), technique, linear);

    let (mut deep, mut narrow) = (*base, *base);
    deep.froxels.slices = MORE_SLICES;
    narrow.froxels.tile = plan.tiles[1];
    for technique in [Technique::Froxel, Technique::SharedGrid] {
        add(technique, None, technique, *base);
        if technique == Technique::SharedGrid {
            add(
                technique,
                Some((Source::Visibility, "a shadow ray a froxel".into())),
                Technique::Froxel,
                *base,
            );
        }
        add(technique, Some((Source::Integration, format!("{MORE_SLICES} slices"))), technique, deep);
        let to = format!("froxels of {} px", plan.tiles[1]);
        add(technique, Some((Source::Upsampling, to)), technique, narrow);
    }
    parts
}

/// Measures all parts, those of each device in turns.
fn measure(context: &Context, arena: &mut Arena, parts: Vec<Part>) -> Outcome<Vec<Found>> {
    let mut measured: Vec<Option<Measured>> = parts.iter().map(|_| None).collect();
    for on_cpu in [false, true] {
        let which: Vec<usize> = (0..parts.len()).filter(|i| parts[*i].on_cpu == on_cpu).collect();
        let settings: Vec<Setting> = which.iter().map(|i| parts[*i].setting.clone()).collect();
        let gpu = context.gpu.as_ref().filter(|_| !on_cpu);
        for (index, shot) in which.into_iter().zip(arena.measure(gpu, &settings)?) {
            measured[index] = Some(shot);
        }
    }
    let mut found: Vec<Found> = Vec::new();
    for (part, measured) in parts.into_iter().zip(measured.into_iter().flatten()) {
        let as_it_is = found.iter().find(|full| full.of(part.technique, None));
        let amount = match as_it_is {
            Some(full) if part.exact.is_some() => {
                let open = Some(&arena.unshadowed);
                metrics::compare(&full.measured.image, &measured.image, open, None)?.shadow_err
            }
            _ => None,
        };
        found.push(Found { part, measured, amount });
    }
    Ok(found)
}

fn row(arena: &Arena, found: &Found) -> Row {
    let mut row = found.measured.row(&arena.title, arena.triangles());
    row.technique = found.part.technique.name();
    if let Some((source, to)) = &found.part.exact {
        row.params.insert("exact".into(), format!("{} ({to})", source.name()).into());
    }
    if found.part.on_cpu {
        row.params.insert("backend".into(), "cpu".into());
    }
    if let Some(amount) = found.amount {
        row.params.insert("amount".into(), amount.into());
    }
    row
}

fn table(title: &str, all: &[Found]) -> Table {
    let mut table = Table::new(
        format!("{title}: sources of error, each made exact by itself"),
        vec![
            Column::left("technique"),
            Column::left("made exact"),
            Column::left("by"),
            Column::right("time"),
            Column::right("shadow error left"),
            Column::right("of the whole error"),
            Column::right("amount of the source"),
            Column::right("map error"),
        ],
    );
    for found in all {
        let Found { part, measured, amount } = found;
        let (source, to) = part.exact.as_ref().map_or(("nothing", ""), |(source, to)| (source.name(), to));
        let whole = all.iter().find(|full| full.of(part.technique, None)).map(Found::error);
        let share = part.exact.as_ref().and(whole).map(|whole| found.error() / whole);
        table.push(vec![
            part.technique.name(),
            source.to_owned(),
            to.to_owned(),
            report::time(measured.ms()),
            report::error(found.error()),
            report::error(share),
            report::error(*amount),
            report::error(measured.on_map.and_then(|on_map| on_map.shadow_err)),
        ]);
    }
    table
}

fn bars(title: &str, all: &[Found]) -> Bars {
    let mut bars = Vec::new();
    for found in all {
        let time = report::time(found.measured.ms());
        match (&found.part.exact, found.amount) {
            (None, _) => {
                bars.push(Bar { label: found.part.technique.name(), parts: Vec::new() });
                bars.push(Bar::plain(format!("whole error, {time}"), found.error()));
            }
            (Some((source, _)), Some(amount)) => {
                bars.push(Bar::plain(format!("{}, {time}", source.name()), amount));
            }
            (Some(_), None) => {}
        }
    }
    Bars {
        file: format!("{}-budget.svg", slug(title)),
        title: format!("{title}: what errors are made of"),
        caption: "For each technique its whole error, and how far making one source exact moves the picture; both as shares of what shadows change. Times are those of the pictures, with the source made exact.".into(),
        quantity: Quantity::Error,
        bars,
    }
}

fn checks(all: &[(String, Vec<Found>)]) -> Vec<Check> {
    let mut checks = Vec::new();
    for technique in [Technique::ExactShadowMap, Technique::LightVolume] {
        let of = |source: Option<Source>| {
            all.iter().filter_map(move |(_, parts)| parts.iter().find(|found| found.of(technique, source)))
        };
        let name = technique.name();
        let rounding = of(Some(Source::Precision)).filter_map(|found| found.amount).reduce(f64::max);
        let mut check = Check::new(
            format!("{name}: largest amount of rounding, f32 against f64"),
            "none: f32 is enough where pieces are integrated one by one",
            rounding,
            Bound::AtMost,
            ROUNDING,
        );
        check.note = rounding.is_none().then(|| "There is no GPU, and the CPU computes in f64.".into());
        checks.push(check);
        let left =
            of(None).zip(of(Some(Source::Visibility))).map(|(whole, fine)| fine.error() / whole.error());
        checks.push(Check::new(
            format!("{name}: most that is left of the error with a map {FINER} times as fine"),
            "Billeter et al. 2010, §6: exact with respect to the shadow map",
            left.reduce(f64::max),
            Bound::AtMost,
            0.5,
        ));
    }
    checks
}

fn pictures(arena: &Arena, all: &[Found]) -> Outcome<PictureRow> {
    let (title, scale) = (&arena.title, display_scale(&arena.exact, 95));
    let exact = Panel::new(
        format!("{}-exact.png", slug(title)),
        "exact",
        format!("Airlight of {title}: the exact picture"),
        &to_srgb8(&arena.exact, scale),
        PanelKind::Plain,
    )?;
    let mut all_panels = vec![exact];
    for found in all.iter().filter(|found| found.part.exact.is_none()) {
        let errors = (&arena.exact, &found.measured.on_geometry);
        all_panels.extend(panels(title, &found.measured, errors, scale)?);
    }
    let caption = format!("{title}, airlight only: every technique as it is; errors against the geometry");
    Ok(PictureRow { caption, panels: all_panels })
}
