//! `airlight-accuracy`: speed against error of every form of the airlight integral, by category of case.
//!
//! The cases are the reference set in `tests/data`, whose values were computed with proven digits. Each form is
//! evaluated in f32 and f64 on the cases' own inputs in that type; what is printed is the relative error, and the
//! time of one evaluation measured over the same cases.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::{Duration, Instant};

use gpu_backend::{AirlightProbe, GpuContext, Problem as GpuProblem};
use media_math::{
    AngleTable, FTable, Foot, FrameTable, HomogeneousMedium, Interpolation, PhaseFunction, Real, TableError,
    Warp, airlight, airlight_closed_form, airlight_composite, airlight_equiangular, literal_airlight, sun_f,
};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::json;

use super::{Context, experiment};
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::report;
use crate::report::data::{Bound, Check, Row};
use crate::report::table::{Column, Table};
use crate::report::{Axis, Plot, Section, Series};

const CASES: &str = include_str!("../../../tests/data/airlight_public.json");

/// Least time over which an evaluation is timed in each round.
const TIMED_FOR: Duration = Duration::from_millis(1);

/// How often every form is timed; the median counts.
const ROUNDS: u64 = 5;

/// Largest error that the plot resolves: beyond, one wrong number is like another.
const SHOWN: f64 = 10.0;

/// Results below the smallest normal f32 are outside what single precision can hold.
const LEAST_VALUE: f64 = f32::MIN_POSITIVE as f64;

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    category: String,
    kappa_s: f64,
    kappa_t: f64,
    intensity: f64,
    x0: f64,
    x1: f64,
    phase: PhaseCase,
    foot: Block,
    f32: Option<Block>,
}

#[derive(Deserialize)]
struct PhaseCase {
    g: Option<f64>,
}

/// Inputs in one precision; those of the f64 block that are missing here stand beside it.
#[derive(Deserialize)]
struct Block {
    kappa_s: Option<f64>,
    kappa_t: Option<f64>,
    intensity: Option<f64>,
    x_foot: f64,
    h: f64,
    x0: Option<f64>,
    x1: Option<f64>,
    g: Option<f64>,
    value: Option<f64>,
}

/// One case, ready to be evaluated in `T`.
struct Problem<T> {
    category: usize,
    medium: HomogeneousMedium<T>,
    phase: PhaseFunction<T>,
    intensity: T,
    foot: Foot<T>,
    x0: T,
    x1: T,
    exact: f64,
    /// F′ for this case's eye, light and medium; built only where it is measured.
    frame: Option<FrameTable<T>>,
    /// The same over angles.
    angles: Option<AngleTable<T>>,
}

impl Case {
    fn problem<T: Real>(&self, block: &Block, category: usize) -> Option<Problem<T>> {
        let exact = block.value.filter(|value| *value >= LEAST_VALUE)?;
        let lit = |own: Option<f64>, shared: f64| T::lit(own.unwrap_or(shared));
        let g = block.g.or(self.phase.g).unwrap_or(0.0);
        Some(Problem {
            category,
            medium: HomogeneousMedium::with_extinction(
                lit(block.kappa_s, self.kappa_s),
                lit(block.kappa_t, self.kappa_t),
            )
            .ok()?,
            phase: PhaseFunction::henyey_greenstein(T::lit(g)).ok()?,
            intensity: lit(block.intensity, self.intensity),
            foot: Foot { x_foot: T::lit(block.x_foot), h: T::lit(block.h) },
            x0: lit(block.x0, self.x0),
            x1: lit(block.x1, self.x1),
            exact,
            frame: None,
            angles: None,
        })
    }
}

/// Side of the F′ tables, one of which is built for every case.
const FRAME_SIZE: usize = 256;

impl<T: Real> Problem<T> {
    fn with_frame(mut self) -> Outcome<Self> {
        if self.phase.is_isotropic() {
            let (x_foot, h) = (self.foot.x_foot.widen(), self.foot.h.widen());
            let table = FrameTable::new(
                FRAME_SIZE,
                self.medium.sigma_s().widen(),
                self.medium.sigma_t().widen(),
                x_foot.hypot(h),
                self.x1.widen(),
            );
            self.frame = taken(table)?;
            let angles = AngleTable::new(
                FRAME_SIZE,
                self.medium.sigma_s().widen(),
                self.medium.sigma_t().widen(),
                x_foot.hypot(h),
            );
            self.angles = taken(angles)?;
        }
        Ok(self)
    }
}

/// A table, or none where a case has no such table: a light at the eye. Such a case counts as wrong.
fn taken<T>(table: Result<T, TableError>) -> Outcome<Option<T>> {
    match table {
        Ok(table) => Ok(Some(table)),
        Err(TableError::Value { .. }) => Ok(None),
        Err(error) => Err(Failure::program(error)),
    }
}

type Evaluate<T> = Box<dyn Fn(&Problem<T>) -> T + Sync>;

/// A way to evaluate the integral.
struct Form<T> {
    name: String,
    /// Whether it takes any phase function.
    any_phase: bool,
    evaluate: Evaluate<T>,
}

impl<T: Real> Form<T> {
    fn takes(&self, problem: &Problem<T>) -> bool {
        self.any_phase || problem.phase.is_isotropic()
    }
}

fn forms<T: Real>() -> Result<Vec<Form<T>>, TableError> {
    let form = |name: &str, any_phase, evaluate: Evaluate<T>| Form { name: name.into(), any_phase, evaluate };
    let mut forms = vec![
        form(
            "interval (default)",
            true,
            Box::new(|p| airlight(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1)),
        ),
        form(
            "composite rule",
            true,
            Box::new(|p| airlight_composite(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1)),
        ),
        form(
            "closed form, ends subtracted",
            false,
            Box::new(|p| airlight_closed_form(&p.medium, p.intensity, &p.foot, p.x0, p.x1)),
        ),
        form(
            "exact F, ends subtracted",
            false,
            Box::new(|p| {
                literal_airlight(
                    p.medium.sigma_s(),
                    p.medium.sigma_t(),
                    p.intensity,
                    &p.foot,
                    p.x0,
                    p.x1,
                    sun_f,
                )
            }),
        ),
    ];
    for nodes in [4, 8, 16, 32] {
        forms.push(form(
            &format!("equiangular, {nodes} nodes"),
            true,
            Box::new(move |p| {
                airlight_equiangular(&p.medium, &p.phase, p.intensity, &p.foot, p.x0, p.x1, nodes)
            }),
        ));
    }
    let warps = [
        ("linear u", Warp::Linear { u_max: 10.0 }),
        ("u/(1+u)", Warp::Rational),
        ("u/(1+u)=w²", Warp::RationalSquared),
    ];
    let mut table = |size: usize, (warp_name, warp): (&str, Warp), interpolation| -> Result<(), TableError> {
        let table = FTable::<T>::new(size, warp)?;
        let read = if interpolation == Interpolation::Bilinear { "bilinear" } else { "bicubic" };
        forms.push(form(
            &format!("F table {size}², {warp_name}, {read}"),
            false,
            Box::new(move |p| {
                let (s, t) = (p.medium.sigma_s(), p.medium.sigma_t());
                table.airlight(s, t, p.intensity, &p.foot, p.x0, p.x1, interpolation)
            }),
        ));
        Ok(())
    };
    for warp in warps {
        table(256, warp, Interpolation::Bilinear)?;
    }
    table(64, warps[2], Interpolation::Bicubic)?;
    table(256, warps[2], Interpolation::Bicubic)?;
    table(1024, warps[2], Interpolation::Bilinear)?;
    forms.push(form(
        &format!("F′ table {FRAME_SIZE}², a frame each"),
        false,
        Box::new(|p| {
            let distance = p.foot.x_foot.hypot(p.foot.h);
            p.frame
                .as_ref()
                .map_or(T::nan(), |table| table.airlight(p.intensity, p.foot.x_foot / distance, p.x0, p.x1))
        }),
    ));
    forms.push(form(
        &format!("F′ table {FRAME_SIZE}² over angles, a frame each"),
        false,
        Box::new(|p| {
            let table = p.angles.as_ref();
            table.map_or(T::nan(), |table| table.airlight(p.intensity, &p.foot, p.x0, p.x1))
        }),
    ));
    Ok(forms)
}

/// Relative errors over a set of cases, and the time of one evaluation.
struct Measured {
    form: String,
    precision: &'static str,
    /// Sorted, finite or infinite.
    errors: Vec<f64>,
    ns: f64,
}

impl Measured {
    fn quantile(&self, q: f64) -> f64 {
        let rank = (q * self.errors.len() as f64).ceil() as usize;
        self.errors.get(rank.clamp(1, self.errors.len()) - 1).copied().unwrap_or(f64::NAN)
    }

    fn worst(&self) -> f64 {
        self.errors.last().copied().unwrap_or(f64::NAN)
    }

    fn share_above(&self, bound: f64) -> f64 {
        self.errors.iter().filter(|error| !(**error <= bound)).count() as f64 / self.errors.len() as f64
    }

    fn name(&self) -> String {
        format!("{} ({})", self.form, self.precision)
    }
}

/// Sorted relative errors of a form on those of `problems` that it takes; `None` if it takes none.
fn errors<T: Real>(form: &Form<T>, problems: &[&Problem<T>]) -> Option<Vec<f64>> {
    let of = |p: &&Problem<T>| {
        let error = ((form.evaluate)(p).widen() / p.exact - 1.0).abs();
        if error.is_nan() { f64::INFINITY } else { error }
    };
    let mut errors: Vec<f64> = problems.iter().filter(|p| form.takes(p)).map(of).collect();
    errors.sort_by(f64::total_cmp);
    (!errors.is_empty()).then_some(errors)
}

/// Time of one evaluation, over at least [`TIMED_FOR`]; units: ns.
fn time<T: Real>(form: &Form<T>, problems: &[&Problem<T>]) -> f64 {
    let (started, mut evaluations) = (Instant::now(), 0_u64);
    while evaluations == 0 || started.elapsed() < TIMED_FOR {
        for p in problems.iter().filter(|p| form.takes(p)) {
            black_box((form.evaluate)(black_box(p)));
            evaluations += 1;
        }
    }
    started.elapsed().as_secs_f64() * 1e9 / evaluations as f64
}

/// How often the cases are repeated for a GPU, whose dispatches are expensive and whose threads are many.
const GPU_REPEATS: usize = 256;

/// The interval form in WGSL: over the whole set, and by category. Its time is that of a call: upload, dispatch and
/// readback, by the number of evaluations.
fn measure_gpu(file: &File, categories: &[String], gpu: &GpuContext) -> Outcome<MeasuredForm> {
    let probe = AirlightProbe::new(gpu).map_err(Failure::program)?;
    let measure = |category: Option<&String>| -> Outcome<Option<Measured>> {
        let cases: Vec<(Lit, f64)> = file
            .cases
            .iter()
            .filter(|case| category.is_none_or(|name| *name == case.category))
            .filter_map(|case| {
                let p = case.problem::<f32>(case.f32.as_ref()?, 0)?;
                let g = case.f32.as_ref().and_then(|block| block.g).unwrap_or(0.0) as f32;
                let (sigma_s, sigma_t) = (p.medium.sigma_s(), p.medium.sigma_t());
                let Foot { x_foot, h } = p.foot;
                let problem = GpuProblem { sigma_s, sigma_t, intensity: p.intensity, x_foot, h, g };
                Some(((problem, vec![[p.x0, p.x1]]), p.exact))
            })
            .collect();
        if cases.is_empty() {
            return Ok(None);
        }
        let problems: Vec<Lit> = cases.iter().map(|(problem, _)| problem.clone()).collect();
        let many: Vec<Lit> = (0..GPU_REPEATS).flat_map(|_| problems.iter().cloned()).collect();
        // the first call is the warm-up
        let values = probe.evaluate(&problems).map_err(Failure::program)?;
        let started = Instant::now();
        black_box(probe.evaluate(&many).map_err(Failure::program)?);
        let ns = started.elapsed().as_secs_f64() * 1e9 / many.len() as f64;
        let errors =
            values.iter().zip(&cases).map(|(value, (_, exact))| (f64::from(*value) / exact - 1.0).abs());
        let mut errors: Vec<f64> = errors.map(|e| if e.is_nan() { f64::INFINITY } else { e }).collect();
        errors.sort_by(f64::total_cmp);
        Ok(Some(Measured { form: "interval (default)".into(), precision: "gpu", errors, ns }))
    };
    let whole = measure(None)?.ok_or_else(|| Failure::program("the reference set is empty"))?;
    let each = categories.iter().map(|category| measure(Some(category))).collect::<Outcome<_>>()?;
    Ok((whole, each))
}

/// A problem for the GPU and its lit interval.
type Lit = (GpuProblem, Vec<[f32; 2]>);

/// A form over the whole set, and by category.
type MeasuredForm = (Measured, Vec<Option<Measured>>);

/// Everything measured in one precision: over the whole set, and by category.
fn measure_all<T: Real>(
    file: &File,
    categories: &[String],
    precision: &'static str,
    block: impl Fn(&Case) -> Option<&Block> + Sync,
    progress: &Progress,
) -> Outcome<Vec<MeasuredForm>> {
    let problems: Vec<Problem<T>> = file
        .cases
        .par_iter()
        .filter_map(|case| {
            let category = categories.iter().position(|name| *name == case.category)?;
            case.problem::<T>(block(case)?, category)
        })
        .map(Problem::with_frame)
        .collect::<Outcome<_>>()?;
    let forms = forms::<T>().map_err(Failure::program)?;
    // the whole set, then each category
    let mut sets: Vec<Vec<&Problem<T>>> = vec![problems.iter().collect()];
    sets.extend(
        (0..categories.len()).map(|category| problems.iter().filter(|p| p.category == category).collect()),
    );
    let pairs: Vec<(&Form<T>, &[&Problem<T>])> =
        forms.iter().flat_map(|form| sets.iter().map(move |set| (form, set.as_slice()))).collect();
    let errors: Vec<Option<Vec<f64>>> = pairs.iter().map(|(form, set)| errors(form, set)).collect();
    // the forms take turns, so that their ratios hold on a noisy machine
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); pairs.len()];
    for _ in 0..ROUNDS {
        for (((form, set), errors), times) in pairs.iter().zip(&errors).zip(&mut times) {
            if errors.is_some() {
                times.push(time(form, set));
            }
        }
        progress.inc(1);
    }
    let mut measured = pairs.iter().zip(errors).zip(times).map(|(((form, _), errors), mut times)| {
        times.sort_by(f64::total_cmp);
        let ns = times.get(times.len() / 2).copied()?;
        Some(Measured { form: form.name.clone(), precision, errors: errors?, ns })
    });
    let mut results = Vec::new();
    for _ in &forms {
        let whole = measured.next().flatten();
        let each = measured.by_ref().take(categories.len()).collect();
        results.extend(whole.map(|whole| (whole, each)));
    }
    Ok(results)
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let file: File = serde_json::from_str(CASES).map_err(Failure::program)?;
    let mut categories: Vec<String> = Vec::new();
    for case in &file.cases {
        if !categories.contains(&case.category) {
            categories.push(case.category.clone());
        }
    }
    let progress = Progress::new("airlight-accuracy", 2 * ROUNDS);
    let mut results = measure_all::<f32>(&file, &categories, "f32", |case| case.f32.as_ref(), &progress)?;
    results.extend(measure_all::<f64>(&file, &categories, "f64", |case| Some(&case.foot), &progress)?);
    progress.finish();
    if let Some(gpu) = &context.gpu {
        results.push(measure_gpu(&file, &categories, gpu)?);
    }

    let mut found = experiment(
        context,
        "airlight-accuracy",
        "Airlight: speed against error",
        "MATH of Sun et al. 2005, Wyman & Ramsey 2008 §2 and §3.4, Billeter et al. 2010 §3",
    );
    found.rows = results
        .iter()
        .flat_map(|(whole, each)| {
            let named = each
                .iter()
                .zip(&categories)
                .filter_map(|(m, category)| Some((m.as_ref()?, category.as_str())));
            std::iter::once((whole, "all")).chain(named).map(|(m, category)| row(m, category))
        })
        .collect();
    let default = results.iter().find(|(m, _)| m.form.starts_with("interval") && m.precision == "f32");
    found.checks = checks(&results);
    found.notes = vec![
        format!("The cases are those of the reference set's {} whose exact value is a normal f32; forms for the isotropic phase function only are measured on the cases that have it.", file.cases.len()),
        "Errors are relative to values with proven digits, on inputs that are exact in the type. Times are of one evaluation on one core, over the same cases.".into(),
        "Why the interval form is the default: it is the only form without a bad case. What is subtracted from a table, or from the exact F, loses what the two ends have in common, whatever the table's size: about a quarter of all cases come out wrong by more than 10⁻³ in f32. The closed form is exact in the middle of its range and loses everything on short intervals. Quadrature over the angle with a fixed rule misses thin layers and peaks. The interval form costs more than a table lookup and less than any other form of comparable error; its f32 error is the rounding of the exponent.".into(),
        "The F′ table's times leave out building it, which costs a frame 65 536 evaluations of F.".into(),
    ];
    found.notes.push(match &context.gpu {
        Some(gpu) => format!("GPU: {}. Its time is that of a call over {GPU_REPEATS} copies of the cases, upload and readback included, by the number of evaluations.", gpu.info.name),
        None => "No GPU adapter: its row is missing.".into(),
    });
    if let Some((default, _)) = default {
        found.notes.push(format!(
            "Default form in f32: {} an evaluation, largest error {}, median {}.",
            report::time(default.ns * 1e-6),
            report::error(default.worst()),
            report::error(default.quantile(0.5))
        ));
    }
    Ok(Section {
        tables: vec![overview(&results), by_category(&results, &categories)],
        plots: vec![plot(&results)],
        experiment: found,
        ..Section::default()
    })
}

fn row(measured: &Measured, category: &str) -> Row {
    let mut row = Row::new(category, measured.name());
    row.ms_scatter = Some(measured.ns * 1e-6);
    row.nmae = Some(measured.errors.iter().sum::<f64>() / measured.errors.len() as f64);
    row.p99 = Some(measured.quantile(0.99));
    row.params.extend([
        ("cases".to_owned(), json!(measured.errors.len())),
        ("median".to_owned(), json!(measured.quantile(0.5))),
        ("max".to_owned(), json!(measured.worst())),
        ("share_above_1e-3".to_owned(), json!(measured.share_above(1e-3))),
    ]);
    row
}

fn checks(results: &[MeasuredForm]) -> Vec<Check> {
    let of = |form: &str, precision: &str| {
        results.iter().map(|(m, _)| m).find(|m| m.form.starts_with(form) && m.precision == precision)
    };
    let worst = |form, precision| of(form, precision).map(Measured::worst);
    vec![
        Check::new(
            "interval form in f32: largest relative error",
            "reference set",
            worst("interval", "f32"),
            Bound::AtMost,
            1e-5,
        ),
        Check::new(
            "interval form in f64: largest relative error",
            "reference set",
            worst("interval", "f64"),
            Bound::AtMost,
            1e-12,
        ),
        Check::new(
            "composite rule in f64: largest relative error",
            "reference set",
            worst("composite", "f64"),
            Bound::AtMost,
            1e-12,
        ),
        Check::new(
            "subtracting exact values of F in f32 is wrong by more than 10⁻³ for a share of cases",
            "Sun et al. 2005 read literally",
            of("exact F", "f32").map(|m| m.share_above(1e-3)),
            Bound::AtLeast,
            0.1,
        ),
    ]
}

fn overview(results: &[MeasuredForm]) -> Table {
    let mut table = Table::new(
        "Every form over the whole set",
        vec![
            Column::left("form"),
            Column::left("type"),
            Column::right("time each"),
            Column::right("median error"),
            Column::right("99 %"),
            Column::right("largest error"),
            Column::right("wrong by > 1e-3"),
        ],
    );
    for (m, _) in results {
        table.push(vec![
            m.form.clone(),
            m.precision.into(),
            report::time(m.ns * 1e-6),
            report::figure(m.quantile(0.5)),
            report::figure(m.quantile(0.99)),
            report::figure(m.worst()),
            report::error(m.share_above(1e-3)),
        ]);
    }
    table
}

fn by_category(results: &[MeasuredForm], categories: &[String]) -> Table {
    let mut columns = vec![Column::left("category")];
    let shown: Vec<_> = results.iter().filter(|(m, _)| m.precision == "f32").collect();
    columns.extend(shown.iter().map(|(m, _)| Column::right(m.form.clone())));
    let mut table = Table::new("Largest error and time by category, f32", columns);
    for (i, category) in categories.iter().enumerate() {
        let cells = shown.iter().map(|(_, each)| {
            each[i].as_ref().map_or(report::MISSING.to_owned(), |m| {
                format!("{} in {}", report::figure(m.worst()), report::time(m.ns * 1e-6))
            })
        });
        table.push(std::iter::once(category.clone()).chain(cells).collect());
    }
    let seen: BTreeMap<&str, ()> = categories.iter().map(|c| (c.as_str(), ())).collect();
    table.note = Some(format!(
        "{} categories; a dash where the form does not take the phase function or no value is a normal f32. The f64 figures are in data.json.",
        seen.len()
    ));
    table
}

fn plot(results: &[MeasuredForm]) -> Plot {
    let series = results
        .iter()
        .filter(|(m, _)| m.precision == "f32")
        .map(|(m, each)| Series {
            label: m.form.clone(),
            points: each.iter().flatten().map(|m| (m.ns, m.worst().clamp(1e-9, SHOWN))).collect(),
            joined: false,
        })
        .collect();
    Plot {
        file: "error-against-time.svg".into(),
        title: "Largest error of each category against time, f32".into(),
        caption: "One mark for each form and category of case: time of one evaluation, and the largest relative error among the category's cases; what errs by more than 10, or is not finite, is drawn at 10.".into(),
        x: Axis::new("time of one evaluation", "ns"),
        y: Axis::new("largest relative error", ""),
        series,
    }
}
