//! What a picture is made with: a technique, its settings and its map, cheap enough and within the target error.
//!
//! What can be chosen, and what it costs, is known to `gpu_backend::planner`; what error it has on this scene is measured
//! by a pilot: that of the technique on rays from all over the picture, more of them where they leave a doubt, that of
//! interpolation between few rays on tiles of it. Candidates are asked in the order of their predicted cost. The first that
//! are safely within the target draw frames in turns on the GPU if there is one; on the CPU the pilot has their times already.
//! The fastest is taken. Where none is within the target, the exact reference on the CPU is left.

mod candidates;
mod pilot;
mod sampled;
mod timed;
mod trials;

use gpu_backend::GpuContext;
use gpu_backend::planner::{Costs, Facts, LightFacts, MapFacts, MediumFacts, ShadowFacts};
use hybrid_march::{Adaptive, Sampling};
use scene::Bvh;
use serde_json::{Value, json};

pub(crate) use pilot::{Estimate, Pilot};
use sampled::Sampled;

use crate::failure::Outcome;
use crate::gpu;
use crate::maps::{DEFAULT_SIDE, MapOptions, MapSurface};
use crate::scene_args::Setup;
use crate::technique::{self, Options, Technique, VisibilitySource};
pub(crate) use candidates::options_of;
use candidates::{Candidate, candidates};
use trials::Trials;

/// Where no error is asked for.
pub(crate) const DEFAULT_TARGET: f64 = 0.01;

/// Candidates within the target of which a frame is timed at most, and in how many times the cheapest one's predicted time.
const MOST_TIMED: usize = 5;
const NEARLY_AS_CHEAP: f64 = 2.0;

/// The same on the CPU, of which less is known beforehand: costs are a software adapter's.
const ON_THE_CPU: (usize, f64) = (8, 8.0);

/// Maps on which a pilot measures what few rays err by.
const MOST_SAMPLED: usize = 2;

/// What was asked for by flags: what is `None` may be chosen.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wish {
    pub(crate) technique: Option<Technique>,
    pub(crate) target_error: Option<f64>,
    pub(crate) samples: Option<u32>,
    pub(crate) map_side: Option<u32>,
    pub(crate) surface: Option<MapSurface>,
    pub(crate) visibility: Option<VisibilitySource>,
    /// Whether the tessellation was asked for.
    pub(crate) tessellated: bool,
    /// Whether errors are against the map of the options, not against the geometry.
    pub(crate) on_map: bool,
}

/// Where the techniques run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Device {
    /// The implementations of the CPU.
    Cpu,
    /// A software adapter: as fast as the CPU.
    SoftwareGpu,
    /// A GPU of hardware.
    HardwareGpu,
}

impl Device {
    fn of(gpu: Option<&GpuContext>) -> Self {
        match gpu {
            None => Self::Cpu,
            Some(gpu) if gpu::is_hardware(gpu) => Self::HardwareGpu,
            Some(_) => Self::SoftwareGpu,
        }
    }
}

/// What was chosen, and what is expected of it.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) technique: Technique,
    pub(crate) options: Options,
    /// Whether it runs on the GPU.
    pub(crate) on_gpu: bool,
    /// Why, for each light; or for all of them.
    pub(crate) reasons: Vec<String>,
    /// Units: ms.
    pub(crate) predicted_ms: Option<f64>,
    /// Not known for froxels, which a pilot does not try.
    pub(crate) predicted_error: Option<Estimate>,
    pub(crate) target_error: f64,
    /// Time that choosing took; units: ms.
    pub(crate) pilot_ms: f64,
}

impl Plan {
    /// Whether nothing that was tried is within the target.
    pub(crate) fn misses(&self) -> bool {
        self.predicted_error.is_some_and(|error| error.upper > self.target_error)
    }

    /// As `--json` has it, beside the time that the technique then took (ms).
    pub(crate) fn json(&self, measured_ms: f64) -> Value {
        let Self { technique, options, on_gpu, reasons, .. } = self;
        let map = technique
            .reads_maps(options.visibility)
            .then(|| json!({"size": options.map.side, "surface": options.of(*technique).map.surface.name()}));
        let samples = technique
            .uses("--samples", options.visibility)
            .then(|| options.samples.unwrap_or(technique.default_samples()));
        json!({
            "technique": technique.name(),
            "backend": if *on_gpu { "gpu" } else { "cpu" },
            "samples": samples,
            "sampling": sampling_json(*technique, options),
            "map": map,
            "reasons": reasons,
            "predicted_ms": self.predicted_ms,
            "measured_ms": measured_ms,
            "predicted_error": self.predicted_error.map(|error| error.found),
            "predicted_error_at_most": self.predicted_error.map(|error| error.upper),
            "target_error": self.target_error,
            "pilot_ms": self.pilot_ms,
        })
    }
}

/// For which view rays airlight is computed.
fn sampling_json(technique: Technique, options: &Options) -> Value {
    match technique.sampling(options.sampling) {
        Sampling::Pixels => json!("pixels"),
        Sampling::Blocks { scale, .. } => json!({"blocks": scale}),
        Sampling::Adaptive(adaptive) => {
            json!({"adaptive": {"target_error": adaptive.target_error, "spacing": adaptive.spacing}})
        }
    }
}

/// What is known of a setup whose maps have a side of `side` texels and were drawn for the frame.
pub(crate) fn lights_of(setup: &Setup, bvh: &Bvh, options: &Options, side: u32) -> Vec<LightFacts> {
    let casts = options.shadows_in_medium && !bvh.triangles().is_empty();
    let map = ShadowFacts::Map(MapFacts { side, changed: true });
    let shadows = if casts { map } else { ShadowFacts::None };
    setup.lights.iter().map(|light| LightFacts::of(light, shadows)).collect()
}

/// The facts of a frame with these lights.
pub(crate) fn facts_of<'l>(
    setup: &Setup,
    bvh: &Bvh,
    options: &Options,
    lights: &'l [LightFacts],
    target_error: f64,
) -> Facts<'l> {
    let (width, height) = options.size;
    Facts {
        lights,
        medium: MediumFacts::of(&setup.medium, setup.model),
        views: options.froxels.viewers,
        pixels: u64::from(width) * u64::from(height) * u64::from(options.froxels.viewers),
        triangles: setup.scene.triangle_count() as u64,
        diagonal: bvh.bounds().diagonal(),
        casts_rays: true,
        target_error: target_error as f32,
    }
}

/// What the planner expects a technique with its options to take on a software adapter (ms); `None` for what it does not
/// know.
pub(crate) fn predict(setup: &Setup, bvh: &Bvh, technique: Technique, options: &Options) -> Option<f64> {
    let options = options.of(technique);
    let lights = lights_of(setup, bvh, &options, options.map.side);
    let facts = facts_of(setup, bvh, &options, &lights, DEFAULT_TARGET);
    let candidate = candidates::candidate_of(technique, &options, bvh.bounds().diagonal())?;
    Some(Costs::SOFTWARE.predict(&facts, &candidate))
}

/// Chooses what a picture is made with; `base` has what is not to be chosen.
///
/// Fails where a map cannot be drawn.
pub(crate) fn plan(
    setup: &Setup,
    bvh: &Bvh,
    base: &Options,
    wish: &Wish,
    gpu: Option<&GpuContext>,
) -> Outcome<Plan> {
    let device = Device::of(gpu);
    let target_error = wish.target_error.unwrap_or(DEFAULT_TARGET);
    let exact = |reason: &str, pilot_ms, predicted_ms| Plan {
        technique: Technique::Exact,
        options: *base,
        on_gpu: false,
        reasons: vec![reason.to_owned(); setup.lights.len()],
        predicted_ms,
        predicted_error: Some(Estimate::NONE),
        target_error,
        pilot_ms,
    };
    let free = wish.technique.is_none();
    let analytic = setup.medium.is_homogeneous();
    let asked = wish.target_error.is_some() || wish.on_map;
    if free && analytic && device == Device::Cpu && !asked && base.froxels.viewers < 2 {
        let reason =
            "homogeneous medium: exact shadows and integrals on the CPU, where no target is asked for";
        return Ok(exact(reason, 0.0, None));
    }
    if free && base.froxels.viewers > 1 {
        return Ok(Plan {
            technique: Technique::SharedGrid,
            options: *base,
            on_gpu: device != Device::Cpu,
            reasons: vec![format!("{} viewers share a grid of shadows", base.froxels.viewers)],
            predicted_ms: None,
            predicted_error: None,
            target_error,
            pilot_ms: 0.0,
        });
    }
    let mut pilot = Pilot::new(setup, bvh, base, wish.on_map)?;
    let mut all = candidates(setup, bvh, base, wish, device, target_error, &Costs::SOFTWARE);
    measure_sampling(&mut pilot, &mut all, base, target_error)?;
    let finest = |a: &&Candidate, b: &&Candidate| a.usual_error.total_cmp(&b.usual_error);
    let last_resort = all.iter().min_by(finest).cloned();
    // a closed form is one anywhere
    let on_the_cpu = free && analytic && device != Device::HardwareGpu && !wish.on_map;
    let most_ms = if on_the_cpu { pilot.exact_ms } else { f64::INFINITY };
    let (within, nearest) = within_target(&mut pilot, all, target_error, device, most_ms)?;
    let mut best = match gpu {
        Some(gpu) if within.len() > 1 => Some(fastest(gpu, &mut pilot, within)?),
        None => within
            .into_iter()
            .min_by(|a, b| a.ms.total_cmp(&b.ms))
            .filter(|best| best.ms < most_ms)
            .or(nearest),
        Some(_) => within.into_iter().next().or(nearest),
    };
    if best.is_none() && (!free || !analytic) {
        // the best there is of what was asked for
        best = last_resort.map(|candidate| Judged::of(candidate, &mut pilot, device)).transpose()?;
    }
    let met = best.as_ref().is_some_and(|best| best.error.upper <= target_error);
    match (best, wish.technique) {
        (Some(Judged { candidate, error, ms }), _) if met || !free || !analytic || wish.on_map => Ok(Plan {
            technique: candidate.technique,
            options: candidate.options,
            on_gpu: device != Device::Cpu,
            reasons: candidate.reasons,
            predicted_ms: Some(ms),
            predicted_error: Some(error),
            target_error,
            pilot_ms: pilot.ms(),
        }),
        (None, Some(technique)) => Ok(Plan {
            technique,
            options: *base,
            on_gpu: device != Device::Cpu,
            reasons: vec!["asked for".to_owned(); setup.lights.len()],
            predicted_ms: None,
            predicted_error: None,
            target_error,
            pilot_ms: pilot.ms(),
        }),
        _ => {
            let reason = "nothing faster is within the target: exact on the CPU";
            Ok(exact(reason, pilot.ms(), Some(pilot.exact_ms)))
        }
    }
}

/// A candidate with its error, and its time: measured on the CPU, predicted for a GPU; units: ms.
struct Judged {
    candidate: Candidate,
    error: Estimate,
    ms: f64,
}

impl Judged {
    fn of(candidate: Candidate, pilot: &mut Pilot<'_>, device: Device) -> Outcome<Self> {
        let (error, cpu) = pilot.judge(candidate.technique, &candidate.options)?;
        let ms = if device == Device::Cpu { cpu.of(candidate.traced()) } else { candidate.predicted_ms };
        Ok(Self { error: error.with(candidate.interpolated()), ms, candidate })
    }
}

/// The cheapest candidates that are safely within the target, one of each kind: a GPU is asked for their times, the CPU's are
/// known. Beside them the nearest of those that are not. `most_ms` is what those with an error may take.
fn within_target(
    pilot: &mut Pilot<'_>,
    all: Vec<Candidate>,
    target: f64,
    device: Device,
    most_ms: f64,
) -> Outcome<(Vec<Judged>, Option<Judged>)> {
    let mut within: Vec<Judged> = Vec::new();
    let mut nearest: Option<Judged> = None;
    let mut trials = Trials::default();
    let (most, nearly) = if device == Device::Cpu { ON_THE_CPU } else { (MOST_TIMED, NEARLY_AS_CHEAP) };
    for candidate in all {
        if candidate.predicted_ms > most_ms && candidate.usual_error > 0.0 {
            break;
        }
        if let Some(cheapest) = within.first() {
            let hopeless = candidate.predicted_ms > nearly * cheapest.candidate.predicted_ms;
            if hopeless || within.len() == most {
                break;
            }
            // the same with more rays, or on a finer map, takes more time
            if within.iter().any(|other| other.candidate.is_like(&candidate)) {
                continue;
            }
        }
        if !trials.allow(pilot, &candidate, target)? {
            continue;
        }
        let mut own = pilot.judge(candidate.technique, &candidate.options)?.0;
        let mut judged = Judged::of(candidate, pilot, device)?;
        let Candidate { technique, options, .. } = &judged.candidate;
        // on more rays it may turn out to be safe
        if judged.error.found <= target && judged.error.upper > target {
            own = pilot.judge_closely(*technique, options)?;
            judged.error = own.with(judged.candidate.interpolated());
        }
        trials.note(&judged.candidate, own.upper);
        if judged.error.upper <= target {
            within.push(judged);
        } else if nearest.as_ref().is_none_or(|least| judged.error.upper < least.error.upper) {
            nearest = Some(judged);
        }
    }
    Ok((within, nearest))
}

/// The one whose frames take the least time on a GPU: what is predicted is known within a factor of two.
fn fastest(gpu: &GpuContext, pilot: &mut Pilot<'_>, mut within: Vec<Judged>) -> Outcome<Judged> {
    let candidates: Vec<&Candidate> = within.iter().map(|judged| &judged.candidate).collect();
    let times = timed::times(gpu, pilot, &candidates)?;
    let mut fastest = (f64::INFINITY, 0);
    for (index, (Judged { candidate, .. }, ms)) in within.iter().zip(times).enumerate() {
        // what a GPU cannot hold is left out, and refused by the frame itself where nothing else is left
        let Some(ms) = ms else { continue };
        let (name, predicted) = (candidate.technique.name(), candidate.predicted_ms);
        tracing::debug!("{name} in {ms:.1} ms, {predicted:.1} ms predicted");
        if ms < fastest.0 {
            fastest = (ms, index);
        }
    }
    Ok(within.swap_remove(fastest.1))
}

/// Measures what few rays err by and how many they are, for candidates on the smallest maps that are good enough, and leaves
/// out those whose interpolation alone is above the target; the cheapest come first again.
fn measure_sampling(
    pilot: &mut Pilot<'_>,
    all: &mut Vec<Candidate>,
    base: &Options,
    target: f64,
) -> Outcome<()> {
    // rays see what the finest of maps do
    let seen = |candidate: &Candidate| {
        let reads = candidate.technique.reads_maps(candidate.options.visibility);
        let side = if reads { candidate.options.map.side } else { DEFAULT_SIDE };
        (reads, MapOptions { side, surface: MapSurface::Step })
    };
    let sampled = all.iter().filter(|candidate| candidate.adaptive().is_some());
    let mut maps: Vec<(bool, MapOptions)> = sampled.map(seen).collect();
    maps.sort_by_key(|(reads, map)| (map.side, *reads));
    maps.dedup();
    let mut measured = Vec::new();
    for (reads, map) in maps {
        if measured.len() < MOST_SAMPLED {
            let options = Options { map, ..*base };
            let exact = reads && technique::check(pilot.setup(), Technique::ExactShadowMap, "").is_ok();
            if !exact || pilot.judge(Technique::ExactShadowMap, &options)?.0.found <= target {
                measured.push((reads, map));
            }
        }
    }
    let mut known: Vec<(MapOptions, Adaptive, Option<Sampled>)> = Vec::new();
    for candidate in all.iter_mut() {
        let seen = seen(candidate);
        let Some(adaptive) = candidate.adaptive().filter(|_| measured.contains(&seen)) else { continue };
        // a surface through the texels is smoother than steps, and interpolates no worse
        let (_, map) = seen;
        let found = match known.iter().find(|(other, sampling, _)| *other == map && *sampling == adaptive) {
            Some((.., found)) => *found,
            None => {
                let found = pilot.sampled(map, &adaptive)?;
                known.push((map, adaptive, found));
                found
            }
        };
        if let Some(sampled) = found {
            let lights = lights_of(pilot.setup(), pilot.bvh(), base, candidate.options.map.side);
            let facts = facts_of(pilot.setup(), pilot.bvh(), base, &lights, target);
            candidate.note(sampled, &facts, &Costs::SOFTWARE);
        }
    }
    // what was asked for stays
    let is_free = base.sampling == Sampling::Pixels;
    all.retain(|candidate| !is_free || candidate.interpolated().upper <= target);
    all.sort_by(|a, b| a.predicted_ms.total_cmp(&b.predicted_ms));
    Ok(())
}
