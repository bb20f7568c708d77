//! The techniques by name: what each takes, and what a picture is to show.

use clap::ValueEnum;
use ground_truth::Reference;
use scene::Refusal;

use crate::failure::{Failure, Outcome};
use crate::maps::MapOptions;
use crate::scene_args::Setup;

/// Steps where a march is given none.
const DEFAULT_SAMPLES: u32 = 128;

/// `--technique`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Technique {
    /// Analytic shadows and f64 integration: the reference.
    Exact,
    /// Exact with respect to a shadow map.
    ExactShadowMap,
    /// A march that asks for visibility at every step.
    BruteForce,
    /// Shadow volumes and marching (Wyman and Ramsey).
    Hybrid,
    /// Polygonal light volume (Billeter et al.).
    LightVolume,
    /// Froxels, a shadow ray each (Hillaire).
    Froxel,
    /// Froxels and the shared shadow grid.
    SharedGrid,
}

/// `--visibility`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum VisibilitySource {
    /// Shadow rays.
    #[default]
    Bvh,
    /// A shadow map.
    Map,
}

impl Technique {
    /// The flag's value.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Whether it reads shadow maps; `visibility` is what a march asks.
    pub(crate) fn reads_maps(self, visibility: VisibilitySource) -> bool {
        match self {
            Self::ExactShadowMap => true,
            Self::BruteForce => visibility == VisibilitySource::Map,
            _ => false,
        }
    }

    /// Whether it has a use for a flag of `render`; `visibility` is what a march asks.
    pub(crate) fn uses(self, flag: &str, visibility: VisibilitySource) -> bool {
        match flag {
            "--samples" | "--visibility" => self == Self::BruteForce,
            "--shadow-map" | "--map-surface" => self.reads_maps(visibility),
            _ => false,
        }
    }
}

/// What a picture shows, beside its scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    pub(crate) size: (u32, u32),
    pub(crate) airlight_only: bool,
    pub(crate) shadows_in_medium: bool,
    pub(crate) max_distance: f64,
    /// Steps along a ray for each light, for techniques that march.
    pub(crate) samples: u32,
    /// What techniques that march ask.
    pub(crate) visibility: VisibilitySource,
    /// For techniques that read shadow maps.
    pub(crate) map: MapOptions,
}

impl Options {
    /// The defaults of `render` for a picture of `size` (width, height).
    pub(crate) fn new(size: (u32, u32)) -> Self {
        Self {
            size,
            airlight_only: false,
            shadows_in_medium: true,
            max_distance: f64::INFINITY,
            samples: DEFAULT_SAMPLES,
            visibility: VisibilitySource::default(),
            map: MapOptions::default(),
        }
    }
}

/// Fails if this version does not have the technique, or the technique cannot take the medium.
///
/// `flag` is what asked for it.
pub(crate) fn check(setup: &Setup, technique: Technique, flag: &str) -> Outcome {
    match technique {
        Technique::Exact => Reference::check(&setup.medium).map_err(|refusal| refused(refusal, flag)),
        // the same integrals over other pieces, by another name
        Technique::ExactShadowMap => Reference::check(&setup.medium)
            .map_err(|refusal| refused(Refusal { technique: "exact-shadow-map", ..refusal }, flag)),
        Technique::BruteForce => Ok(()),
        other => Err(Failure::input(format!(
            "{flag} {}: not in this version, which has exact, exact-shadow-map and brute-force",
            other.name()
        ))),
    }
}

fn refused(refusal: Refusal, flag: &str) -> Failure {
    Failure::input(format!("{flag}: {refusal}"))
}

/// What the scene needs: the exact reference, unless its medium has no analytic integral.
pub(crate) fn choose(setup: &Setup) -> (Technique, &'static str) {
    if setup.medium.is_homogeneous() {
        (Technique::Exact, "homogeneous medium: exact shadows and integrals on the CPU")
    } else {
        (Technique::BruteForce, "a medium of varying density or with emission has no analytic integral")
    }
}
