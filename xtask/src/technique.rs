//! The techniques by name: what each takes, and what a picture is to show.

use clap::ValueEnum;
use froxel_grid::{FroxelError, MAX_LIGHTS};
use gpu_backend::AirlightForm;
use ground_truth::Reference;
use hybrid_march::{Hybrid, Placement, Sampling};
use lightvolume::{Criterion, LightVolumeError, SignedAirlight};
use scene::{AirlightModel, Light, Refusal};

use crate::failure::{Failure, Outcome};
use crate::maps::{MapOptions, MapSurface};
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
            Self::ExactShadowMap | Self::LightVolume => true,
            Self::BruteForce | Self::Hybrid => visibility == VisibilitySource::Map,
            _ => false,
        }
    }

    /// Steps along a ray where none are given.
    pub(crate) fn default_samples(self) -> u32 {
        if self == Self::Hybrid { DEFAULT_HYBRID_SAMPLES } else { DEFAULT_SAMPLES }
    }

    /// Whether it fills froxels, which end at a range.
    pub(crate) fn has_froxels(self) -> bool {
        matches!(self, Self::Froxel | Self::SharedGrid)
    }

    /// Whether its airlight can be computed for blocks of pixels.
    pub(crate) fn takes_scale(self) -> bool {
        matches!(self, Self::BruteForce | Self::Hybrid)
    }

    /// Whether it can leave out view rays of its own choice.
    pub(crate) fn takes_adaptive(self) -> bool {
        !self.has_froxels() && self != Self::LightVolume
    }

    /// What it makes of a way to sample: all pixels where it cannot take it.
    pub(crate) fn sampling(self, wanted: Sampling) -> Sampling {
        match wanted {
            Sampling::Blocks { .. } if !self.takes_scale() => Sampling::Pixels,
            Sampling::Adaptive(_) if !self.takes_adaptive() => Sampling::Pixels,
            other => other,
        }
    }

    /// Whether it has a use for a flag of `render`; `visibility` is what a march asks.
    pub(crate) fn uses(self, flag: &str, visibility: VisibilitySource) -> bool {
        match flag {
            "--samples" | "--visibility" => matches!(self, Self::BruteForce | Self::Hybrid),
            "--scattering-scale" => self.takes_scale(),
            "--shadow-map" => self.reads_maps(visibility),
            "--map-surface" => self.reads_maps(visibility) && self != Self::LightVolume,
            "--tessellation" => self == Self::LightVolume,
            "--voxel-size" => self == Self::SharedGrid,
            "--viewers" => self.has_froxels(),
            // froxels have no setting whose error a few rays would tell
            "--target-error" => !self.has_froxels(),
            _ => false,
        }
    }
}

/// `--tessellation`: how the surface of a light volume is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tessellation {
    /// Every cell of the map; on a GPU by indices, or with six vertices each.
    Static { indexed: bool },
    /// A quadtree.
    Adaptive {
        /// What is compared with the threshold.
        criterion: Criterion,
        /// A share of the scene's diagonal without one; units: m.
        threshold: Option<f32>,
    },
    /// Delaunay triangles of the nodes that matter most; the bound is a share of the diagonal without one; units: m.
    Delaunay { bound: Option<f32> },
}

/// Threshold of tessellations without one, as a share of the scene's diagonal.
const DEFAULT_THRESHOLD: f32 = 1e-3;

impl Default for Tessellation {
    fn default() -> Self {
        Self::Adaptive { criterion: Criterion::Distance, threshold: None }
    }
}

impl Tessellation {
    /// Fails for a light whose map it cannot cut.
    pub(crate) fn check(self, setup: &Setup) -> Outcome {
        let cube = setup.lights.iter().any(|light| matches!(light, Light::Point(_)));
        if cube && matches!(self, Self::Delaunay { .. }) {
            return Err(Failure::input(format!("--tessellation: {}", LightVolumeError::Cube)));
        }
        Ok(())
    }

    /// With the threshold that it was given, or that of a scene with this diagonal; units: m.
    pub(crate) fn of_scene(self, diagonal: f32) -> lightvolume::Tessellation {
        let usual = DEFAULT_THRESHOLD * diagonal;
        match self {
            Self::Static { .. } => lightvolume::Tessellation::Static,
            Self::Adaptive { criterion, threshold } => {
                lightvolume::Tessellation::Adaptive { criterion, threshold: threshold.unwrap_or(usual) }
            }
            Self::Delaunay { bound } => lightvolume::Tessellation::Delaunay { bound: bound.unwrap_or(usual) },
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

/// How far froxels go, how fine the grid is, and who shares it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FroxelOptions {
    /// Where the airlight of every technique ends, as that of froxels must; without, froxels end where the scene does; units: m.
    pub(crate) range: Option<f32>,
    /// Side of a voxel of the shared grid; a share of the scene's longest side without; units: m.
    pub(crate) voxel_size: Option<f32>,
    /// Pixels along the side of a froxel.
    pub(crate) tile: u32,
    /// Slices of froxels along a ray.
    pub(crate) slices: u32,
    /// Viewers whose froxels a frame fills; the picture is that of the first.
    pub(crate) viewers: u32,
}

impl Default for FroxelOptions {
    fn default() -> Self {
        Self { range: None, voxel_size: None, tile: 8, slices: 128, viewers: 1 }
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
    /// For which view rays airlight is computed, by techniques that take one by one.
    pub(crate) sampling: Sampling,
    /// How the hybrid finds and refines its bounds.
    pub(crate) hybrid: HybridOptions,
    /// How the surface of a light volume is divided.
    pub(crate) tessellation: Tessellation,
    /// Crossings of each pixel with it that are kept and sorted on a GPU; as many as pay without.
    pub(crate) kept: Option<u32>,
    /// For techniques with froxels.
    pub(crate) froxels: FroxelOptions,
    /// What techniques that march ask.
    pub(crate) visibility: VisibilitySource,
    /// For techniques that read shadow maps.
    pub(crate) map: MapOptions,
    /// Whether surfaces are lit on the CPU in any case: a GPU's shadow rays there err by some pixels at edges.
    pub(crate) surfaces_on_cpu: bool,
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
            sampling: Sampling::Pixels,
            hybrid: HybridOptions::default(),
            tessellation: Tessellation::default(),
            kept: None,
            froxels: FroxelOptions::default(),
            visibility: VisibilitySource::default(),
            map: MapOptions::default(),
            surfaces_on_cpu: false,
        }
    }
}

impl Options {
    /// As a technique reads them: a light volume encloses its map in the linear meaning.
    pub(crate) fn of(&self, technique: Technique) -> Self {
        let mut options = *self;
        if technique == Technique::LightVolume {
            options.map.surface = MapSurface::Linear;
        }
        options
    }
}

/// Fails if the technique cannot take the medium or the lights.
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
        Technique::LightVolume => SignedAirlight::<f64>::check(&setup.medium, &setup.lights, setup.model)
            .map_err(|refusal| refused(refusal, flag)),
        Technique::Froxel | Technique::SharedGrid => {
            let got = setup.lights.len();
            if got > MAX_LIGHTS {
                let error = FroxelError::TooManyLights { got, most: MAX_LIGHTS };
                return Err(Failure::input(format!("{flag} {}: {error}", technique.name())));
            }
            Ok(())
        }
    }
}

fn refused(refusal: Refusal, flag: &str) -> Failure {
    Failure::input(format!("{flag}: {refusal}"))
}
