//! What is known of a frame before it is made.

use scene::{Light, Medium};

/// The kinds of light, by what their airlight and their maps cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LightKind {
    /// A lamp that shines all around; its map is a cube.
    Point,
    /// A cone.
    Spot,
    /// A sun.
    Directional,
}

impl LightKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Point, Self::Spot, Self::Directional];

    /// The kind of a light.
    pub fn of(light: &Light) -> Self {
        match light {
            Light::Point(_) => Self::Point,
            Light::Spot(_) => Self::Spot,
            Light::Directional(_) => Self::Directional,
        }
    }

    /// Name in reasons and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Spot => "spot",
            Self::Directional => "directional",
        }
    }

    /// Faces of its map.
    pub fn faces(self) -> u32 {
        if self == Self::Point { 6 } else { 1 }
    }
}

/// A shadow map that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapFacts {
    /// Texels along the side of a face.
    pub side: u32,
    /// Whether it was drawn anew for this frame: what is made from it then is as well.
    pub changed: bool,
}

/// What shadows a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowFacts {
    /// Nothing: no occluder.
    None,
    /// A map that the host has.
    Map(MapFacts),
    /// Casters without a map; shadow rays alone, if the frame has a hierarchy for them.
    Rays,
}

/// A light of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightFacts {
    /// Its kind.
    pub kind: LightKind,
    /// Whether a picture colours it.
    pub textured: bool,
    /// What shadows it.
    pub shadows: ShadowFacts,
}

impl LightFacts {
    /// What is known of a light, with what shadows it.
    pub fn of(light: &Light, shadows: ShadowFacts) -> Self {
        let textured = matches!(light, Light::Spot(spot) if spot.texture.is_some());
        Self { kind: LightKind::of(light), textured, shadows }
    }

    /// The map, if that is what shadows it.
    pub fn map(&self) -> Option<MapFacts> {
        match self.shadows {
            ShadowFacts::Map(map) => Some(map),
            ShadowFacts::None | ShadowFacts::Rays => None,
        }
    }
}

/// What a medium asks for; the default is a grey, homogeneous one without end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MediumFacts {
    /// Its density varies, or it glows: no closed form along a ray.
    pub heterogeneous: bool,
    /// It fills a box.
    pub bounded: bool,
    /// Its channels are attenuated differently, so that all three are integrated.
    pub coloured: bool,
    /// Airlight of local lights is formed without 1/d² (Hoffman and Preetham).
    pub without_falloff: bool,
}

impl MediumFacts {
    /// What is known of a medium.
    pub fn of(medium: &Medium, model: scene::AirlightModel) -> Self {
        let sigma_t = medium.coefficients.sigma_t();
        Self {
            heterogeneous: !medium.is_homogeneous(),
            bounded: medium.bounds.is_some(),
            coloured: sigma_t[0] != sigma_t[1] || sigma_t[1] != sigma_t[2],
            without_falloff: model == scene::AirlightModel::HoffmanPreetham,
        }
    }

    /// Whether airlight between boundaries has a closed form for a light of a kind.
    pub(super) fn is_closed(&self, kind: LightKind) -> bool {
        let local = kind != LightKind::Directional;
        let varies = self.heterogeneous || self.bounded || (local && self.without_falloff);
        !varies
    }
}

/// A frame, as far as its cost and error depend on it.
#[derive(Debug, Clone, Copy)]
pub struct Facts<'a> {
    /// The lights.
    pub lights: &'a [LightFacts],
    /// The medium.
    pub medium: MediumFacts,
    /// How many views there are.
    pub views: u32,
    /// Pixels of all views together.
    pub pixels: u64,
    /// Triangles that cast shadows.
    pub triangles: u64,
    /// Diagonal of the box around them, of which light volumes leave out what is small; units: m.
    pub diagonal: f32,
    /// Whether there is a hierarchy that shadow rays can go through; froxels need one.
    pub casts_rays: bool,
    /// Largest error that is accepted, as a share of what the shadows change.
    pub target_error: f32,
}

impl Facts<'_> {
    /// Whether anything casts a shadow.
    pub(super) fn is_shadowed(&self) -> bool {
        self.lights.iter().any(|light| light.shadows != ShadowFacts::None)
    }
}
