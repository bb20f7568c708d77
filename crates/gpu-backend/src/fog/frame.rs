//! What a frame is made of: views, a medium, lights with their maps, and how airlight is computed.

use froxel_grid::Froxels;
pub use hybrid_march::{Adaptive, Placement, Sampling};
use scene::{Aabb, AirlightModel, Camera, Light, Medium};
use shadowmap::{DepthOrder, MapSurface};

use crate::{Faces, GpuBvh, ShadowMap, ShadowVolume, Tessellation};

/// Most lights of a frame, but for [`Technique::Froxels`].
pub const MAX_LIGHTS: usize = 8;

/// A frame to prepare.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// The views, one at least.
    pub views: &'a [View<'a>],
    /// The medium.
    pub medium: &'a Medium,
    /// The lights: [`MAX_LIGHTS`] at most, of froxels more.
    pub lamps: &'a [Lamp<'a>],
    /// How airlight of local lights is formed.
    pub model: AirlightModel,
    /// How shadows are found.
    pub technique: Technique,
    /// For which view rays airlight is computed.
    pub sampling: Sampling,
}

/// One view of a frame.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Where the view is taken from.
    pub camera: &'a Camera,
    /// Columns and rows; units: pixels.
    pub size: (u32, u32),
    /// Where view rays end.
    pub depth: SceneDepth<'a>,
    /// How far a ray that hits nothing is integrated; units: m; may be infinite.
    pub max_distance: f64,
}

/// Where the view rays of a view end.
#[derive(Debug, Clone, Copy)]
pub enum SceneDepth<'a> {
    /// Nowhere: there is no surface in view.
    Nothing,
    /// At these distances along the rays, row-major; units: m; infinite where a ray hits nothing.
    Distances(&'a [f32]),
    /// At what a host's renderer drew with the view's camera.
    Buffer {
        /// A depth texture of the view's size with `TEXTURE_BINDING` usage and one sample a pixel.
        texture: &'a wgpu::Texture,
        /// Which end of [0, 1] is near.
        order: DepthOrder,
        /// Near plane of the camera's matrix; units: m.
        near: f32,
        /// Far plane; units: m; may be infinite.
        far: f32,
    },
}

/// A light of a frame, and what shadows it.
#[derive(Debug, Clone, Copy)]
pub struct Lamp<'a> {
    /// The light.
    pub light: &'a Light,
    /// Its shadows; `None` where nothing casts any, which then cost nothing.
    pub shadows: Option<Shadows<'a>>,
    /// The shadow volume of its casters, for [`Technique::Hybrid`]; others do not look at it.
    pub volume: Option<&'a ShadowVolume>,
}

/// What shadows a light, with a box around all that casts shadows: a march spends no step outside of what that can
/// shadow.
#[derive(Debug, Clone, Copy)]
pub enum Shadows<'a> {
    /// The light's map.
    Map {
        /// The map.
        map: &'a ShadowMap,
        /// A box around all casters.
        casters: Aabb,
    },
    /// Shadow rays, for a march.
    Rays {
        /// The hierarchy that they go through.
        bvh: &'a GpuBvh,
        /// A box around all casters.
        casters: Aabb,
    },
}

impl<'a> Shadows<'a> {
    /// The map, if that is what shadows the light.
    pub(crate) fn map(&self) -> Option<&'a ShadowMap> {
        match self {
            Self::Map { map, .. } => Some(map),
            Self::Rays { .. } => None,
        }
    }

    /// The hierarchy, if shadow rays are cast.
    pub(crate) fn bvh(&self) -> Option<&'a GpuBvh> {
        match self {
            Self::Map { .. } => None,
            Self::Rays { bvh, .. } => Some(bvh),
        }
    }

    pub(crate) fn casters(&self) -> &Aabb {
        match self {
            Self::Map { casters, .. } | Self::Rays { casters, .. } => casters,
        }
    }
}

/// How airlight with shadows is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Technique {
    /// The exact lit pieces of each view ray against the map; no step, no sample.
    ExactShadowMap {
        /// What the map says between its texel centres.
        surface: MapSurface,
    },
    /// A march that looks the map up, or casts a shadow ray, at every step.
    BruteForce {
        /// Steps along each ray for each light.
        samples: u32,
        /// How a map is looked up.
        lookup: Lookup,
    },
    /// A march between the frontmost and the backmost face of each light's shadow volume (Wyman and Ramsey 2008).
    Hybrid(Hybrid),
    /// The crossings of view rays with the surface around what the light reaches, extruded from its map; no march
    /// (Billeter, Sintorn and Assarsson 2010).
    LightVolume {
        /// How the surface is divided into triangles.
        tessellation: Tessellation,
        /// Crossings for which there is room, in a pool of so many for each pixel: they are sorted, and airlight is a sum
        /// over lit pieces. Where the pool is full, and without one (0), it is the paper's sum of signed terms, which errs
        /// by some 10⁻⁶ of the unshadowed airlight. `None` makes room for six, 56 bytes a pixel.
        kept: Option<u32>,
    },
    /// Froxels with shadow rays of their own, or a shadow grid that all views share (Stojanovic et al. 2023). Lamps have
    /// [`Shadows::Rays`] or none; up to [`froxel_grid::MAX_LIGHTS`] fit.
    Froxels(Froxels),
}

/// How a march reads the picture of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightPicture {
    /// Its colour at each step's middle.
    Point,
    /// Its mean over each step, from a chain of smaller pictures.
    Mips {
        /// Standard deviation of a Gaussian that blurs the picture first; units: texels.
        blur: f32,
    },
}

impl LightPicture {
    /// By how much mips are blurred; `None` without mips.
    pub(crate) fn blur(self) -> Option<f32> {
        match self {
            Self::Point => None,
            Self::Mips { blur } => Some(blur),
        }
    }
}

/// How the airlight of a lit piece is computed where a light's intensity is constant along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AirlightForm {
    /// The interval form: as accurate as its numbers.
    #[default]
    Interval,
    /// The difference of two lookups in a table made for the frame (Wyman and Ramsey 2008, section 3.4), over cos γ and x
    /// as printed: wrong next to the light's direction, where it diverges. For point lights, and textured spots in Sun's
    /// model, in an isotropic medium; others take the interval form.
    FrameTable {
        /// Entries a side; 2 to 2048.
        size: u32,
    },
    /// The same over angles, without a singularity; see [`media_math::AngleTable`].
    AngleTable {
        /// Entries a side; 2 to 2048.
        size: u32,
    },
}

/// A march between shadow-volume faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hybrid {
    /// Steps between the faces of each ray for each light.
    pub samples: u32,
    /// Steps in each of the lit segments before and behind the faces, for spots whose intensity has no closed form
    /// along the ray: textured ones, and all in Hoffman and Preetham's model.
    pub lit_samples: u32,
    /// Where steps lie. Endless rays have no steps of equal length, and directional lights none of equal angle.
    pub placement: Placement,
    /// How the picture of a spot is read.
    pub picture: LightPicture,
    /// How a map is looked up.
    pub lookup: Lookup,
    /// For which pixels faces are found.
    pub faces: Faces,
    /// Further lookups that bisect each boundary found between two steps; none where lookups give shares.
    pub refine: u32,
    /// Whether the shadow volume is that of a part of the casters: shadows are then looked up in all of a spot's cone,
    /// as if the others were in its picture (section 5). Other lights cannot take it.
    pub partial: bool,
    /// How airlight is computed.
    pub form: AirlightForm,
}

impl Default for Hybrid {
    /// 48 steps, 24 in light, of equal angle; mips; faces by tiles of 16 pixels; 6 bisections.
    fn default() -> Self {
        Self {
            samples: 48,
            lit_samples: 24,
            placement: Placement::EqualAngle,
            picture: LightPicture::Mips { blur: 0.0 },
            lookup: Lookup::Nearest,
            faces: Faces::Tiles(16),
            refine: 6,
            partial: false,
            form: AirlightForm::Interval,
        }
    }
}

impl Technique {
    /// How the technique looks maps up, where it marches.
    pub(crate) fn lookup(&self) -> Option<Lookup> {
        match self {
            Self::ExactShadowMap { .. } | Self::LightVolume { .. } | Self::Froxels(_) => None,
            Self::BruteForce { lookup, .. } => Some(*lookup),
            Self::Hybrid(hybrid) => Some(hybrid.lookup),
        }
    }
}

/// How a march looks a map up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lookup {
    /// The texel that the point falls in.
    #[default]
    Nearest,
    /// Percentage-closer filtering with a kernel of 1 to [`MAX_KERNEL`](shadowmap::MAX_KERNEL) texels.
    PercentageCloser {
        /// Width of the kernel; units: texels.
        width: u32,
    },
    /// Chebyshev's bound from the map's moments.
    Variance,
    /// The surface that joins the texel centres.
    LinearSurface,
}
