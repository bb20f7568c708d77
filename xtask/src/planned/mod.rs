//! What a picture is made with: a technique, its settings and its map, cheap enough and within the target error.
//!
//! What can be chosen, and what it costs, is known to `gpu_backend::planner`; what error it has on this scene is measured
//! by a pilot. Candidates are asked in the order of their predicted cost, and the first that is safely within the
//! target is taken. Where none is, the exact reference on the CPU is left.

mod candidates;
mod pilot;

use gpu_backend::planner::{Costs, Facts, LightFacts, MapFacts, MediumFacts, ShadowFacts};
use hybrid_march::Sampling;
use scene::Bvh;
use serde_json::{Value, json};

pub(crate) use pilot::{Estimate, Pilot};

use crate::failure::Outcome;
use crate::maps::{MapOptions, MapSurface};
use crate::scene_args::Setup;
use crate::technique::{self, Options, Technique, VisibilitySource};
pub(crate) use candidates::options_of;
use candidates::{Candidate, candidates};

/// Where no error is asked for.
pub(crate) const DEFAULT_TARGET: f64 = 0.01;

/// Candidates that a pilot tries at most.
const MOST_TRIALS: usize = 32;

/// A candidate that is usually so many times above the target is not tried.
const HOPELESS: f64 = 32.0;

/// How much better a march may be than its error's fall by the number of its steps.
const LEAST_GAIN: f64 = 1.5;

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
pub(crate) fn plan(setup: &Setup, bvh: &Bvh, base: &Options, wish: &Wish, device: Device) -> Outcome<Plan> {
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
    if free && analytic && device == Device::Cpu && base.froxels.viewers < 2 {
        let reason = "homogeneous medium: exact shadows and integrals on the CPU, whatever the target";
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
    let mut pilot = Pilot::new(setup, bvh, base)?;
    let all = candidates(setup, bvh, base, wish, device, target_error, &Costs::SOFTWARE);
    let finest = |a: &&Candidate, b: &&Candidate| a.usual_error.total_cmp(&b.usual_error);
    let last_resort = all.iter().min_by(finest).cloned();
    let mut best: Option<(Candidate, Estimate, f64)> = None;
    let mut trials = Trials::default();
    for candidate in all {
        if free && analytic && device == Device::SoftwareGpu && candidate.predicted_ms > pilot.exact_ms {
            break;
        }
        if !trials.allow(&mut pilot, &candidate, target_error)? {
            continue;
        }
        let (error, cpu_ms) = pilot.judge(candidate.technique, &candidate.options)?;
        trials.note(&candidate, error.upper);
        let error = error.with(candidate.interpolated());
        let ms = if device == Device::Cpu { cpu_ms } else { candidate.predicted_ms };
        let upper = error.upper;
        if best.as_ref().is_none_or(|(_, least, _)| upper < least.upper) {
            best = Some((candidate, error, ms));
        }
        if upper <= target_error {
            break;
        }
    }
    if best.is_none() && (!free || !analytic) {
        // the best there is of what was asked for
        if let Some(candidate) = last_resort {
            let (error, cpu_ms) = pilot.judge(candidate.technique, &candidate.options)?;
            let error = error.with(candidate.interpolated());
            let ms = if device == Device::Cpu { cpu_ms } else { candidate.predicted_ms };
            best = Some((candidate, error, ms));
        }
    }
    let met = best.as_ref().is_some_and(|(_, error, _)| error.upper <= target_error);
    match (best, wish.technique) {
        (Some((candidate, error, ms)), _) if met || !free || !analytic => Ok(Plan {
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
            let reason = "nothing that a GPU does faster is within the target: exact on the CPU";
            Ok(exact(reason, pilot.ms(), Some(pilot.exact_ms)))
        }
    }
}

/// What the trials so far say of those that are left.
#[derive(Debug, Default)]
struct Trials {
    count: usize,
    /// Maps, and the error of what is exact on them: what reads one cannot be better.
    maps: Vec<(MapOptions, f64)>,
    /// The last trial of each march.
    marches: Vec<Marched>,
}

/// A march that was tried.
#[derive(Debug, Clone, Copy)]
struct Marched {
    technique: Technique,
    visibility: VisibilitySource,
    steps: u32,
    /// What is left of its error without that of its map.
    error: f64,
}

impl Marched {
    fn is_like(&self, candidate: &Candidate) -> bool {
        self.technique == candidate.technique && self.visibility == candidate.options.visibility
    }

    /// Whether so many steps are too few as well, be the map as fine as it may.
    fn rules_out(&self, steps: u32, target: f64) -> bool {
        if steps == self.steps {
            return self.error > target;
        }
        self.error * f64::from(self.steps) > LEAST_GAIN * target * f64::from(steps)
    }
}

impl Trials {
    /// Whether a candidate may be within the target.
    fn allow(&mut self, pilot: &mut Pilot<'_>, candidate: &Candidate, target: f64) -> Outcome<bool> {
        let Candidate { technique, options, .. } = candidate;
        let target = (target * target - candidate.interpolated().powi(2)).max(0.0).sqrt();
        if self.count >= MOST_TRIALS || candidate.usual_error > HOPELESS * target {
            return Ok(false);
        }
        if let Some(steps) = options.samples {
            let tried = self.marches.iter().find(|tried| tried.is_like(candidate));
            if tried.is_some_and(|tried| tried.rules_out(steps, target)) {
                return Ok(false);
            }
        }
        if *technique == Technique::ExactShadowMap || !technique.reads_maps(options.visibility) {
            return Ok(true);
        }
        let map = options.of(*technique).map;
        if self.floor(candidate).is_none() {
            let exact = technique::check(pilot.setup(), Technique::ExactShadowMap, "").is_ok();
            let options = Options { map, ..*options };
            let floor = if exact { pilot.judge(Technique::ExactShadowMap, &options)?.0.found } else { 0.0 };
            self.maps.push((map, floor));
        }
        Ok(self.floor(candidate).is_some_and(|floor| floor <= target))
    }

    /// The error of what is exact on a candidate's map, where it is known.
    fn floor(&self, candidate: &Candidate) -> Option<f64> {
        let map = candidate.options.of(candidate.technique).map;
        self.maps.iter().find(|(known, _)| *known == map).map(|(_, floor)| *floor)
    }

    /// Takes an error into account that was found.
    fn note(&mut self, candidate: &Candidate, error: f64) {
        let Candidate { technique, options, .. } = candidate;
        self.count += 1;
        if let Some(steps) = options.samples {
            let reads_map = technique.reads_maps(options.visibility);
            let floor = self.floor(candidate).filter(|_| reads_map).unwrap_or(0.0);
            let error = (error * error - floor * floor).max(0.0).sqrt();
            self.marches.retain(|tried| !tried.is_like(candidate));
            let (technique, visibility) = (*technique, options.visibility);
            self.marches.push(Marched { technique, visibility, steps, error });
        }
    }
}
