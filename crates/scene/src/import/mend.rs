//! What good files hold and the crate's types do not take as it is meant.

use gltf::json::Root;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Spot, Type};
use gltf::json::validation::Checked;
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_4;

/// Takes `null` for absent, and keeps large whole numbers from becoming indices.
///
/// The crate cuts indices to 32 bits, so that 2^32 would mean the first object. As a number with a fraction it still
/// serves where one is wanted, and is refused as an index.
pub(super) fn values(json: &mut Value) {
    // lengths in bytes and counts of elements are 64 bits wide
    const WIDE: [&str; 3] = ["byteLength", "byteOffset", "count"];
    match json {
        Value::Array(items) => items.iter_mut().for_each(values),
        Value::Object(fields) => {
            fields.retain(|_, value| !value.is_null());
            fields
                .iter_mut()
                .filter(|(key, _)| !WIDE.contains(&key.as_str()))
                .for_each(|(_, value)| values(value));
        }
        Value::Number(number) if number.as_u64() > Some(u32::MAX.into()) => *json = number.as_f64().into(),
        _ => {}
    }
}

/// Removes animations, and says whether there were any.
///
/// They are not read, so they need not make sense; with `KHR_animation_pointer` they are what the crate refuses.
pub(super) fn take_animations(json: &mut Value) -> bool {
    json.as_object_mut().and_then(|root| root.remove("animations")).is_some()
}

/// Gives scenes without nodes an empty list of them, which the crate insists on.
pub(super) fn scenes(json: &mut Value) {
    let scenes = json.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
}

/// Gives spot lights that state no cone the cone whose both angles have their defaults.
pub(super) fn lights(root: &mut Root) {
    let lights: &mut Vec<Light> = root.as_mut();
    for light in lights.iter_mut().filter(|light| light.type_ == Checked::Valid(Type::Spot)) {
        light.spot.get_or_insert(Spot { inner_cone_angle: 0.0, outer_cone_angle: FRAC_PI_4 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_are_no_indices() {
        let mut json = json!({"mesh": 4294967296_u64, "camera": 4294967295_u64, "byteLength": 4294967296_u64, "x": [-1, 1.5, null]});
        values(&mut json);
        assert_eq!(
            json,
            json!({"mesh": 4294967296.0, "camera": 4294967295_u64, "byteLength": 4294967296_u64, "x": [-1, 1.5, null]})
        );
    }

    #[test]
    fn null_is_absent() {
        let mut json = json!({"a": null, "b": [{"c": null}]});
        values(&mut json);
        assert_eq!(json, json!({"b": [{}]}));
    }
}
