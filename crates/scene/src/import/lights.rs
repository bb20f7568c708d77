//! Lights of `KHR_lights_punctual`.

use super::cameras::Frame;
use super::error::{ImportError, place};
use super::nodes::Node;
use super::notes::Notes;
use super::texture::Textures;
use super::typed;
use crate::{DirectionalLight, Light, PointLight, SpotLight};
use glam::Vec3;
use gltf::khr_lights_punctual::Kind;

/// The light that `node` carries, if there is one.
///
/// Candela and lux are taken for W/sr and W/m², unscaled.
pub(super) fn light(
    node: &Node<'_>,
    textures: &mut Textures<'_>,
    notes: &mut Notes,
) -> Result<Option<Light>, ImportError> {
    let texture = typed::extra(node.item.extras(), "light_texture", &node.place())?;
    let Some(light) = node.item.light() else {
        if texture.is_some() {
            notes.add("extras.light_texture is ignored, the node has no light", &node.place());
        }
        return Ok(None);
    };
    let place = place("light", light.index(), light.name());
    let power = power(&light).map_err(|reason| ImportError::at(&place, reason))?;
    if light.range().is_some() {
        notes.add("the light's range is ignored, it shines to infinity", &place);
    }
    let kind = light.kind();
    if texture.is_some() && !matches!(kind, Kind::Spot { .. }) {
        notes.add("extras.light_texture is ignored, the light is not a spot", &node.place());
    }
    let frame = Frame::of(node)?;
    let (position, direction) = (frame.position.as_vec3(), frame.forward.as_vec3());
    let made = match kind {
        Kind::Point => PointLight::new(position, power).map(Light::Point),
        Kind::Directional => DirectionalLight::new(direction, power).map(Light::Directional),
        // glTF allows a half-angle of 90 degrees; the square that a light texture covers would be without end
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let texture = texture.map(|texture| textures.get(&texture, &node.place())).transpose()?;
            SpotLight::new(position, direction, inner_cone_angle, outer_cone_angle, power)
                .map(|spot| Light::Spot(SpotLight { right: frame.right.as_vec3(), texture, ..spot }))
        }
    };
    made.map(Some).map_err(|error| ImportError::at(place, error))
}

/// Intensity times colour.
fn power(light: &gltf::khr_lights_punctual::Light<'_>) -> Result<Vec3, String> {
    let (intensity, color) = (light.intensity(), Vec3::from_array(light.color()));
    if !(intensity >= 0.0 && intensity.is_finite() && color.min_element() >= 0.0 && color.is_finite()) {
        return Err(format!(
            "intensity and color must be finite and at least 0, got {intensity} and {color}"
        ));
    }
    let power = intensity * color;
    if power.is_finite() {
        Ok(power)
    } else {
        Err("intensity times color is out of the range of 32-bit numbers".into())
    }
}
