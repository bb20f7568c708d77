//! The medium in a scene's `extras.medium`.
//!
//! ```json
//! {"sigma_s": [0.1, 0.14, 0.2], "sigma_a": 0.03, "phase": {"type": "hg", "g": 0.6},
//!  "bounds": {"min": [-3, 0, -3], "max": [3, 3, 3]},
//!  "density": {"type": "height", "y0": 0, "scale": 2}, "emission": [0, 0, 0]}
//! ```
//! Phase types are `isotropic`, `rayleigh`, `hg` and `rayleigh-mie`, the last with `g` and `fraction`, Rayleigh's
//! share of `sigma_s`. A density of type `grid` has `size`, `bounds` and `buffer_view`. Only `sigma_s` must be there.

use super::buffers::Buffers;
use super::document::{Document, List};
use super::error::{ImportError, quoted};
use super::json::Item;
use crate::{Aabb, Density, DensityGrid, Medium, RgbMedium};
use media_math::{Lobe, PhaseFunction};

/// Reads `extras.medium`.
pub(super) fn medium(
    document: &Document<'_>,
    buffers: &Buffers<'_>,
    item: &Item<'_>,
) -> Result<Medium, ImportError> {
    let channels = |key: &str| item.get(key)?.map_or(Ok([0.0; 3]), |item| item.channels());
    let coefficients = RgbMedium::new(item.need("sigma_s")?.channels()?, channels("sigma_a")?);
    Ok(Medium {
        coefficients: coefficients.map_err(|error| item.error(error))?,
        phase: item.get("phase")?.map_or(Ok(PhaseFunction::ISOTROPIC), |item| phase(&item))?,
        bounds: item.get("bounds")?.map(|item| bounds(&item)).transpose()?,
        density: item.get("density")?.map(|item| density(document, buffers, &item)).transpose()?,
        emission: channels("emission")?,
    })
}

fn phase(item: &Item<'_>) -> Result<PhaseFunction<f32>, ImportError> {
    let g = || {
        let g = item.need("g")?;
        let value = g.single()? as f32;
        // as f32, in which 0.99999999 is 1
        if value.abs() < 1.0 {
            Ok(value)
        } else {
            Err(g.error(format!("must lie strictly between -1 and 1, got {}", g.number()?)))
        }
    };
    let kind = item.need("type")?;
    let phase = match kind.text()? {
        "isotropic" => Ok(PhaseFunction::ISOTROPIC),
        "rayleigh" => PhaseFunction::single(Lobe::Rayleigh),
        "hg" => PhaseFunction::henyey_greenstein(g()?),
        "rayleigh-mie" => {
            let fraction = item.need("fraction")?;
            let value = fraction.single()?;
            if !(0.0..=1.0).contains(&value) {
                return Err(fraction.error(format!("must lie between 0 and 1, got {value}")));
            }
            PhaseFunction::rayleigh_mie(g()?, value as f32)
        }
        other => {
            let other = quoted(other);
            return Err(kind.error(format!(
                "must be \"isotropic\", \"rayleigh\", \"hg\" or \"rayleigh-mie\", got {other}"
            )));
        }
    };
    phase.map_err(|error| item.error(error))
}

fn bounds(item: &Item<'_>) -> Result<Aabb, ImportError> {
    let (min, max) = (item.need("min")?.point()?, item.need("max")?.point()?);
    for axis in 0..3 {
        if min[axis] >= max[axis] {
            return Err(item.error(format!(
                "min[{axis}] must be less than max[{axis}], got {} and {}",
                min[axis], max[axis]
            )));
        }
    }
    Ok(Aabb { min: min.into(), max: max.into() })
}

fn density(document: &Document<'_>, buffers: &Buffers<'_>, item: &Item<'_>) -> Result<Density, ImportError> {
    let kind = item.need("type")?;
    match kind.text()? {
        "height" => {
            let (y0, scale) = (item.need("y0")?.single()? as f32, item.need("scale")?.single()? as f32);
            Density::height(y0, scale).map_err(|error| item.error(error))
        }
        "grid" => grid(document, buffers, item),
        other => Err(kind.error(format!("must be \"height\" or \"grid\", got {}", quoted(other)))),
    }
}

fn grid(document: &Document<'_>, buffers: &Buffers<'_>, item: &Item<'_>) -> Result<Density, ImportError> {
    let side = |item: &Item<'_>| match item.whole()? {
        0 => Err(item.error("must be at least 1")),
        n => u32::try_from(n).map_err(|_| item.error(format!("is out of range: {n}"))),
    };
    let size: [u32; 3] = item.need("size")?.tuple(side)?;
    let reference = item.need("buffer_view")?;
    let (_, view) = document.refer(List::BufferViews, &reference)?;
    let view = buffers.view(document, &view)?;
    // u128 holds the product of three u32 and a 4
    let wanted = size.iter().map(|&n| u128::from(n)).product::<u128>() * 4;
    if wanted != view.bytes.len() as u128 {
        let (place, length) = (&view.place, view.bytes.len());
        return Err(
            reference.error(format!("a grid of {size:?} f32 takes {wanted} bytes, {place} has {length}"))
        );
    }
    let value = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let values = view.bytes.chunks_exact(4).map(value).collect();
    DensityGrid::new(size, bounds(&item.need("bounds")?)?, values)
        .map(Density::Grid)
        .map_err(|error| item.error(error))
}
