//! The choice among the candidates, and why.

use froxel_grid::Froxels;

use super::{Candidate, Costs, Facts, LightFacts, ShadowFacts, candidates, usual_error};
use crate::{MAX_LIGHTS, Sampling, Technique};

/// What a frame is made with.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// How airlight with shadows is computed, for all lights of the frame.
    pub technique: Technique,
    /// Whether shadows are asked of a hierarchy instead of a map.
    pub rays: bool,
    /// For which view rays airlight is computed.
    pub sampling: Sampling,
    /// Why, for each light in order.
    pub reasons: Vec<String>,
    /// Predicted time of the frame's fog; units: ms.
    pub predicted_ms: f64,
    /// Predicted error as a share of what the shadows change, against the map where one is read.
    pub predicted_error: f64,
    /// The error that was asked for.
    pub target_error: f64,
}

impl Choice {
    /// Whether the predicted error is one that was asked for; what comes nearest is chosen where nothing is.
    pub fn meets_target(&self) -> bool {
        self.predicted_error <= self.target_error
    }
}

/// Chooses by the errors that techniques usually have.
pub fn choose(facts: &Facts<'_>, froxels: Option<Froxels>, costs: &Costs) -> Choice {
    choose_by(facts, froxels, costs, |candidate| usual_error(facts, candidate))
}

/// Chooses by errors that `error_of` knows or measures: it is asked in the order of predicted cost until it accepts.
pub fn choose_by(
    facts: &Facts<'_>,
    froxels: Option<Froxels>,
    costs: &Costs,
    mut error_of: impl FnMut(&Candidate) -> f64,
) -> Choice {
    let mut all: Vec<(f64, Candidate)> = candidates(facts, froxels)
        .into_iter()
        .map(|candidate| (costs.predict(facts, &candidate), candidate))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let target = f64::from(facts.target_error);
    let mut nearest: Option<(f64, f64, Candidate)> = None;
    for (ms, candidate) in all {
        let error = error_of(&candidate);
        if nearest.is_none_or(|(least, ..)| error < least) {
            nearest = Some((error, ms, candidate));
        }
        if error <= target {
            break;
        }
    }
    // a march is always among them
    let (error, ms, candidate) = nearest.unwrap_or((f64::INFINITY, f64::NAN, MARCH_OF_NOTHING));
    Choice {
        technique: candidate.technique,
        rays: candidate.rays,
        sampling: candidate.sampling,
        reasons: facts.lights.iter().map(|light| reason(facts, light, &candidate)).collect(),
        predicted_ms: ms,
        predicted_error: error,
        target_error: target,
    }
}

const MARCH_OF_NOTHING: Candidate = Candidate {
    technique: Technique::BruteForce { samples: 1, lookup: crate::Lookup::Nearest },
    rays: false,
    sampling: Sampling::Pixels,
};

/// Why a light is treated as it is.
pub fn reason(facts: &Facts<'_>, light: &LightFacts, candidate: &Candidate) -> String {
    let Facts { medium, views, target_error, .. } = facts;
    let closed = medium.is_closed(light.kind);
    let kind = light.kind.name();
    let texture = if light.textured { "textured " } else { "" };
    let name = format!("{texture}{kind} light");
    let within = format!("within the target of {} %", 100.0 * target_error);
    let plain = closed && !light.textured && light.shadows == ShadowFacts::None;
    let why = match candidate.technique {
        Technique::Froxels(_) if *views > 1 => format!("{views} views share a grid of shadows"),
        Technique::Froxels(_) if medium.heterogeneous => {
            format!("the medium varies, and froxels are {within}")
        }
        Technique::Froxels(_) if facts.lights.len() > MAX_LIGHTS => {
            format!("more than {MAX_LIGHTS} lights fit froxels alone")
        }
        Technique::Froxels(_) => format!("froxels are the cheapest {within}"),
        _ if plain => "no occluder, one closed form a ray".to_owned(),
        Technique::ExactShadowMap { .. } => format!("the exact walk over its map is the cheapest {within}"),
        Technique::LightVolume { .. } => {
            format!("the surface around what it reaches is the cheapest {within}")
        }
        Technique::Hybrid(hybrid) => {
            format!("{} steps between its shadow's faces are the cheapest {within}", hybrid.samples)
        }
        Technique::BruteForce { samples, .. } if !closed => {
            format!("the medium has no closed form along its rays: a march of {samples} steps is {within}")
        }
        Technique::BruteForce { samples, .. } => {
            format!("a march of {samples} steps is the cheapest {within}")
        }
    };
    let few = if candidate.sampling.adaptive().is_some() { ", where airlight changes" } else { "" };
    format!("{name}: {why}{few}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::{LightKind, MapFacts, MediumFacts};

    fn light(kind: LightKind, shadows: ShadowFacts) -> LightFacts {
        LightFacts { kind, textured: false, shadows }
    }

    fn mapped(side: u32) -> ShadowFacts {
        ShadowFacts::Map(MapFacts { side, changed: true })
    }

    fn facts(lights: &[LightFacts], target_error: f32) -> Facts<'_> {
        Facts {
            lights,
            medium: MediumFacts::default(),
            views: 1,
            pixels: 512 * 512,
            triangles: 100_000,
            diagonal: 10.0,
            casts_rays: false,
            target_error,
        }
    }

    fn choice(facts: &Facts<'_>) -> Choice {
        choose(facts, Some(Froxels::new(10.0)), &Costs::SOFTWARE)
    }

    #[test]
    fn no_occluder_is_a_closed_form() {
        for kind in LightKind::ALL {
            let lights = [light(kind, ShadowFacts::None)];
            let choice = choice(&facts(&lights, 1e-4));
            assert!(matches!(choice.technique, Technique::ExactShadowMap { .. }), "{choice:?}");
            assert!(choice.meets_target() && choice.reasons[0].contains("no occluder"), "{choice:?}");
        }
    }

    #[test]
    fn smaller_targets_cost_more_and_are_met() {
        for kind in LightKind::ALL {
            let lights = [light(kind, mapped(512))];
            let choices = [0.2, 0.05, 0.01, 0.002, 1e-4].map(|target| choice(&facts(&lights, target)));
            assert!(choices.iter().all(Choice::meets_target), "{choices:?}");
            assert!(choices.is_sorted_by(|a, b| a.predicted_ms <= b.predicted_ms), "{choices:?}");
            assert!(matches!(choices[4].technique, Technique::ExactShadowMap { .. }), "{choices:?}");
        }
        let lights = [light(LightKind::Spot, mapped(512))];
        let impossible = choice(&facts(&lights, 1e-9));
        assert!(!impossible.meets_target() && impossible.predicted_error > 1e-9, "{impossible:?}");
    }

    #[test]
    fn a_medium_that_varies_is_marched_or_filled_with_froxels() {
        let lights = [light(LightKind::Point, mapped(512)), light(LightKind::Spot, ShadowFacts::None)];
        let medium = MediumFacts { heterogeneous: true, ..MediumFacts::default() };
        let fine = choice(&Facts { medium, ..facts(&lights, 0.01) });
        assert!(matches!(fine.technique, Technique::BruteForce { .. }) && !fine.rays, "{fine:?}");
        assert_eq!(fine.reasons.len(), 2);
        // rays cost more than lookups, and froxels have fewer of them
        let lights = [light(LightKind::Point, ShadowFacts::Rays)];
        let coarse = choice(&Facts { medium, casts_rays: true, ..facts(&lights, 0.1) });
        assert!(matches!(coarse.technique, Technique::Froxels(_)), "{coarse:?}");
        assert!(coarse.reasons[0].contains("froxels"), "{coarse:?}");
    }

    #[test]
    fn casters_without_a_map_are_asked_by_rays() {
        let lights = [light(LightKind::Point, ShadowFacts::Rays)];
        let choice = choice(&Facts { casts_rays: true, ..facts(&lights, 0.05) });
        assert!(choice.rays && choice.meets_target(), "{choice:?}");
    }

    #[test]
    fn a_measured_error_overrules_the_usual_one() {
        let lights = [light(LightKind::Spot, mapped(512))];
        let facts = facts(&lights, 0.05);
        let mut asked = Vec::new();
        let choice = choose_by(&facts, None, &Costs::SOFTWARE, |candidate| {
            asked.push(Costs::SOFTWARE.predict(&facts, candidate));
            if matches!(candidate.technique, Technique::ExactShadowMap { .. }) { 0.001 } else { 0.5 }
        });
        assert!(matches!(choice.technique, Technique::ExactShadowMap { .. }), "{choice:?}");
        assert!(asked.is_sorted() && asked.last() == Some(&choice.predicted_ms), "{asked:?}");
    }

    #[test]
    fn one_frame_tells_how_fast_a_device_is() {
        let lights = [light(LightKind::Point, mapped(512))];
        let facts = facts(&lights, 0.01);
        let candidate = candidates(&facts, None)[0];
        let usual = Costs::SOFTWARE.predict(&facts, &candidate);
        let fast = Costs::SOFTWARE.scaled(usual, 0.01 * usual);
        assert!((fast.predict(&facts, &candidate) - 0.01 * usual).abs() < 1e-9 * usual);
        assert_eq!(fast.scaled(0.0, 1.0), fast, "a frame of nothing tells nothing");
    }
}
