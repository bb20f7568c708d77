//! What may be chosen for a picture: the planner's candidates on maps of several sizes, as options of a technique.

use gpu_backend::planner::{self, Costs, Facts};
use gpu_backend::{Criterion, Tessellation as GpuTessellation};
use hybrid_march::{Adaptive, Sampling};
use scene::Bvh;
use shadowmap::MapSurface as Surface;

use super::{Device, Estimate, Sampled, Wish, facts_of, lights_of};
use crate::airlight_gpu;
use crate::maps::{DEFAULT_SIDE, MapOptions, MapSurface};
use crate::scene_args::Setup;
use crate::technique::{self, Options, Technique, Tessellation, VisibilitySource};

/// Sides of the maps that may be drawn.
pub(crate) const SIDES: [u32; 5] = [256, 512, 1024, 2048, 4096];

/// A technique with its options, and what the planner says of it.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) technique: Technique,
    pub(crate) options: Options,
    /// Units: ms.
    pub(crate) predicted_ms: f64,
    /// Error that it usually has against its map; what it reads more than that is the pilot's to find.
    pub(crate) usual_error: f64,
    /// Why, for each light.
    pub(crate) reasons: Vec<String>,
    /// As the planner knows it.
    found: planner::Candidate,
    /// What is known of its sampling, where that was measured.
    sampled: Option<Sampled>,
}

impl Candidate {
    /// The sampling, where few rays are traced.
    pub(crate) fn adaptive(&self) -> Option<Adaptive> {
        self.technique.sampling(self.options.sampling).adaptive().copied()
    }

    /// What interpolation between rays errs by: as much as it may, where that was not measured, and no more where it was.
    pub(crate) fn interpolated(&self) -> Estimate {
        let allowed = self.adaptive().map_or(0.0, |adaptive| f64::from(adaptive.target_error));
        let found = self.sampled.map_or(Estimate { found: allowed, upper: allowed }, |sampled| sampled.error);
        Estimate { found: found.found, upper: found.upper.min(allowed) }
    }

    /// Share of the view rays that are traced: all, where fewer were not measured.
    pub(crate) fn traced(&self) -> f64 {
        self.sampled.map_or(1.0, |sampled| sampled.traced)
    }

    /// Whether another is the same but for how fine its map is and how many its rays or steps are.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let tessellation = |candidate: &Self| {
            (candidate.technique == Technique::LightVolume).then_some(candidate.options.tessellation)
        };
        self.technique == other.technique
            && self.options.map.surface == other.options.map.surface
            && self.options.visibility == other.options.visibility
            && self.adaptive().is_some() == other.adaptive().is_some()
            && tessellation(self) == tessellation(other)
    }

    /// Takes into account what was measured of its sampling; `facts` are those of its map.
    pub(crate) fn note(&mut self, sampled: Sampled, facts: &Facts<'_>, costs: &Costs) {
        self.predicted_ms = costs.predict_traced(facts, &self.found, sampled.traced);
        self.sampled = Some(sampled);
    }
}

/// All that a wish leaves, cheapest first.
pub(crate) fn candidates(
    setup: &Setup,
    bvh: &Bvh,
    base: &Options,
    wish: &Wish,
    device: Device,
    target_error: f64,
    costs: &Costs,
) -> Vec<Candidate> {
    let sides: Vec<u32> = wish.map_side.map_or(SIDES.to_vec(), |side| vec![side]);
    let mut all: Vec<Candidate> = Vec::new();
    for (index, &side) in sides.iter().enumerate() {
        let lights = lights_of(setup, bvh, base, side);
        let facts = facts_of(setup, bvh, base, &lights, target_error);
        for found in planner::candidates(&facts, None) {
            // without a map its side is all the same
            if found.rays && index > 0 {
                continue;
            }
            let Some((technique, options)) = options_of(&found, side, base, wish) else { continue };
            let fits = options.map.check(setup).is_ok()
                && technique::check(setup, technique, "").is_ok()
                && (device == Device::Cpu || airlight_gpu::lacks(setup, technique).is_none());
            if !fits {
                continue;
            }
            let predicted_ms = costs.predict(&facts, &found);
            let usual_error = planner::usual_error(&facts, &found);
            let reasons = lights.iter().map(|light| planner::reason(&facts, light, &found)).collect();
            all.push(Candidate {
                technique,
                options,
                predicted_ms,
                usual_error,
                reasons,
                found,
                sampled: None,
            });
        }
    }
    all.sort_by(|a, b| a.predicted_ms.total_cmp(&b.predicted_ms));
    all
}

/// The options of a candidate on a map of a side; `None` for what the wish leaves out.
pub(crate) fn options_of(
    found: &planner::Candidate,
    side: u32,
    base: &Options,
    wish: &Wish,
) -> Option<(Technique, Options)> {
    use gpu_backend::Technique as Gpu;
    let visibility = if found.rays { VisibilitySource::Bvh } else { VisibilitySource::Map };
    let map = |surface| MapOptions { side, surface };
    // what was asked for stays
    let sampling = match (base.sampling, found.sampling) {
        (Sampling::Pixels, wanted) => wanted,
        (_, Sampling::Pixels) => base.sampling,
        _ => return None,
    };
    let with = |surface, samples| Options { samples, sampling, visibility, map: map(surface), ..*base };
    let (technique, options) = match found.technique {
        Gpu::ExactShadowMap { surface } => {
            let surface = if surface == Surface::Linear { MapSurface::Linear } else { MapSurface::Step };
            (Technique::ExactShadowMap, with(surface, None))
        }
        Gpu::BruteForce { samples, .. } => (Technique::BruteForce, with(MapSurface::Step, Some(samples))),
        Gpu::Hybrid(hybrid) => (Technique::Hybrid, with(MapSurface::Step, Some(hybrid.samples))),
        Gpu::LightVolume { tessellation, .. } => {
            let tessellation = match tessellation {
                GpuTessellation::Adaptive { threshold, .. } => {
                    Tessellation::Adaptive { criterion: Criterion::Distance, threshold: Some(threshold) }
                }
                _ => Tessellation::Static { indexed: true },
            };
            let tessellation = if wish.tessellated { base.tessellation } else { tessellation };
            (Technique::LightVolume, Options { tessellation, ..with(MapSurface::Linear, None) })
        }
        Gpu::Froxels(_) => return None,
    };
    let marches = matches!(technique, Technique::BruteForce | Technique::Hybrid);
    let mut options = options;
    if marches {
        options.samples = wish.samples.or(options.samples);
        options.map.surface = wish.surface.unwrap_or(options.map.surface);
    }
    let is_wanted = wish.technique.is_none_or(|wanted| wanted == technique)
        && wish.surface.is_none_or(|surface| surface == options.map.surface)
        && wish.visibility.is_none_or(|wanted| !marches || wanted == visibility);
    // a map that nobody reads is none to be drawn
    if found.rays {
        options.map.side = wish.map_side.unwrap_or(DEFAULT_SIDE);
    }
    is_wanted.then_some((technique, options))
}

/// The planner's name for a technique with its options, in a scene with this diagonal (m); `None` for what it does not
/// choose.
pub(crate) fn candidate_of(
    technique: Technique,
    options: &Options,
    diagonal: f32,
) -> Option<planner::Candidate> {
    use gpu_backend::Technique as Gpu;
    let sampling = technique.sampling(options.sampling);
    if sampling.scale() > 1 {
        return None;
    }
    let rays = options.visibility == VisibilitySource::Bvh;
    let samples = options.samples.unwrap_or(technique.default_samples());
    let lookup = gpu_backend::Lookup::Nearest;
    let (technique, rays) = match technique {
        Technique::ExactShadowMap => (Gpu::ExactShadowMap { surface: options.map.surface.into() }, false),
        Technique::BruteForce => (Gpu::BruteForce { samples, lookup }, rays),
        Technique::Hybrid => {
            let lit_samples = options.hybrid.lit_samples(samples);
            (Gpu::Hybrid(gpu_backend::Hybrid { samples, lit_samples, ..Default::default() }), rays)
        }
        Technique::LightVolume => {
            let tessellation = match options.tessellation.of_scene(diagonal) {
                lightvolume::Tessellation::Adaptive { criterion, threshold } => {
                    let most_leaves = gpu_backend::DEFAULT_MOST_LEAVES;
                    GpuTessellation::Adaptive { criterion, threshold, most_leaves }
                }
                lightvolume::Tessellation::Static => GpuTessellation::IndexedGrid,
                lightvolume::Tessellation::Delaunay { .. } => return None,
            };
            (Gpu::LightVolume { tessellation, kept: options.kept }, false)
        }
        Technique::Exact | Technique::Froxel | Technique::SharedGrid => return None,
    };
    Some(planner::Candidate { technique, rays, sampling })
}
