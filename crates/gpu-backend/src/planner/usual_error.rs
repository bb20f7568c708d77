//! The errors that techniques usually have, for those who cannot measure them on their scene.

use super::{Candidate, Facts, LightFacts, ShadowFacts};
use crate::{Technique, Tessellation};

/// Error of a walk over a map in `f32`.
const WALK: f64 = 1e-5;

/// The same of what a quadtree leaves out.
const TREE: f64 = 2e-3;

/// Error of froxels of 8 × 8 pixels and 128 slices.
const FROXELS: f64 = 0.1;

/// Error of a march times its steps, by kind of light: nine in ten measured scenes are below.
const MARCH: [f64; 3] = [2.5, 1.7, 1.9];

/// The same between faces.
const HYBRID: [f64; 3] = [1.2, 0.45, 1.5];

/// The same of marches through a medium without closed form, or under a picture.
const VARYING_MARCH: f64 = 10.0;
const VARYING_HYBRID: f64 = 0.6;

/// The error of a candidate as a share of what the shadows change, against the map where one is read: what nine in ten
/// scenes are below, measured by `cargo xtask repro pareto`. Interpolation between rays counts as all that it is allowed.
pub fn usual_error(facts: &Facts<'_>, candidate: &Candidate) -> f64 {
    let of_light = |light: &LightFacts| error_of_light(facts, light, candidate);
    let own = facts.lights.iter().map(of_light).fold(0.0, f64::max);
    let between = candidate.sampling.adaptive().map_or(0.0, |adaptive| f64::from(adaptive.target_error));
    own.hypot(between)
}

fn error_of_light(facts: &Facts<'_>, light: &LightFacts, candidate: &Candidate) -> f64 {
    let closed = facts.medium.is_closed(light.kind) && !light.textured;
    let by_kind = |table: [f64; 3]| table[light.kind as usize];
    match candidate.technique {
        Technique::Froxels(_) => FROXELS,
        _ if light.shadows == ShadowFacts::None && closed => 0.0,
        Technique::ExactShadowMap { .. } => WALK,
        Technique::LightVolume { tessellation: Tessellation::Adaptive { .. }, .. } => TREE,
        Technique::LightVolume { .. } => 5.0 * WALK,
        Technique::BruteForce { samples, .. } => {
            let varying = if closed { 0.0 } else { VARYING_MARCH };
            by_kind(MARCH).max(varying) / f64::from(samples)
        }
        Technique::Hybrid(hybrid) => {
            let varying = if closed { 0.0 } else { VARYING_HYBRID };
            by_kind(HYBRID).max(varying) / f64::from(hybrid.samples)
        }
    }
}
