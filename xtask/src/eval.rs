//! `eval`: the airlight functions over a file of cases, as JSON.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use gpu_backend::{AirlightProbe, GpuContext, Problem, SunProbe, SunProblem};
use media_math::{
    Boundary, CompensatedSum, Foot, HoffmanPreetham, HomogeneousMedium, MieNormalisation, PhaseFunction,
    Real, airlight, signed_airlight, sun_f, sun_f_difference,
};
use rayon::prelude::*;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::gpu;
use crate::output_file;

/// What the cases of a file ask for.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Kind {
    /// Sun et al.'s F(u, v) and its differences.
    F,
    /// Airlight of one interval.
    Airlight,
    /// Airlight of a shadowed ray.
    Intervals,
    /// Inscatter and extinction of a directional light.
    HoffmanPreetham,
}

/// Evaluate the airlight functions over a file of cases.
#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// What to evaluate.
    kind: Kind,
    /// The cases.
    cases: PathBuf,
    /// Where the results go: a JSON array with one object a case, in order.
    #[arg(short, long)]
    output: PathBuf,
    /// Part of the name of the GPU adapter to use.
    #[arg(long)]
    adapter: Option<String>,
}

pub(crate) fn run(args: &EvalArgs) -> Outcome {
    output_file::check_writable(&args.output)?;
    output_file::check_distinct(&[("the cases", &args.cases), ("--output", &args.output)])?;
    let open_gpu = || gpu::open(args.adapter.as_deref());
    if args.adapter.is_some() && matches!(args.kind, Kind::HoffmanPreetham) {
        // named in vain is an error for every kind
        open_gpu()?;
    }
    let results = match args.kind {
        Kind::F => {
            let file: FFile = read(&args.cases)?;
            if file.f.is_none() && file.difference.is_none() {
                return Err(Failure::input(format!(
                    "{}: has neither F nor difference",
                    args.cases.display()
                )));
            }
            let (f, difference) = (file.f.unwrap_or_default(), file.difference.unwrap_or_default());
            let mut results: Vec<Value> = f.par_iter().map(FCase::result).collect();
            results.par_extend(difference.par_iter().map(DifferenceCase::result));
            if let Some(gpu) = open_gpu()? {
                let problems: Vec<SunProblem> = f
                    .iter()
                    .map(FCase::problem)
                    .chain(difference.iter().map(DifferenceCase::problem))
                    .collect();
                let probe = SunProbe::new(&gpu).map_err(Failure::program)?;
                for (result, value) in
                    results.iter_mut().zip(probe.evaluate(&problems).map_err(Failure::program)?)
                {
                    result["gpu"] = number(value);
                }
            }
            results
        }
        Kind::Airlight => {
            let file: Cases<AirlightCase> = read(&args.cases)?;
            let results = each(&args.cases, &file.cases, AirlightCase::result)?;
            with_gpu(open_gpu()?.as_ref(), results, file.cases.iter().map(AirlightCase::problem))?
        }
        Kind::Intervals => {
            let file: Rays = read(&args.cases)?;
            let results = each(&args.cases, &file.rays, RayCase::result)?;
            with_gpu(open_gpu()?.as_ref(), results, file.rays.iter().map(RayCase::problem))?
        }
        Kind::HoffmanPreetham => {
            let file: Cases<HoffmanPreethamCase> = read(&args.cases)?;
            each(&args.cases, &file.cases, HoffmanPreethamCase::result)?
        }
    };
    let mut text = serde_json::to_string_pretty(&results).map_err(Failure::program)?;
    text.push('\n');
    output_file::write_bytes(&args.output, text.as_bytes())
}

fn read<T: DeserializeOwned>(path: &Path) -> Outcome<T> {
    let name = path.display();
    let text = output_file::read_input(path)?;
    serde_json::from_slice(&text).map_err(|e| Failure::input(format!("{name}: {e}")))
}

/// Fills `gpu` of every result whose case has a problem for it; without an adapter it stays null.
fn with_gpu(
    gpu: Option<&GpuContext>,
    mut results: Vec<Value>,
    problems: impl Iterator<Item = Option<Lit>>,
) -> Outcome<Vec<Value>> {
    let Some(gpu) = gpu else { return Ok(results) };
    let (places, problems): (Vec<usize>, Vec<Lit>) =
        problems.enumerate().filter_map(|(place, problem)| Some((place, problem?))).unzip();
    let values =
        AirlightProbe::new(gpu).map_err(Failure::program)?.evaluate(&problems).map_err(Failure::program)?;
    for (place, value) in places.into_iter().zip(values) {
        results[place]["gpu"] = number(value);
    }
    Ok(results)
}

/// The results of all cases in order; the first bad case fails the file.
fn each<T: Sync>(
    path: &Path,
    cases: &[T],
    result: impl Fn(&T) -> Result<Value, String> + Sync,
) -> Outcome<Vec<Value>> {
    cases
        .par_iter()
        .enumerate()
        .map(|(i, case)| {
            result(case).map_err(|why| Failure::input(format!("{}: case {i}: {why}", path.display())))
        })
        .collect()
}

#[derive(Deserialize)]
struct Cases<T> {
    cases: Vec<T>,
}

/// A JSON number that holds `value` exactly, and null if no number does.
fn number(value: impl Real) -> Value {
    let value = value.widen();
    if value.is_finite() { json!(value) } else { Value::Null }
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
enum PhaseCase {
    Isotropic,
    Rayleigh,
    Hg { g: f64 },
    RayleighMie { g: f64, fraction: f64 },
}

impl PhaseCase {
    /// The asymmetry of a phase function that the GPU's probe knows.
    fn asymmetry(&self, g_instead: Option<f64>) -> Option<f32> {
        match *self {
            Self::Isotropic => Some(0.0),
            Self::Hg { g } => Some(g_instead.unwrap_or(g) as f32),
            Self::Rayleigh | Self::RayleighMie { .. } => None,
        }
    }

    /// The phase function, with g taken from elsewhere where that is given.
    fn phase<T: Real>(&self, g_instead: Option<f64>) -> Result<PhaseFunction<T>, String> {
        let pick = |g: f64| T::lit(g_instead.unwrap_or(g));
        match *self {
            Self::Isotropic => Ok(PhaseFunction::ISOTROPIC),
            Self::Rayleigh => PhaseFunction::rayleigh_mie(T::zero(), T::one()),
            Self::Hg { g } => PhaseFunction::henyey_greenstein(pick(g)),
            Self::RayleighMie { g, fraction } => PhaseFunction::rayleigh_mie(pick(g), T::lit(fraction)),
        }
        .map_err(|e| e.to_string())
    }
}

/// σ_s and σ_t as the files give them: σ_t is a number of its own, not a sum, and may be 0 beside σ_s > 0.
fn interval<T: Real>(
    sigma_s: T,
    sigma_t: T,
    intensity: T,
    phase: &PhaseFunction<T>,
    foot: &Foot<T>,
    x0: T,
    x1: T,
) -> Result<T, String> {
    let medium = HomogeneousMedium::with_extinction(sigma_s, sigma_t).map_err(|e| e.to_string())?;
    for (name, holds) in [
        ("intensity must be at least 0", intensity >= T::zero()),
        ("h must be at least 0", foot.h >= T::zero()),
        ("an interval must not end before it starts", x1 >= x0),
    ] {
        if !holds {
            return Err(name.into());
        }
    }
    Ok(airlight(&medium, phase, intensity, foot, x0, x1))
}

#[derive(Deserialize)]
struct AirlightCase {
    id: Value,
    kappa_s: f64,
    kappa_t: f64,
    intensity: f64,
    x0: f64,
    x1: f64,
    phase: PhaseCase,
    foot: Option<FootBlock>,
    f32: Option<F32Block>,
}

#[derive(Deserialize)]
struct FootBlock {
    x_foot: f64,
    h: f64,
    value: Option<f64>,
}

#[derive(Deserialize)]
struct F32Block {
    kappa_s: f64,
    kappa_t: f64,
    intensity: f64,
    x_foot: f64,
    h: f64,
    x0: f64,
    x1: f64,
    g: Option<f64>,
    value: Option<f64>,
}

/// A problem for the GPU and its lit intervals.
type Lit = (Problem, Vec<[f32; 2]>);

impl AirlightCase {
    fn problem(&self) -> Option<Lit> {
        let block = self.f32.as_ref().filter(|block| block.value.is_some())?;
        let problem = Problem {
            sigma_s: block.kappa_s as f32,
            sigma_t: block.kappa_t as f32,
            intensity: block.intensity as f32,
            x_foot: block.x_foot as f32,
            h: block.h as f32,
            g: self.phase.asymmetry(block.g)?,
        };
        Some((problem, vec![[block.x0 as f32, block.x1 as f32]]))
    }

    fn result(&self) -> Result<Value, String> {
        let wide = match &self.foot {
            Some(FootBlock { x_foot, h, value: Some(_) }) => number(interval(
                self.kappa_s,
                self.kappa_t,
                self.intensity,
                &self.phase.phase::<f64>(None)?,
                &Foot { x_foot: *x_foot, h: *h },
                self.x0,
                self.x1,
            )?),
            _ => Value::Null,
        };
        let narrow = match &self.f32 {
            Some(block @ F32Block { value: Some(_), .. }) => number(interval(
                block.kappa_s as f32,
                block.kappa_t as f32,
                block.intensity as f32,
                &self.phase.phase::<f32>(block.g)?,
                &Foot { x_foot: block.x_foot as f32, h: block.h as f32 },
                block.x0 as f32,
                block.x1 as f32,
            )?),
            _ => Value::Null,
        };
        Ok(json!({"id": self.id, "f64": wide, "f32": narrow, "gpu": null}))
    }
}

#[derive(Deserialize)]
struct Rays {
    rays: Vec<RayCase>,
}

#[derive(Deserialize)]
struct RayCase {
    kappa_s: f64,
    kappa_t: f64,
    intensity: f64,
    x_foot: f64,
    h: f64,
    phase: PhaseCase,
    lit_intervals: Vec<[f64; 2]>,
}

impl RayCase {
    fn problem(&self) -> Option<Lit> {
        let problem = Problem {
            sigma_s: self.kappa_s as f32,
            sigma_t: self.kappa_t as f32,
            intensity: self.intensity as f32,
            x_foot: self.x_foot as f32,
            h: self.h as f32,
            g: self.phase.asymmetry(None)?,
        };
        Some((problem, self.lit_intervals.iter().map(|&[a, b]| [a as f32, b as f32]).collect()))
    }

    fn result(&self) -> Result<Value, String> {
        Ok(json!({
            "f64": number(self.paired::<f64>()?),
            "f32": number(self.paired::<f32>()?),
            "gpu": null,
            "f32_signed": number(self.signed()?),
        }))
    }

    fn paired<T: Real>(&self) -> Result<T, String> {
        let phase = self.phase.phase::<T>(None)?;
        let foot = Foot { x_foot: T::lit(self.x_foot), h: T::lit(self.h) };
        let mut sum = CompensatedSum::new();
        for &[start, end] in &self.lit_intervals {
            let (start, end) = (T::lit(start), T::lit(end));
            sum.add(interval(
                T::lit(self.kappa_s),
                T::lit(self.kappa_t),
                T::lit(self.intensity),
                &phase,
                &foot,
                start,
                end,
            )?);
        }
        Ok(sum.total())
    }

    /// The boundaries in an order that has nothing to do with their distance.
    fn signed(&self) -> Result<f32, String> {
        let medium = HomogeneousMedium::with_extinction(self.kappa_s as f32, self.kappa_t as f32)
            .map_err(|e| e.to_string())?;
        let foot = Foot { x_foot: self.x_foot as f32, h: self.h as f32 };
        let mut boundaries: Vec<Boundary<f32>> = self
            .lit_intervals
            .iter()
            .flat_map(|&[start, end]| Boundary::of_interval(start as f32, end as f32))
            .collect();
        boundaries.sort_by_key(|boundary| boundary.distance.to_bits().wrapping_mul(0x9E37_79B9));
        Ok(signed_airlight(&medium, &self.phase.phase(None)?, self.intensity as f32, &foot, boundaries))
    }
}

#[derive(Deserialize)]
struct FFile {
    #[serde(rename = "F")]
    f: Option<Vec<FCase>>,
    difference: Option<Vec<DifferenceCase>>,
}

#[derive(Deserialize)]
struct FCase {
    u: f64,
    v: f64,
}

impl FCase {
    fn problem(&self) -> SunProblem {
        SunProblem { u: self.u as f32, v0: 0.0, v1: self.v as f32, _pad: 0.0 }
    }

    fn result(&self) -> Value {
        json!({
            "f64": number(sun_f(self.u, self.v)),
            "f32": number(sun_f(self.u as f32, self.v as f32)),
            "gpu": null,
        })
    }
}

#[derive(Deserialize)]
struct DifferenceCase {
    u: f64,
    v0: f64,
    v1: f64,
}

impl DifferenceCase {
    fn problem(&self) -> SunProblem {
        SunProblem { u: self.u as f32, v0: self.v0 as f32, v1: self.v1 as f32, _pad: 0.0 }
    }

    fn result(&self) -> Value {
        json!({
            "f64": number(sun_f_difference(self.u, self.v0, self.v1)),
            "f32": number(sun_f_difference(self.u as f32, self.v0 as f32, self.v1 as f32)),
            "gpu": null,
        })
    }
}

#[derive(Deserialize)]
struct HoffmanPreethamCase {
    beta_rayleigh: [f64; 3],
    beta_mie: [f64; 3],
    #[serde(default)]
    beta_absorption: [f64; 3],
    g: f64,
    mie_normalisation: Normalisation,
    e_sun: [f64; 3],
    l0: [f64; 3],
    cos_theta: f64,
    s: f64,
    lit_intervals: Vec<[f64; 2]>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum Normalisation {
    Standard,
    HoffmanPreetham,
}

impl HoffmanPreethamCase {
    fn result(&self) -> Result<Value, String> {
        let (wide, narrow) = (self.radiance::<f64>()?, self.radiance::<f32>()?);
        let field = |i: usize| json!({"f64": wide[i], "f32": narrow[i]});
        Ok(json!({"f_ex": field(0), "l_in": field(1), "l": field(2)}))
    }

    /// Extinction factor, inscatter and radiance, by channel.
    fn radiance<T: Real>(&self) -> Result<[[Value; 3]; 3], String> {
        let channels = |v: [f64; 3]| v.map(T::lit);
        let normalisation = match self.mie_normalisation {
            Normalisation::Standard => MieNormalisation::Standard,
            Normalisation::HoffmanPreetham => MieNormalisation::HoffmanPreetham,
        };
        let model = HoffmanPreetham::<T, [T; 3]>::new(
            channels(self.beta_rayleigh),
            channels(self.beta_mie),
            channels(self.beta_absorption),
            T::lit(self.g),
            normalisation,
        )
        .map_err(|e| e.to_string())?;
        let lit = self.lit_intervals.iter().map(|&[a, b]| (T::lit(a), T::lit(b)));
        let f_ex = model.extinction_factor(T::lit(self.s));
        let l_in = model.in_scatter(T::lit(self.cos_theta), channels(self.e_sun), lit);
        let l0 = channels(self.l0);
        let l = [0, 1, 2].map(|c| l0[c] * f_ex[c] + l_in[c]);
        Ok([f_ex, l_in, l].map(|spectrum| spectrum.map(number)))
    }
}
