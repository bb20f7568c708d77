//! `wyman-table1`: Wyman and Ramsey's Table 1 and what their hybrid costs at equal error.
//!
//! For every scene and light the table's settings and a sweep of sample counts take turns. All of them read the same
//! shadow map, and all times have everything in them that a frame with a moving light needs.

use hybrid_march::Sampling;
use std::sync::Arc;

use gpu_backend::AirlightForm;
use hybrid_march::Placement;
use scene::{AirlightModel, Light};

use super::equal_error::interpolate;
use super::measure::{Arena, Measured, Rebuild, Setting, base};
use super::shown::clock_note;
use super::wyman_exact_times::exact_times;
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::metrics;
use crate::report::Section;
use crate::report::data::Row;
use crate::scene_args::Setup;
use crate::setups::{LightKind, Source, Wyman};
use crate::stained_glass::stained_glass;
use crate::technique::{HybridOptions, Options, Technique};
use depth_edges::rms_at_edges;
use lookups::Lookups;

mod checks;
mod depth_edges;
mod lookups;
mod pictures;
mod tables;

/// Errors at which techniques are compared.
const TARGETS: [f64; 2] = [0.01, 0.002];

/// Steps of the table's columns.
const BRUTE: u32 = 150;
const HYBRID: u32 = 50;

/// Blocks of the columns at 256² in pictures of 1024².
const LOW: u32 = 4;

struct Plan {
    side: u32,
    map: u32,
    brute: &'static [u32],
    hybrid: &'static [u32],
    scenes: usize,
    spots: bool,
}

fn plan(context: &Context) -> Plan {
    let preset = context.preset;
    let all = Plan {
        side: 512,
        map: 1024,
        brute: &[10, 40, BRUTE, 1000],
        hybrid: &[4, 16, HYBRID, 200],
        scenes: usize::MAX,
        spots: false,
    };
    let few = Plan { side: 256, scenes: 2, ..all };
    let plan = match preset {
        Preset::Smoke => {
            Plan { side: 64, map: 256, brute: &[20, BRUTE, 600], hybrid: &[8, HYBRID, 200], scenes: 1, ..few }
        }
        Preset::Quick => few,
        Preset::Standard => all,
        Preset::Paper => Plan {
            side: 1024,
            spots: true,
            brute: &[10, 20, 40, 80, BRUTE, 300, 600, 1200, 2400],
            hybrid: &[4, 8, 16, 32, HYBRID, 100, 200, 400],
            ..all
        },
    };
    // marches of the CPU take some hundred times as long
    if context.gpu.is_some() {
        Plan { side: context.marched_side(plan.side), ..plan }
    } else {
        Plan { side: plan.side.min(96), brute: &[10, 40, BRUTE, 600], hybrid: &[4, 16, HYBRID, 200], ..plan }
    }
}

/// How the hybrid finds its bounds and boundaries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// As in the paper: faces of each pixel, and a plain march between them.
    Paper,
    /// Faces of tiles, and a plain march.
    Tiles,
    /// Faces of tiles, and boundaries that are bisected.
    Bisected,
}

impl Way {
    fn name(self) -> &'static str {
        match self {
            Self::Paper => "the paper's way",
            Self::Tiles => "tiles",
            Self::Bisected => "tiles and bisection",
        }
    }

    fn options(self) -> HybridOptions {
        let usual = HybridOptions::default();
        match self {
            Self::Paper => {
                HybridOptions { tile: 1, refine: 0, placement: Some(Placement::EqualDistance), ..usual }
            }
            Self::Tiles => HybridOptions { refine: 0, ..usual },
            Self::Bisected => usual,
        }
    }
}

fn at(scale: u32) -> &'static str {
    if scale == 1 { "" } else { ", ¼ resolution" }
}

fn brute_name(samples: u32, scale: u32) -> String {
    format!("brute force, {samples} samples{}", at(scale))
}

fn hybrid_name(samples: u32, way: Way, scale: u32) -> String {
    format!("hybrid, {samples} samples, {}{}", way.name(), at(scale))
}

fn anew_name() -> String {
    format!("{}, edges anew", hybrid_name(HYBRID, Way::Bisected, LOW))
}

const NO_SHADOWS: &str = "no shadows";

/// Ways to compute a lit piece's airlight that are measured beside the interval form.
const FORMS: [(&str, AirlightForm); 2] = [
    ("a frame's table of F′ as printed, 256²", AirlightForm::FrameTable { size: 256 }),
    ("a frame's table over angles, 256²", AirlightForm::AngleTable { size: 256 }),
];

/// A scene under one light, measured.
struct Case {
    /// The scene alone.
    scene: String,
    light: &'static str,
    triangles: u64,
    wyman: Option<Wyman>,
    results: Vec<Measured>,
    /// Lookups per covered pixel of each result, in their order; the number of pixels covered.
    lookups: Vec<Option<f64>>,
    covered: u64,
    pixels: u64,
    exact_on_map: crate::image_file::Image,
    /// FLIP between the full and the low resolution of the hybrid, and the error near depth edges and elsewhere.
    low: Option<Low>,
}

/// What the low resolution changes.
struct Low {
    flip: f64,
    near_edges: f64,
    elsewhere: f64,
    /// Error near edges over the error elsewhere where pixels at edges are computed anew.
    anew: Option<f64>,
}

impl Case {
    fn title(&self) -> String {
        format!("{}, {}", self.scene, self.light)
    }

    fn textured(&self) -> bool {
        self.light == TEXTURED
    }

    fn find(&self, name: &str) -> Option<&Measured> {
        self.results.iter().find(|result| result.setting.name == name)
    }

    fn brute(&self, samples: u32, scale: u32) -> Option<&Measured> {
        self.find(&brute_name(samples, scale))
    }

    fn hybrid(&self, way: Way, scale: u32) -> Option<&Measured> {
        self.find(&hybrid_name(HYBRID, way, scale))
    }

    /// Time of one setting over another's.
    fn ratio(above: Option<&Measured>, below: Option<&Measured>) -> Option<f64> {
        Some(above?.ms() / below?.ms())
    }

    /// Full-resolution settings of a technique with their lookups, in ascending order of samples; those of the hybrid
    /// by their way.
    fn curve(&self, way: Option<Way>) -> Vec<(&Measured, f64)> {
        let belongs = |setting: &Setting| {
            let Options { sampling, shadows_in_medium, hybrid, .. } = setting.options;
            let same = match way {
                None => setting.technique == Technique::BruteForce && shadows_in_medium,
                Some(way) => setting.technique == Technique::Hybrid && hybrid == way.options(),
            };
            same && sampling == Sampling::Pixels
        };
        let mut curve: Vec<_> = self
            .results
            .iter()
            .zip(&self.lookups)
            .filter(|(result, _)| belongs(&result.setting))
            .map(|(result, lookups)| (result, lookups.unwrap_or(f64::NAN)))
            .collect();
        curve.sort_by_key(|(result, _)| result.setting.options.samples);
        curve
    }

    /// Least error of a curve.
    fn best(&self, way: Option<Way>) -> f64 {
        self.curve(way).iter().map(|(result, _)| result.map_error()).fold(f64::INFINITY, f64::min)
    }

    /// The error at which techniques are compared: the target, or the best that the march and the bisecting hybrid reach.
    fn common(&self, target: f64) -> f64 {
        target.max(self.best(None)).max(self.best(Some(Way::Bisected)))
    }

    /// Time, lookups per covered pixel and samples that a technique needs for an error on the map.
    fn needs(&self, way: Option<Way>, target: f64) -> Option<Needs> {
        let curve = self.curve(way);
        let of = |x: &dyn Fn(&Measured, f64) -> f64| {
            interpolate(curve.iter().map(|(result, n)| (x(result, *n), result.map_error())), target)
        };
        Some(Needs {
            ms: of(&|result, _| result.ms())?,
            lookups: of(&|_, lookups| lookups)?,
            samples: of(&|result, _| f64::from(result.samples()))?,
        })
    }
}

/// What an error takes.
struct Needs {
    ms: f64,
    lookups: f64,
    samples: f64,
}

const POINT: &str = "point light";
const TEXTURED: &str = "stained-glass spot";

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context);
    let mut found = experiment(
        context,
        "wyman-table1",
        "Shadow volumes and marching against brute force",
        "Wyman & Ramsey 2008, Table 1",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let depth = context.setups.media().find(|(name, _)| *name == "thin").map_or(0.3, |(_, depth)| depth);
    let mut cases = Vec::new();
    for source in &chosen(context, &plan) {
        let Some(point) = source.setup_lit(depth, LightKind::Point)? else { continue };
        cases.push(measure(context, &plan, source, POINT, point)?);
        let Some(mut spot) = source.setup_lit(depth, LightKind::Spot)? else { continue };
        if plan.spots {
            cases.push(measure(context, &plan, source, "spot light", spot.clone())?);
        }
        give_glass(&mut spot);
        cases.push(measure(context, &plan, source, TEXTURED, spot)?);
    }
    for case in &cases {
        found.rows.extend(rows(case));
        found.equal_error.extend(tables::equal_errors(case));
    }
    section.tables.push(tables::table1(&cases));
    section.tables.push(tables::ratios(&cases));
    section.tables.push(tables::stages(&cases));
    section.tables.push(tables::equal_error(&cases));
    section.tables.push(tables::low_resolution(&cases));
    found.checks = checks::checks(&cases);
    for case in &cases {
        if case.light == POINT {
            section.plots.push(pictures::plot(case));
        }
    }
    // two of each kind of light show what there is to see
    for light in [POINT, TEXTURED] {
        for case in cases.iter().filter(|case| case.light == light).take(3) {
            section.pictures.push(pictures::row(case)?);
        }
    }
    exact_times(context, &mut found, &mut section)?;
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

/// The table's scenes, the quick ones first where not all of them run.
fn chosen(context: &Context, plan: &Plan) -> Vec<Source> {
    let mut sources: Vec<Source> =
        context.setups.sources().into_iter().filter(|source| source.entry.wyman.is_some()).collect();
    if plan.scenes < sources.len() {
        sources.sort_by_key(|source| !source.entry.quick);
        sources.truncate(plan.scenes);
    }
    sources
}

/// Puts the window before every spot, in the model that the paper's coloured lights have.
fn give_glass(setup: &mut Setup) {
    setup.model = AirlightModel::HoffmanPreetham;
    let glass = Arc::new(stained_glass());
    for light in &mut setup.lights {
        if let Light::Spot(spot) = light {
            spot.texture = Some(Arc::clone(&glass));
        }
    }
}

/// The table's columns, and the sweep where a light has one.
fn settings(base: Options, plan: &Plan, light: &str) -> Vec<Setting> {
    let textured = light == TEXTURED;
    let at = |samples, scale| Options { samples: Some(samples), sampling: Sampling::blocks(scale), ..base };
    let brute = |samples: u32, scale: u32| {
        Setting::new(brute_name(samples, scale), Technique::BruteForce, at(samples, scale))
    };
    let hybrid = |samples: u32, way: Way, scale: u32| {
        // up to 50 each in front of, between and behind the faces
        let hybrid = HybridOptions { lit_samples: textured.then_some(samples), ..way.options() };
        let options = Options { hybrid, ..at(samples, scale) };
        let still = samples == HYBRID && way != Way::Tiles && !textured;
        let rebuild = if still { Rebuild::Both } else { Rebuild::Always };
        Setting { rebuild, ..Setting::new(hybrid_name(samples, way, scale), Technique::Hybrid, options) }
    };
    let mut all = vec![brute(BRUTE, 1), brute(BRUTE, LOW)];
    for way in [Way::Paper, Way::Bisected] {
        all.extend([hybrid(HYBRID, way, 1), hybrid(HYBRID, way, LOW)]);
    }
    let low = hybrid(HYBRID, Way::Bisected, LOW);
    let options = Options { sampling: Sampling::Blocks { scale: LOW, anew_at_edges: true }, ..low.options };
    all.push(Setting::new(anew_name(), low.technique, options));
    if textured {
        return all;
    }
    // the other spot has the table's columns, the point light the sweep too
    let swept = light == POINT;
    let open = Options { shadows_in_medium: false, ..at(1, 1) };
    all.push(Setting::new(NO_SHADOWS, Technique::BruteForce, open));
    if !swept {
        return all;
    }
    // per-frame tables are the GPU's alone
    all.extend(FORMS.iter().map(|(name, form)| {
        let plain = hybrid(HYBRID, Way::Bisected, 1);
        let hybrid = HybridOptions { form: *form, ..plain.options.hybrid };
        let options = Options { hybrid, ..plain.options };
        Setting::new(format!("{}, {name}", plain.name), plain.technique, options)
    }));
    all.extend(plan.brute.iter().filter(|&&n| n != BRUTE).map(|&n| brute(n, 1)));
    all.extend(plan.hybrid.iter().map(|&n| hybrid(n, Way::Tiles, 1)));
    all.extend(plan.hybrid.iter().filter(|&&n| n != HYBRID).map(|&n| hybrid(n, Way::Bisected, 1)));
    all
}

fn measure(
    context: &Context,
    plan: &Plan,
    source: &Source,
    light: &'static str,
    setup: Setup,
) -> Outcome<Case> {
    let scene = source.title();
    tracing::info!("{scene}, {light}");
    let mut arena =
        Arena::new(&context.references, format!("{scene}, {light}"), setup, base(plan.side, plan.map))?;
    let settings = settings(arena.base, plan, light);
    let results = arena.measure(context.gpu.as_ref(), &settings)?;
    let counts = Lookups::count(&arena)?;
    let lookups = settings
        .iter()
        .map(|setting| {
            let Options { sampling, shadows_in_medium, .. } = setting.options;
            let counted = sampling == Sampling::Pixels && shadows_in_medium && light == POINT;
            counted.then(|| counts.of(&arena, setting)).transpose()
        })
        .collect::<Outcome<Vec<_>>>()?;
    let find = |scale| {
        let name = hybrid_name(HYBRID, Way::Bisected, scale);
        results.iter().find(|result| result.setting.name == name)
    };
    let low = match (find(1), find(LOW)) {
        (Some(full), Some(low)) => {
            let (near_edges, elsewhere) = rms_at_edges(&low.image, &full.image, &arena.rays.ends);
            let flip = metrics::compare(&low.image, &full.image, None, None)?.flip;
            let anew = results.iter().find(|result| result.setting.name == anew_name());
            let anew = anew.map(|anew| rms_at_edges(&anew.image, &full.image, &arena.rays.ends));
            let anew = anew.map(|(near_edges, elsewhere)| near_edges / elsewhere);
            Some(Low { flip, near_edges, elsewhere, anew })
        }
        _ => None,
    };
    Ok(Case {
        scene,
        light,
        triangles: arena.triangles(),
        wyman: source.entry.wyman.clone(),
        results,
        lookups,
        covered: counts.covered,
        pixels: u64::from(plan.side).pow(2),
        exact_on_map: arena.map.exact,
        low,
    })
}

fn rows(case: &Case) -> Vec<Row> {
    let rows = case.results.iter().zip(&case.lookups).map(|(result, lookups)| {
        let mut row = result.row(&case.title(), case.triangles);
        row.params.insert("light".into(), case.light.into());
        if let Some(lookups) = lookups {
            row.params.insert("lookups_per_covered_pixel".into(), (*lookups).into());
            row.params.insert("covered_pixels".into(), case.covered.into());
        }
        row.paper = tables::fps(case, &result.setting).map(|fps| {
            let wyman = case.wyman.as_ref().map_or("", |wyman| &wyman.row);
            [("fps".to_owned(), fps.into()), ("row".to_owned(), wyman.into())].into_iter().collect()
        });
        row
    });
    rows.collect()
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let usual = HybridOptions::default();
    let mut notes = vec![
        format!("Pictures are {0}×{0} and maps {1}², airlight only, in the thin medium; the paper's pictures are 1024×1024 with surfaces.", plan.side, plan.map),
        "Times are of the fog alone, everything in it that a moving light needs (silhouettes and faces are found anew in every frame); view rays and maps are drawn once and given to all. The paper's are whole frames, with surfaces, shadow map and shadow volumes: its ratios to the frame without shadows are damped by what both frames share, ours are not.".into(),
        "Brute force is an honest baseline: same compute path, airlight form and map as the hybrid, clipped to scene depth, light extent and to what occluders can shadow; adjoining lit steps are one evaluation.".into(),
        format!("Hybrid, the paper's way: faces of every pixel, a plain march of equal steps between the frontmost and the backmost; under an uncoloured light the other ways step by equal angle. Tiles: faces of blocks of {} pixels a side, conservative. Bisection: each boundary found between two steps is bisected {} times. The sweep has tiles with and without it, so that its gain is not credited to the bounds.", usual.tile, usual.refine),
        "Lookups per covered pixel are counted by the implementations of the CPU, bisections included: of brute force those in covered pixels alone, of the hybrid all, also those in pixels that merely share a tile with a face. Covered are the pixels with a shadow-volume face before their surface. Where rows name samples, they are the GPU's upper bound of the steps.".into(),
        "The textured light is the set-up's spot with a stained-glass picture, in Hoffman and Preetham's model; the hybrid takes up to 50 steps each in front of, between and behind the faces.".into(),
        "Paper values are from a GeForce 8800 GTX.".into(),
    ];
    notes.extend(clock_note(context));
    if context.gpu.is_none() {
        notes.push("The CPU has smaller pictures and fewer sample counts, and extrudes shadow volumes in every frame.".into());
    }
    if context.setups.has_stand_ins() {
        notes.push("Generated scenes of the papers' triangle counts stand in for models that were not given, and their times must not be compared with the paper's rows as if they were the same.".into());
    }
    notes
}
