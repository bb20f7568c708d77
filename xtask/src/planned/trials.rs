//! Which candidates a pilot need not try, by what the trials before found.

use super::Pilot;
use super::candidates::Candidate;
use crate::failure::Outcome;
use crate::maps::MapOptions;
use crate::technique::{self, Options, Technique, VisibilitySource};

/// Candidates that a pilot tries at most.
const MOST_TRIALS: usize = 32;

/// A candidate that is usually so many times above the target is not tried.
const HOPELESS: f64 = 32.0;

/// How much better a march may be than its error's fall by the number of its steps.
const LEAST_GAIN: f64 = 1.5;

/// What the trials so far say of those that are left.
#[derive(Debug, Default)]
pub(super) struct Trials {
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
    pub(super) fn allow(
        &mut self,
        pilot: &mut Pilot<'_>,
        candidate: &Candidate,
        target: f64,
    ) -> Outcome<bool> {
        let Candidate { technique, options, .. } = candidate;
        let target = (target * target - candidate.interpolated().upper.powi(2)).max(0.0).sqrt();
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
    pub(super) fn note(&mut self, candidate: &Candidate, error: f64) {
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
