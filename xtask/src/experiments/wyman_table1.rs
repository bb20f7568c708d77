//! `wyman-table1`: the rows of Wyman and Ramsey's Table 1 that need no GPU.
//!
//! For every scene and medium: airlight without shadows, brute-force ray marching from 10 to 1000 samples, and the
//! exact reference, each timed and compared with the exact picture. Surfaces are black throughout, since the table is
//! about the medium. All techniques of a scene take turns, so that their ratios survive a noisy machine.

use std::collections::BTreeMap;
use std::time::Duration;

use ground_truth::ExactShadows;
use scene::{Bvh, Interval, LightId};
use serde_json::{Map, Value, json};

use super::equal_error::{interpolate, median};
use super::{Context, Preset, experiment};
use crate::failure::Outcome;
use crate::frame::{Picture, render};
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::metrics::{self, Metrics};
use crate::report::data::{Bound, Check, EqualError, Experiment, Row};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Cost, Panel, PanelKind, PictureRow, Plot, Section, Series};
use crate::scene_args::Setup;
use crate::setups::{Source, Wyman};
use crate::technique::{Options, Technique};

/// Frames after which a median counts for a ratio.
const WARM_FRAMES: usize = 5;

/// Errors at which times are compared.
const TARGETS: [f64; 3] = [0.05, 0.01, 0.002];

/// Side of the picture in which the exact reference is timed on sponza and on the sphere over a floor; units: pixels.
const EXACT_SIDE: u32 = 512;

struct Plan {
    side: u32,
    samples: &'static [u32],
    /// Time that the frames of one setting may take together; fewer than [`WARM_FRAMES`] then give no ratio.
    budget: Duration,
    /// How many scenes run where none are given.
    generated: usize,
    media: usize,
}

fn plan(preset: Preset) -> Plan {
    let seconds = Duration::from_secs;
    match preset {
        Preset::Smoke => {
            Plan { side: 32, samples: &[10, 30, 100, 300], budget: seconds(1), generated: 2, media: 1 }
        }
        Preset::Quick => Plan {
            side: 96,
            samples: &[10, 20, 50, 100, 150, 300, 1000],
            budget: seconds(4),
            generated: 2,
            media: 2,
        },
        Preset::Standard => Plan {
            side: 512,
            samples: &[10, 20, 50, 100, 150, 300, 500, 1000],
            budget: seconds(10),
            generated: usize::MAX,
            media: 2,
        },
        Preset::Paper => Plan {
            side: 1024,
            samples: &[10, 20, 50, 100, 150, 300, 500, 1000],
            budget: seconds(60),
            generated: usize::MAX,
            media: 2,
        },
    }
}

/// What is rendered and timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Setting {
    NoShadows,
    BruteForce(u32),
    Exact,
}

impl Setting {
    fn name(self) -> String {
        match self {
            Self::NoShadows => "no shadows".into(),
            Self::BruteForce(samples) => format!("brute force, {samples} samples"),
            Self::Exact => "exact".into(),
        }
    }

    fn render(self, setup: &Setup, bvh: &Bvh, side: u32, label: &str) -> Outcome<Picture> {
        let (technique, samples) = match self {
            // both without a march: shadows off, every lit interval is one evaluation
            Self::NoShadows => (Technique::BruteForce, 1),
            Self::BruteForce(samples) => (Technique::BruteForce, samples),
            Self::Exact => (Technique::Exact, 1),
        };
        let options = Options {
            airlight_only: true,
            shadows_in_medium: self != Self::NoShadows,
            samples: Some(samples),
            ..Options::new((side, side))
        };
        render(setup, bvh, technique, &options, None, label)
    }
}

/// One setting on one scene and medium.
struct Result {
    setting: Setting,
    picture: Picture,
    metrics: Metrics,
    /// Times of the technique in the frames after the first, sorted; units: ms.
    times: Vec<f64>,
    /// Times of whole frames, likewise.
    frames: Vec<f64>,
}

impl Result {
    fn median(&self) -> f64 {
        median(&self.times).unwrap_or(self.picture.ms)
    }

    fn samples(&self) -> Option<u32> {
        match self.setting {
            Setting::BruteForce(samples) => Some(samples),
            _ => None,
        }
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context.preset);
    let mut found = experiment(
        context,
        "wyman-table1",
        "Brute-force marching against exact shadows",
        "Wyman & Ramsey 2008, Table 1 (CPU rows)",
    );
    let mut section = Section::default();
    let mut orders = Table::new(
        "Convergence of brute force",
        vec![
            Column::left("scene"),
            Column::right("weight of shadows"),
            Column::right("order, rel_rmse"),
            Column::right("order, shadow_err"),
            Column::right("samples for 1 %"),
            Column::right("samples for 0.2 %"),
        ],
    );
    orders.note = Some("Order: p in error ∝ samples^−p, fitted over all sample counts. Weight of shadows: ‖u − b‖/‖b‖ of unshadowed and exact airlight. Samples: interpolated for shadow_err; a dash where 1000 do not reach it.".into());
    let mut worst_step = (0.0_f64, String::new());
    let mut least_weight = f64::INFINITY;
    for (i, source) in chosen(context, &plan).iter().enumerate() {
        let mut series = Vec::new();
        let mut convergence = Vec::new();
        let mut bvh = None;
        for (medium, depth) in context.setups.media().take(plan.media) {
            let title = format!("{} ({medium})", source.title());
            let setup = source.setup(depth)?;
            let bvh = match &mut bvh {
                Some(bvh) => &*bvh,
                empty => &*empty.insert(Bvh::build(&setup.scene).map_err(crate::failure::Failure::program)?),
            };
            let results = measure(&setup, bvh, &plan, &title)?;
            let triangles = setup.scene.triangle_count() as u64;
            found
                .rows
                .extend(results.iter().map(|r| row(r, &title, triangles, bvh, source.entry.wyman.as_ref())));
            found.equal_error.extend(equal_errors(&results, &title));
            let marched: Vec<(f64, &Metrics)> =
                results.iter().filter_map(|r| Some((f64::from(r.samples()?), &r.metrics))).collect();
            let weight = results
                .iter()
                .find(|r| r.setting == Setting::NoShadows)
                .map_or(f64::NAN, |r| r.metrics.rel_rmse);
            least_weight = least_weight.min(weight);
            for pair in marched.windows(2) {
                for (a, b) in
                    [(pair[0].1.rel_rmse, pair[1].1.rel_rmse), (shadow(pair[0].1), shadow(pair[1].1))]
                {
                    if b / a > worst_step.0 {
                        worst_step = (b / a, format!("{title}, {} to {} samples", pair[0].0, pair[1].0));
                    }
                }
            }
            let needed = |target| interpolate(marched.iter().map(|(n, m)| (*n, shadow(m))), target);
            orders.push(vec![
                title.clone(),
                report::figure(weight),
                report::figure(order(&marched, |m| m.rel_rmse)),
                report::figure(order(&marched, shadow)),
                report::figure(needed(0.01)),
                report::figure(needed(0.002)),
            ]);
            series.push(Series {
                label: format!("brute force, {medium}"),
                points: results
                    .iter()
                    .filter(|r| r.samples().is_some())
                    .map(|r| (r.median(), shadow(&r.metrics)))
                    .collect(),
                joined: true,
            });
            convergence.push(Series {
                label: medium.to_owned(),
                points: marched.iter().map(|(n, m)| (*n, shadow(m))).collect(),
                joined: true,
            });
            if i < 3 {
                section.pictures.push(pictures(&results, source, medium)?);
            }
        }
        section.plots.push(Plot {
            file: format!("{}-time.svg", source.entry.id),
            title: format!("{}: shadow error against time", source.title()),
            caption: format!(
                "Brute force at {} sample counts; the exact reference has no error and stands in the tables.",
                plan.samples.len()
            ),
            x: Axis::new("time of the airlight", "ms"),
            y: Axis::new("shadow error", ""),
            series,
        });
    }
    found.checks = vec![
        Check {
            note: Some(worst_step.1),
            ..Check::new(
                "brute force: each step to more samples makes rel_rmse and shadow_err smaller (largest ratio of neighbours)",
                "convergence to exact",
                Some(worst_step.0).filter(|w| *w > 0.0),
                Bound::AtMost,
                0.999,
            )
        },
        Check::new(
            "shadows matter in every set-up: least ‖u − b‖/‖b‖",
            "fixed set-ups",
            Some(least_weight).filter(|w| w.is_finite()),
            Bound::AtLeast,
            0.2,
        ),
    ];
    exact_times(context, &mut found, &mut section)?;
    section.tables.insert(0, paper_table(&found.rows));
    section.tables.push(orders);
    found.notes.extend(notes(context, &plan));
    section.experiment = found;
    Ok(section)
}

fn shadow(metrics: &Metrics) -> f64 {
    metrics.shadow_err.unwrap_or(f64::NAN)
}

/// With a folder all of its scenes; without one as many as the preset allows, the quick ones first.
fn chosen(context: &Context, plan: &Plan) -> Vec<Source> {
    let mut sources = context.setups.sources();
    if context.setups.has_folder() {
        return sources;
    }
    sources.sort_by_key(|source| !source.entry.quick);
    sources.truncate(plan.generated);
    sources
}

fn measure(setup: &Setup, bvh: &Bvh, plan: &Plan, title: &str) -> Outcome<Vec<Result>> {
    let settings = std::iter::once(Setting::Exact)
        .chain(std::iter::once(Setting::NoShadows))
        .chain(plan.samples.iter().map(|&samples| Setting::BruteForce(samples)));
    let first = settings
        .map(|setting| {
            Ok((setting, setting.render(setup, bvh, plan.side, &format!("{title}: {}", setting.name()))?))
        })
        .collect::<Outcome<Vec<_>>>()?;
    let (exact, open) = (first[0].1.image.clone(), first[1].1.image.clone());
    let mut results = first
        .into_iter()
        .map(|(setting, picture)| {
            let metrics = metrics::compare(&picture.image, &exact, Some(&open), None)?;
            Ok(Result { setting, picture, metrics, times: Vec::new(), frames: Vec::new() })
        })
        .collect::<Outcome<Vec<_>>>()?;
    // the first frame of each was its warm-up; now they take turns
    for _ in 0..WARM_FRAMES {
        for result in &mut results {
            let spent: f64 = result.frames.iter().sum();
            if spent + result.picture.ms_frame() <= plan.budget.as_secs_f64() * 1e3 {
                let picture = result.setting.render(setup, bvh, plan.side, "")?;
                result.times.push(picture.ms);
                result.frames.push(picture.ms_frame());
            }
        }
    }
    for result in &mut results {
        result.times.sort_by(f64::total_cmp);
        result.frames.sort_by(f64::total_cmp);
    }
    Ok(results)
}

fn row(result: &Result, title: &str, triangles: u64, bvh: &Bvh, wyman: Option<&Wyman>) -> Row {
    let mut row = Row::new(title, result.setting.name());
    row.triangles = Some(triangles);
    row.ms_scatter = Some(result.median());
    row.ms_min = Some(result.times.first().copied().unwrap_or(result.picture.ms));
    row.ms_max = Some(result.times.last().copied().unwrap_or(result.picture.ms));
    row.ms_frame = Some(median(&result.frames).unwrap_or(result.picture.ms_frame()));
    row.frames = Some(result.times.len().max(1) as u32);
    row.set_errors(&result.metrics);
    row.memory_bytes = Some((bvh.bytes() + result.picture.bytes()) as u64);
    row.params.insert("pixels".into(), json!(result.picture.image.pixels.len()));
    if let Some(samples) = result.samples() {
        row.params.insert("samples".into(), json!(samples));
        row.samples = Some(result.picture.samples);
        row.rays = Some(result.picture.rays);
    }
    let fps = |value: f64| Some(Map::from_iter([("fps".to_owned(), json!(value))]));
    row.paper = wyman.and_then(|w| match result.setting {
        Setting::NoShadows => fps(w.no_shadows),
        Setting::BruteForce(150) => Some(Map::from_iter([
            ("fps".to_owned(), json!(w.brute_full)),
            ("fps at 256²".to_owned(), json!(w.brute_quarter)),
            ("row".to_owned(), Value::from(w.row.clone())),
        ])),
        _ => None,
    });
    row
}

/// Times at equal `shadow_err`, where the frames were enough for a ratio.
fn equal_errors(results: &[Result], title: &str) -> Vec<EqualError> {
    let enough = results.iter().all(|r| r.times.len() >= WARM_FRAMES || r.samples().is_some_and(|s| s > 150));
    let exact = results.iter().find(|r| r.setting == Setting::Exact).filter(|_| enough).map(Result::median);
    TARGETS
        .iter()
        .map(|&target| {
            let marched = results.iter().filter(|r| r.samples().is_some());
            let brute = interpolate(marched.map(|r| (r.median(), shadow(&r.metrics))), target);
            let ratio = brute.zip(exact).map(|(brute, exact)| brute / exact);
            EqualError {
                scene: title.to_owned(),
                metric: "shadow_err".into(),
                target,
                ms: BTreeMap::from([("brute-force".to_owned(), brute), ("exact".to_owned(), exact)]),
                speedup_over_brute_force: BTreeMap::from([("exact".to_owned(), ratio)]),
            }
        })
        .collect()
}

/// −slope of log error over log samples, by least squares.
fn order(marched: &[(f64, &Metrics)], error: impl Fn(&Metrics) -> f64) -> Option<f64> {
    let points: Vec<(f64, f64)> =
        marched.iter().map(|(n, m)| (n.ln(), error(m).ln())).filter(|(_, e)| e.is_finite()).collect();
    let n = points.len() as f64;
    if n < 2.0 {
        return None;
    }
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let variance: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    Some(-covariance / variance)
}

/// The paper's rows with ours beside them: times as ratios to the unshadowed frame, which a machine cannot spoil.
fn paper_table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Table 1, CPU rows",
        vec![
            Column::left("scene"),
            Column::right("triangles"),
            Column::right("no shadows"),
            Column::right("its shadow error"),
            Column::right("brute force, 150"),
            Column::right("its shadow error"),
            Column::right("exact (error 0)"),
            Column::right("frames: brute ÷ no shadows"),
            Column::right("paper's ratio"),
        ],
    );
    let mut scenes: Vec<&str> = rows.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    for scene in scenes {
        let find = |name: &str| rows.iter().find(|row| row.scene == scene && row.technique == name);
        let (none, brute, exact) = (find("no shadows"), find("brute force, 150 samples"), find("exact"));
        let ms = |row: Option<&Row>| row.and_then(|row| row.ms_scatter);
        // the paper's frames have everything in them, so ours must too where the two stand side by side
        let frame = |row: Option<&Row>| row.and_then(|row| row.ms_frame);
        let fps = |row: Option<&Row>| row?.paper.as_ref()?.get("fps")?.as_f64();
        table.push(vec![
            scene.into(),
            report::count(exact.and_then(|row| row.triangles)),
            report::time(ms(none)),
            report::error(none.and_then(|row| row.shadow_err)),
            report::time(ms(brute)),
            report::error(brute.and_then(|row| row.shadow_err)),
            report::time(ms(exact)),
            report::ratio(frame(brute).zip(frame(none)).map(|(b, n)| b / n)),
            report::ratio(fps(none).zip(fps(brute)).map(|(n, b)| n / b)),
        ]);
    }
    table.note = Some("Times are medians of this run on the CPU and are not the paper's frames per second on a GeForce 8800 GTX; the last column is its ratio of the same two columns at 1024². Both ratios are of whole frames; ours have view rays in them, but no surfaces. A dash where the sample count was not run.".into());
    table
}

fn pictures(results: &[Result], source: &Source, medium: &str) -> Outcome<PictureRow> {
    let exact = &results[0].picture.image;
    let scale = exposure(exact);
    // a stand-in's pictures do not carry the name of what it stands for
    let id = source.title().replace("procedural:", "generated-");
    let mut panels = vec![Panel::new(
        format!("{id}-{medium}-exact.png"),
        "exact",
        format!("Airlight of {} with exact shadows", source.title()),
        &to_srgb8(exact, scale),
        PanelKind::Plain,
    )?];
    let shown = [Setting::NoShadows, Setting::BruteForce(10), Setting::BruteForce(150)];
    for result in results.iter().filter(|r| shown.contains(&r.setting)) {
        let name = result.setting.name();
        let slug = name.replace([' ', ','], "");
        panels.push(Panel::new(
            format!("{id}-{medium}-{slug}.png"),
            name.clone(),
            format!("The same with {name}"),
            &to_srgb8(&result.picture.image, scale),
            PanelKind::Measured(Cost::new(result.median(), &result.metrics)),
        )?);
        panels.push(Panel::new(
            format!("{id}-{medium}-{slug}-error.png"),
            format!("error of {name}"),
            format!("Error of {name} against exact, pixel by pixel"),
            &error_picture(&result.picture.image, exact)?,
            PanelKind::ErrorMap,
        )?);
    }
    Ok(PictureRow { caption: format!("{}, {medium} medium, airlight only", source.title()), panels })
}

/// Scale that lands the 95th percentile at 0.8, as `flip` does.
fn exposure(image: &Image) -> f32 {
    let mut values: Vec<f32> = image.pixels.iter().flatten().copied().filter(|v| v.is_finite()).collect();
    values.sort_by(f32::total_cmp);
    let rank = (0.95 * values.len() as f64).ceil() as usize;
    let at = values.get(rank.max(1) - 1).copied().unwrap_or(0.0);
    if at > 0.0 { 0.8 / at } else { 1.0 }
}

/// How long the exact reference takes at 512², where that is asked of it.
fn exact_times(context: &Context, found: &mut Experiment, section: &mut Section) -> Outcome {
    if context.preset == Preset::Smoke {
        return Ok(());
    }
    let mut table = Table::new(
        "The exact reference at 512²",
        vec![
            Column::left("scene"),
            Column::right("triangles"),
            Column::right("airlight (error 0)"),
            Column::right("airlight per pixel"),
            Column::right("view rays"),
            Column::right("triangles looked at, per pixel"),
        ],
    );
    let mut time = |name: &str, setup: &Setup| -> Outcome<f64> {
        let bvh = Bvh::build(&setup.scene).map_err(crate::failure::Failure::program)?;
        let picture =
            Setting::Exact.render(setup, &bvh, EXACT_SIDE, &format!("{name}: exact at {EXACT_SIDE}²"))?;
        let pixels = f64::from(EXACT_SIDE).powi(2);
        table.push(vec![
            name.into(),
            report::count(setup.scene.triangle_count() as u64),
            report::time(picture.ms),
            report::time(picture.ms / pixels),
            report::time(picture.ms_view_rays),
            report::figure(candidates(setup, &bvh)),
        ]);
        Ok(picture.ms_frame())
    };
    let sphere = crate::scene_args::SceneArgs::default().resolve("procedural:sphere-plane")?;
    time("procedural:sphere-plane", &sphere)?;
    for source in context.setups.sources().iter().filter(|source| source.entry.id == "sponza") {
        let Some((_, depth)) = context.setups.media().next() else { continue };
        let ms = time(&source.title(), &source.setup(depth)?)?;
        found.checks.push(Check::new(
            format!("the exact reference on {} at 512² takes less than 60 s", source.title()),
            "predicted: 5 to 10 s on two cores",
            Some(ms / 1e3),
            Bound::AtMost,
            60.0,
        ));
    }
    table.note = Some("One frame each, hierarchy built before; a frame is airlight and view rays, since surfaces are black. For scale: an unbiased path tracer needs 40 to 80 minutes on such a machine for 1 % noise on the one-sphere scene.".into());
    section.tables.push(table);
    Ok(())
}

/// Mean number of triangles that the exact reference looks at for a pixel, over every sixteenth column and row.
fn candidates(setup: &Setup, bvh: &Bvh) -> f64 {
    let shadows = ExactShadows::new(bvh, &setup.lights);
    let (mut triangles, mut rays) = (0, 0);
    for y in (0..EXACT_SIDE).step_by(16) {
        for x in (0..EXACT_SIDE).step_by(16) {
            let ray = setup.camera.pixel_ray(x, y, (EXACT_SIDE, EXACT_SIDE));
            let end = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            for light in 0..setup.lights.len() {
                triangles += shadows.candidates(&ray, Interval::new(0.0, end), LightId(light));
            }
            rays += 1;
        }
    }
    triangles as f64 / f64::from(rays)
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only; the paper's are 1024×1024.", plan.side),
        "Brute force is an honest baseline: clipped to the surface, the light's extent and what occluders can shadow at all; one visibility test a step at its middle, by a shadow ray; airlight of adjoining lit steps in one evaluation of the interval form. Its error is where it puts the shadows' boundaries.".into(),
        "The time of the fog is that of the airlight alone, for every technique alike: where view rays end is found in a stage of its own, which a frame without fog has too. The time of the whole frame has both.".into(),
        "Times are wall times of this machine's CPU with all its threads; only their ratios within this run mean anything. A setting whose frames exceed the time allowed has fewer than five and gives no ratio.".into(),
        "The exact reference's cost per pixel was predicted at 20 to 40 µs a core (1000 nodes at 15 ns and 400 triangles at 60 ns of the plane between ray and light). A calm machine took 7 to 16 µs a core, its view ray included: what bounds it is the number of triangles near that plane, which stands beside the exact times, at some 40 ns each with the tree's nodes included.".into(),
        "Paper values are from a GeForce 8800 GTX. Hybrid and textured-light columns need the GPU techniques and are not in this version.".into(),
    ];
    if !context.setups.has_folder() {
        notes.push("No scenes folder was given: generated scenes of the papers' triangle counts stand in for the models, and their times must not be compared with the paper's rows as if they were the same.".into());
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_of_a_power_law() {
        let metrics: Vec<Metrics> = [10.0, 100.0, 1000.0]
            .map(|n: f64| Metrics {
                rel_rmse: n.powf(-1.5),
                nmae: 0.0,
                p99: 0.0,
                max_abs: 0.0,
                flip: 0.0,
                nan: 0,
                shadow_err: None,
            })
            .into();
        let marched: Vec<(f64, &Metrics)> = [10.0, 100.0, 1000.0].into_iter().zip(&metrics).collect();
        assert!((order(&marched, |m| m.rel_rmse).unwrap() - 1.5).abs() < 1e-12);
    }
}
