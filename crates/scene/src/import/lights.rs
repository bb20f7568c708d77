//! Lights of `KHR_lights_punctual`.

use super::cameras::Frame;
use super::error::{ImportError, quoted};
use super::json::Item;
use super::nodes::Node;
use super::notes::Notes;
use super::texture::Textures;
use crate::{DirectionalLight, Light, PointLight, SpotLight};
use glam::Vec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// The light that `node` carries; `light` is one of the document's lights.
///
/// Candela and lux are taken for W/sr and W/m², unscaled.
pub(super) fn light(
    node: &Node<'_>,
    light: &Item<'_>,
    textures: &mut Textures<'_>,
    notes: &mut Notes,
) -> Result<Light, ImportError> {
    let frame = Frame::of(node)?;
    let power = power(light)?;
    if light.get("range")?.is_some() {
        notes.add("the light's range is ignored, it shines to infinity", light.place());
    }
    let (position, direction) = (frame.position.as_vec3(), frame.forward.as_vec3());
    let kind = light.need("type")?;
    let texture = node.item.extra("light_texture")?;
    if texture.is_some() && kind.text()? != "spot" {
        notes.add("extras.light_texture is ignored, the light is not a spot", node.item.place());
    }
    let made = match kind.text()? {
        "point" => PointLight::new(position, power).map(Light::Point),
        "directional" => DirectionalLight::new(direction, power).map(Light::Directional),
        "spot" => {
            let (inner, outer) = cone(light)?;
            let texture = texture.map(|texture| textures.get(&texture)).transpose()?;
            SpotLight::new(position, direction, inner, outer, power)
                .map(|spot| Light::Spot(SpotLight { right: frame.right.as_vec3(), texture, ..spot }))
        }
        other => {
            return Err(
                kind.error(format!("must be \"point\", \"spot\" or \"directional\", got {}", quoted(other)))
            );
        }
    };
    made.map_err(|error| light.error(error))
}

/// Intensity times colour.
fn power(light: &Item<'_>) -> Result<Vec3, ImportError> {
    let intensity = light.get("intensity")?.map_or(Ok(1.0), |item| item.amount())?;
    let color = light.get("color")?.map_or(Ok([1.0; 3]), |item| item.tuple(Item::amount))?;
    // in f64: colours are often a quotient that shall give a round number again
    let power = color.map(|channel| (intensity * channel) as f32);
    if power.iter().all(|channel| channel.is_finite()) {
        Ok(power.into())
    } else {
        Err(light.error("intensity times color is out of the range of 32-bit numbers"))
    }
}

/// Inner and outer half-angle; units: rad.
fn cone(light: &Item<'_>) -> Result<(f32, f32), ImportError> {
    let Some(spot) = light.get("spot")? else { return Ok((0.0, FRAC_PI_4 as f32)) };
    let inner = spot.get("innerConeAngle")?.map_or(Ok(0.0), |item| item.amount())?;
    let outer = spot.get("outerConeAngle")?.map_or(Ok(FRAC_PI_4), |item| item.amount())?;
    // glTF allows a half-angle of 90 degrees; the square that a light texture covers would be without end
    if inner > outer || outer >= FRAC_PI_2 || outer as f32 >= std::f32::consts::FRAC_PI_2 {
        return Err(spot.error(format!(
            "must satisfy innerConeAngle <= outerConeAngle < pi/2 (90 degrees), got {inner} and {outer}"
        )));
    }
    Ok((inner as f32, outer as f32))
}
