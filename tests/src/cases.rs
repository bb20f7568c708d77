//! The reference cases in `data/*_public.json` and `data/nasty.json`.
//!
//! Their values have at least 34 proven digits and were rounded once to f64. Every number must be read back to the
//! last bit, which serde_json does with its feature `float_roundtrip` only: a lost bit moves tiny segments by 10⁻¹⁰.

use media_math::{PhaseFunction, Real};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Reads a file of `tests/data`.
pub fn read<T: DeserializeOwned>(name: &str) -> T {
    let text = std::fs::read(crate::data(name)).unwrap();
    serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// A phase function as the cases write it.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Phase {
    /// 1/(4π).
    Isotropic,
    /// Henyey-Greenstein.
    Hg {
        /// Mean cosine.
        g: f64,
    },
}

impl Phase {
    /// The phase function in `T`; `own` replaces g where it is given.
    pub fn function<T: Real>(self, own: Option<f64>) -> PhaseFunction<T> {
        match self {
            Self::Isotropic => PhaseFunction::ISOTROPIC,
            Self::Hg { g } => PhaseFunction::henyey_greenstein(T::lit(own.unwrap_or(g))).unwrap(),
        }
    }

    /// Whether it is the isotropic one.
    pub fn is_isotropic(self) -> bool {
        matches!(self, Self::Isotropic)
    }
}

/// `airlight_public.json`.
#[derive(Debug, Deserialize)]
pub struct AirlightFile {
    /// One interval of a ray each.
    pub cases: Vec<AirlightCase>,
}

/// Airlight of one unoccluded interval.
#[derive(Debug, Deserialize)]
pub struct AirlightCase {
    /// Name of the case.
    pub id: String,
    /// What is hard about it.
    pub category: String,
    /// σ_s in 1/m.
    pub kappa_s: f64,
    /// σ_t in 1/m.
    pub kappa_t: f64,
    /// W/sr.
    pub intensity: f64,
    /// Near end in m.
    pub x0: f64,
    /// Far end in m.
    pub x1: f64,
    /// Phase function.
    pub phase: Phase,
    /// The light, and the value for these very numbers.
    pub foot: Foot,
    /// A problem of its own whose inputs are exact in f32; absent where rounding leaves nothing of it.
    pub f32: Option<F32Problem>,
}

/// The light in the plane of the ray.
#[derive(Debug, Deserialize)]
pub struct Foot {
    /// Distance along the ray to the point next to the light.
    pub x_foot: f64,
    /// Distance of the light from the ray.
    pub h: f64,
    /// The airlight.
    pub value: Option<f64>,
}

/// Every input exact in f32.
#[derive(Debug, Deserialize)]
pub struct F32Problem {
    /// σ_s in 1/m.
    pub kappa_s: f64,
    /// σ_t in 1/m.
    pub kappa_t: f64,
    /// W/sr.
    pub intensity: f64,
    /// As [`Foot::x_foot`].
    pub x_foot: f64,
    /// As [`Foot::h`].
    pub h: f64,
    /// Near end in m.
    pub x0: f64,
    /// Far end in m.
    pub x1: f64,
    /// Henyey-Greenstein's g, where there is one.
    pub g: Option<f64>,
    /// The airlight; null where the interval is empty after rounding.
    pub value: Option<f64>,
}

/// `F_public.json`.
#[derive(Debug, Deserialize)]
pub struct FFile {
    /// Values of F.
    #[serde(rename = "F")]
    pub f: Vec<FCase>,
    /// Differences of two values.
    pub difference: Vec<DifferenceCase>,
}

/// F(u, v).
#[derive(Debug, Deserialize)]
pub struct FCase {
    /// First argument.
    pub u: f64,
    /// Second argument.
    pub v: f64,
    /// F(u, v).
    pub value: f64,
}

/// F(u, v1) − F(u, v0).
#[derive(Debug, Deserialize)]
pub struct DifferenceCase {
    /// First argument.
    pub u: f64,
    /// Lower end.
    pub v0: f64,
    /// Upper end.
    pub v1: f64,
    /// The difference.
    pub value: f64,
}

/// `multi_interval_public.json`.
#[derive(Debug, Deserialize)]
pub struct RayFile {
    /// One shadowed ray each.
    pub rays: Vec<RayCase>,
}

/// Airlight of a shadowed ray; inputs are exact in f32.
#[derive(Debug, Deserialize)]
pub struct RayCase {
    /// Kind of occluder.
    pub category: String,
    /// σ_s in 1/m.
    pub kappa_s: f64,
    /// σ_t in 1/m.
    pub kappa_t: f64,
    /// W/sr.
    pub intensity: f64,
    /// As [`Foot::x_foot`].
    pub x_foot: f64,
    /// As [`Foot::h`].
    pub h: f64,
    /// Phase function.
    pub phase: Phase,
    /// Sorted and disjoint.
    pub lit_intervals: Vec<[f64; 2]>,
    /// Airlight over the lit intervals.
    pub value: f64,
    /// Airlight over the whole ray.
    pub unshadowed_value: f64,
}

/// `hoffman_preetham_public.json`.
#[derive(Debug, Deserialize)]
pub struct HoffmanPreethamFile {
    /// One ray each.
    pub cases: Vec<HoffmanPreethamCase>,
}

/// A directional light's inscatter and extinction; inputs are exact in f32.
#[derive(Debug, Deserialize)]
pub struct HoffmanPreethamCase {
    /// What is hard about it.
    pub category: String,
    /// Rayleigh scattering in 1/m.
    pub beta_rayleigh: [f64; 3],
    /// Mie scattering in 1/m.
    pub beta_mie: [f64; 3],
    /// Absorption in 1/m.
    pub beta_absorption: [f64; 3],
    /// Asymmetry of the Mie part.
    pub g: f64,
    /// `standard` or `hoffman_preetham`.
    pub mie_normalisation: String,
    /// Irradiance in W/m².
    pub e_sun: [f64; 3],
    /// Radiance behind the medium.
    pub l0: [f64; 3],
    /// Cosine between the ray and the way to the sun.
    pub cos_theta: f64,
    /// Length of the ray in m.
    pub s: f64,
    /// Sorted and disjoint.
    pub lit_intervals: Vec<[f64; 2]>,
    /// Transmittance.
    pub f_ex: [f64; 3],
    /// Light scattered into the ray.
    pub l_in: [f64; 3],
    /// Both together.
    pub l: [f64; 3],
}

/// `nasty.json`: fewer and harder cases of every kind, from a second, independent reference.
#[derive(Debug, Deserialize)]
pub struct NastyFile {
    /// As [`AirlightFile`].
    pub airlight: Vec<AirlightCase>,
    /// As [`FFile::f`].
    #[serde(rename = "F")]
    pub f: Vec<FCase>,
    /// As [`FFile::difference`].
    pub difference: Vec<DifferenceCase>,
    /// As [`RayFile`].
    pub rays: Vec<RayCase>,
    /// As [`HoffmanPreethamFile`].
    pub hoffman_preetham: Vec<HoffmanPreethamCase>,
}
