//! What the planner chooses on a scene for each target: by a pilot, against the geometry and against a given map; and
//! against the map by what it knows without one.

use gpu_backend::GpuContext;
use gpu_backend::planner::{self, Costs};

use super::measure::{Arena, Measured, Setting};
use super::pareto_settings::percent;
use crate::failure::Outcome;
use crate::maps::{MapOptions, MapSurface};
use crate::planned::{self, Wish};
use crate::technique::{Options, Technique, VisibilitySource};

/// Errors that are asked for.
pub(super) const TARGETS: [f64; 3] = [0.05, 0.01, 0.002];

/// What an error is against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Metric {
    /// The geometry: the map is chosen too.
    Geometry,
    /// The map that a host has.
    Map,
}

impl Metric {
    /// Both.
    pub(super) const ALL: [Self; 2] = [Self::Geometry, Self::Map];

    /// As `data.json` calls it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Geometry => "shadow_err",
            Self::Map => "shadow_err_map",
        }
    }

    /// The error of a setting; `None` for what does not read the map (`side`) that is given.
    pub(super) fn error(self, measured: &Measured, side: u32) -> Option<f64> {
        match self {
            Self::Geometry => measured.on_geometry.shadow_err,
            Self::Map if measured.setting.options.map.side == side => measured.on_map?.shadow_err,
            Self::Map => None,
        }
    }
}

/// A choice of the planner.
pub(super) struct Pick {
    pub(super) metric: Metric,
    pub(super) target: f64,
    /// Which of the settings it is.
    pub(super) setting: usize,
    /// Units: ms.
    pub(super) predicted_ms: Option<f64>,
    pub(super) predicted_error: f64,
    /// Time that choosing took; units: ms. Nothing without a pilot.
    pub(super) pilot_ms: Option<f64>,
}

/// Asks the planner for each target, against what is in `metrics`; `side` is that of the given map. What it chooses joins
/// the settings unless it is among them.
pub(super) fn choose(
    arena: &Arena,
    side: u32,
    metrics: &[Metric],
    gpu: Option<&GpuContext>,
    settings: &mut Vec<Setting>,
) -> Outcome<Vec<Pick>> {
    let mut picks = Vec::new();
    for target in TARGETS {
        for metric in metrics {
            picks.push(by_pilot(arena, target, *metric, side, gpu, settings)?);
        }
        picks.extend(by_habit(arena, target, side, settings));
    }
    Ok(picks)
}

/// The choice of a technique and its settings, and against the geometry of its map.
fn by_pilot(
    arena: &Arena,
    target: f64,
    metric: Metric,
    side: u32,
    gpu: Option<&GpuContext>,
    settings: &mut Vec<Setting>,
) -> Outcome<Pick> {
    let wish = Wish { target_error: Some(target), ..Wish::default() };
    let surface = MapSurface::Step;
    let wish = match metric {
        Metric::Geometry => wish,
        Metric::Map => Wish {
            map_side: Some(side),
            surface: Some(surface),
            visibility: Some(VisibilitySource::Map),
            on_map: true,
            ..wish
        },
    };
    let base = Options { map: MapOptions { side, surface }, ..arena.base };
    let plan = planned::plan(&arena.setup, &arena.bvh, &base, &wish, gpu)?;
    Ok(Pick {
        metric,
        target,
        setting: join(settings, plan.technique, plan.options),
        predicted_ms: plan.predicted_ms,
        predicted_error: plan.predicted_error.map_or(f64::NAN, |error| error.found),
        pilot_ms: Some(plan.pilot_ms),
    })
}

/// The choice of a host that has its map, and neither a hierarchy nor a pilot.
fn by_habit(arena: &Arena, target: f64, side: u32, settings: &mut Vec<Setting>) -> Option<Pick> {
    let lights = planned::lights_of(&arena.setup, &arena.bvh, &arena.base, side);
    let facts = planned::facts_of(&arena.setup, &arena.bvh, &arena.base, &lights, target);
    let facts = planner::Facts { casts_rays: false, ..facts };
    let choice = planner::choose(&facts, None, &Costs::SOFTWARE);
    let chosen =
        planner::Candidate { technique: choice.technique, rays: choice.rays, sampling: choice.sampling };
    let (technique, options) = planned::options_of(&chosen, side, &arena.base, &Wish::default())?;
    Some(Pick {
        metric: Metric::Map,
        target,
        setting: join(settings, technique, options),
        predicted_ms: Some(choice.predicted_ms),
        predicted_error: choice.predicted_error,
        pilot_ms: None,
    })
}

/// The setting with these options, which is added unless there is one.
fn join(settings: &mut Vec<Setting>, technique: Technique, options: Options) -> usize {
    // what a technique does not read makes no other setting of it
    let key = |technique: Technique, options: &Options| {
        let options = options.of(technique);
        let map = technique.reads_maps(options.visibility).then_some(options.map);
        let visibility = technique.takes_scale().then_some(options.visibility);
        let samples = technique.takes_scale().then_some(options.samples);
        let tessellation = (technique == Technique::LightVolume).then_some(options.tessellation);
        let sampling = technique.sampling(options.sampling);
        // targets that differ by their rounding are the same
        let sampling = sampling
            .adaptive()
            .map_or_else(|| format!("{sampling:?}"), |a| percent(a.target_error).to_string());
        let tile = options.froxels.tile;
        format!("{technique:?} {map:?} {visibility:?} {samples:?} {tessellation:?} {sampling} {tile:?}")
    };
    let wanted = key(technique, &options);
    let same = |setting: &Setting| key(setting.technique, &setting.options) == wanted;
    settings.iter().position(same).unwrap_or_else(|| {
        let mut name = format!("{}, chosen:", technique.name());
        if let Some(samples) = options.samples.filter(|_| technique.takes_scale()) {
            name += &format!(" {samples} samples,");
        }
        if technique.reads_maps(options.visibility) {
            let map = options.of(technique).map;
            name += &format!(" {}² {}", map.side, map.surface.name());
        } else {
            name += " shadow rays";
        }
        if let Some(adaptive) = technique.sampling(options.sampling).adaptive() {
            name += &format!(", adaptive {} %", percent(adaptive.target_error));
        }
        settings.push(Setting::new(name, technique, options));
        settings.len() - 1
    })
}
