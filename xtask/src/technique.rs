//! The techniques by name: what each takes, and what a picture is to show.

use clap::ValueEnum;
use gpu_backend::AirlightForm;
use ground_truth::Reference;
use hybrid_march::{Hybrid, Placement};
use scene::{AirlightModel, Refusal};

use crate::failure::{Failure, Outcome};
use crate::maps::MapOptions;
use crate::scene_args::Setup;

/// Steps where a march over the light's whole extent is given none.
const DEFAULT_SAMPLES: u32 = 128;

/// The same between the faces of shadow volumes.
const DEFAULT_HYBRID_SAMPLES: u32 = 48;

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
            Self::BruteForce | Self::Hybrid => visibility == VisibilitySource::Map,
            _ => false,
        }
    }

    /// Steps along a ray where none are given.
    pub(crate) fn default_samples(self) -> u32 {
        if self == Self::Hybrid { DEFAULT_HYBRID_SAMPLES } else { DEFAULT_SAMPLES }
    }

    /// Whether its airlight can be computed for blocks of pixels.
    pub(crate) fn takes_scale(self) -> bool {
        matches!(self, Self::BruteForce | Self::Hybrid)
    }

    /// Whether it has a use for a flag of `render`; `visibility` is what a march asks.
    pub(crate) fn uses(self, flag: &str, visibility: VisibilitySource) -> bool {
        match flag {
            "--samples" | "--visibility" => matches!(self, Self::BruteForce | Self::Hybrid),
            "--scattering-scale" => self.takes_scale(),
            "--shadow-map" | "--map-surface" => self.reads_maps(visibility),
            _ => false,
        }
    }
}

/// What shadow volumes are extruded from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) enum Extruded {
    /// All triangles.
    #[default]
    Scene,
    /// The box around them.
    BoundingBox,
    /// A coarser mesh, with so many cells along the longest side.
    Coarse(u32),
    /// What reaches within this distance of the viewer, also in the shadow map; units: m.
    NearViewer(f32),
    /// Only what reaches within this distance of the viewer; the rest is looked up everywhere, as a texture would be;
    /// units: m.
    RestAsTexture(f32),
}

/// How the hybrid finds and refines its bounds, and how it reads a light's picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HybridOptions {
    /// What shadow volumes are extruded from.
    pub(crate) extruded: Extruded,
    /// For how many pixels a side faces are kept; 1 for each pixel by itself.
    pub(crate) tile: u32,
    /// Bisections of each boundary that is found.
    pub(crate) refine: u32,
    /// Steps in light before and behind the faces, for spots that have no closed form along a ray; half of the steps
    /// between them without.
    pub(crate) lit_samples: Option<u32>,
    /// Where the steps of such spots lie; by their model without.
    pub(crate) placement: Option<Placement>,
    /// Blur of a light's picture in texels before its mips are made; without, it is read at each step's middle.
    pub(crate) mips: Option<f32>,
    /// How airlight of lit pieces is computed on a GPU.
    pub(crate) form: AirlightForm,
}

impl Default for HybridOptions {
    fn default() -> Self {
        let (extruded, tile, refine) = (Extruded::Scene, 16, 6);
        Self {
            extruded,
            tile,
            refine,
            lit_samples: None,
            placement: None,
            mips: Some(0.0),
            form: AirlightForm::Interval,
        }
    }
}

impl HybridOptions {
    /// Where steps lie: of equal angle, but for the model without 1/d².
    pub(crate) fn placement(&self, model: AirlightModel) -> Placement {
        self.placement.unwrap_or(match model {
            AirlightModel::Sun => Placement::EqualAngle,
            AirlightModel::HoffmanPreetham => Placement::EqualDistance,
        })
    }

    /// Steps of each segment outside of the faces, for so many between them.
    pub(crate) fn lit_samples(&self, samples: u32) -> u32 {
        self.lit_samples.unwrap_or(samples.div_ceil(2))
    }
}

/// What a picture shows, beside its scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    pub(crate) size: (u32, u32),
    pub(crate) airlight_only: bool,
    pub(crate) shadows_in_medium: bool,
    pub(crate) max_distance: f64,
    /// Steps along a ray for each light, for techniques that march; their own number without.
    pub(crate) samples: Option<u32>,
    /// Pixels along the side of the blocks for which airlight is computed.
    pub(crate) scattering_scale: u32,
    /// Whether pixels at depth edges are computed anew there.
    pub(crate) anew_at_edges: bool,
    /// How the hybrid finds and refines its bounds.
    pub(crate) hybrid: HybridOptions,
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
            samples: None,
            scattering_scale: 1,
            anew_at_edges: false,
            hybrid: HybridOptions::default(),
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
        Technique::Hybrid => {
            Hybrid::check(&setup.medium, &setup.lights, setup.model).map_err(|refusal| refused(refusal, flag))
        }
        other => Err(Failure::input(format!(
            "{flag} {}: not in this version, which has exact, exact-shadow-map, brute-force and hybrid",
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
