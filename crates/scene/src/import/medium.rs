//! The medium in a scene's `extras.medium`.
//!
//! ```json
//! {"sigma_s": [0.1, 0.14, 0.2], "sigma_a": 0.03, "phase": {"type": "hg", "g": 0.6},
//!  "bounds": {"min": [-3, 0, -3], "max": [3, 3, 3]},
//!  "density": {"type": "height", "y0": 0, "scale": 2}, "emission": [0, 0, 0]}
//! ```
//! Phase types are `isotropic`, `rayleigh`, `hg` and `rayleigh-mie`, the last with `g` and `fraction`, Rayleigh's
//! share of `sigma_s`. A density of type `grid` has `size`, `bounds` and `buffer_view`. Only `sigma_s` must be there.

use super::buffers::{Buffers, place_of};
use super::error::{ImportError, place};
use super::typed;
use crate::{Aabb, Density, DensityGrid, Medium, RgbMedium};
use gltf::Document;
use media_math::{Lobe, MediumError, PhaseFunction};
use serde::Deserialize;

#[derive(Deserialize)]
struct MediumItem {
    sigma_s: Channels,
    #[serde(default)]
    sigma_a: Channels,
    #[serde(default)]
    phase: PhaseItem,
    bounds: Option<BoundsItem>,
    density: Option<DensityItem>,
    #[serde(default)]
    emission: Channels,
}

/// Three channels, or one number for all three.
#[derive(Deserialize, Clone, Copy)]
#[serde(untagged, expecting = "must be a number or an array of three numbers")]
enum Channels {
    Same(f32),
    Each([f32; 3]),
}

#[derive(Deserialize, Default)]
#[serde(tag = "type", rename_all = "kebab-case")]
enum PhaseItem {
    #[default]
    Isotropic,
    Rayleigh,
    Hg {
        g: f32,
    },
    RayleighMie {
        g: f32,
        fraction: f32,
    },
}

#[derive(Deserialize)]
struct BoundsItem {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum DensityItem {
    Height { y0: f32, scale: f32 },
    Grid { size: [u32; 3], bounds: BoundsItem, buffer_view: usize },
}

/// The medium of `scene`, if it has one.
pub(super) fn medium(
    document: &Document,
    buffers: &Buffers<'_>,
    scene: &gltf::Scene<'_>,
) -> Result<Option<Medium>, ImportError> {
    let place = place("scene", scene.index(), scene.name());
    let Some(item) = typed::extra::<MediumItem>(scene.extras(), "medium", &place)? else { return Ok(None) };
    let place = format!("{place} extras.medium");
    let field = |name: &str| format!("{place}.{name}");
    let emission = item.emission.rgb();
    if !emission.iter().all(|&channel| channel >= 0.0 && channel.is_finite()) {
        let reason = format!("must be finite and at least 0, got {emission:?}");
        return Err(ImportError::at(field("emission"), reason));
    }
    let coefficients = RgbMedium::new(item.sigma_s.rgb(), item.sigma_a.rgb());
    Ok(Some(Medium {
        coefficients: coefficients.map_err(|error| ImportError::at(&place, error))?,
        phase: item.phase.read().map_err(|error| ImportError::at(field("phase"), error))?,
        bounds: item.bounds.map(|bounds| bounds.read(&field("bounds"))).transpose()?,
        density: item
            .density
            .map(|density| density.read(document, buffers, &field("density")))
            .transpose()?,
        emission,
    }))
}

impl Default for Channels {
    fn default() -> Self {
        Self::Same(0.0)
    }
}

impl Channels {
    fn rgb(self) -> [f32; 3] {
        match self {
            Self::Same(value) => [value; 3],
            Self::Each(values) => values,
        }
    }
}

impl PhaseItem {
    fn read(self) -> Result<PhaseFunction<f32>, MediumError> {
        match self {
            Self::Isotropic => Ok(PhaseFunction::ISOTROPIC),
            Self::Rayleigh => PhaseFunction::single(Lobe::Rayleigh),
            Self::Hg { g } => PhaseFunction::henyey_greenstein(g),
            Self::RayleighMie { g, fraction } => PhaseFunction::rayleigh_mie(g, fraction),
        }
    }
}

impl BoundsItem {
    fn read(self, place: &str) -> Result<Aabb, ImportError> {
        let Self { min, max } = self;
        for (axis, (min, max)) in min.into_iter().zip(max).enumerate() {
            if !(min < max && min.is_finite() && max.is_finite()) {
                let reason = format!("min[{axis}] must be less than max[{axis}], got {min} and {max}");
                return Err(ImportError::at(place, reason));
            }
        }
        Ok(Aabb { min: min.into(), max: max.into() })
    }
}

impl DensityItem {
    fn read(self, document: &Document, buffers: &Buffers<'_>, place: &str) -> Result<Density, ImportError> {
        let error = |reason: String| ImportError::at(place, reason);
        match self {
            Self::Height { y0, scale } => Density::height(y0, scale).map_err(|e| error(e.to_string())),
            Self::Grid { size, bounds, buffer_view } => {
                let view = document.views().nth(buffer_view);
                let view = view.ok_or_else(|| error(format!("there is no buffer view {buffer_view}")))?;
                let bytes = buffers.view(&view)?;
                // u128 holds the product of three u32 and a 4; before anything is allocated
                let wanted = size.iter().map(|&n| u128::from(n)).product::<u128>() * 4;
                if wanted != bytes.len() as u128 {
                    let (view, length) = (place_of(&view), bytes.len());
                    return Err(error(format!(
                        "a grid of {size:?} f32 takes {wanted} bytes, {view} has {length}"
                    )));
                }
                let value = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                let values = bytes.chunks_exact(4).map(value).collect();
                let grid = DensityGrid::new(size, bounds.read(&format!("{place}.bounds"))?, values);
                grid.map(Density::Grid).map_err(|e| error(e.to_string()))
            }
        }
    }
}
