//! JSON into types, with errors that name the way to the field at fault.

use super::error::ImportError;
use gltf::json::Extras;
use serde::de::{Deserialize, DeserializeOwned, Deserializer};
use serde_json::Value;

/// A JSON value as a `T`; `place` is what errors call the value, and is empty for the whole document.
pub(super) fn read<'de, T: Deserialize<'de>>(
    json: impl Deserializer<'de>,
    place: &str,
) -> Result<T, ImportError> {
    serde_path_to_error::deserialize(json).map_err(|error| {
        let path = error.path().to_string();
        let place = match (place, path.as_str()) {
            ("", ".") => "the document".into(),
            ("", path) => path.into(),
            (place, ".") => place.into(),
            (place, path) if path.starts_with('[') => format!("{place}{path}"),
            (place, path) => format!("{place}.{path}"),
        };
        ImportError::at(place, error.inner())
    })
}

/// The field `key` of the `extras` of the object called `place`, if there is one.
///
/// Applications may fill `extras` with anything: what is no object has no such field.
pub(super) fn extra<T: DeserializeOwned>(
    extras: &Extras,
    key: &str,
    place: &str,
) -> Result<Option<T>, ImportError> {
    let Some(raw) = extras else { return Ok(None) };
    let mut value: Value = serde_json::from_str(raw.get()).unwrap_or_default();
    match value.get_mut(key).map(Value::take) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => read(value, &format!("{place} extras.{key}")).map(Some),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn extras(value: &Value) -> Extras {
        Some(serde_json::value::to_raw_value(value).unwrap())
    }

    #[test]
    fn places_are_named() {
        let message = |value: Value, place: &str| read::<[[u8; 2]; 1]>(value, place).unwrap_err().to_string();
        assert_eq!(message(json!([[1, "2"]]), ""), "[0][1]: invalid type: string \"2\", expected u8");
        assert_eq!(message(json!([[1, -1]]), "here"), "here[0][1]: invalid value: integer `-1`, expected u8");
        assert_eq!(
            message(json!(5), ""),
            "the document: invalid type: integer `5`, expected an array of length 1"
        );
        let error = extra::<u8>(&extras(&json!({"a": "b"})), "a", "node 3").unwrap_err().to_string();
        assert_eq!(error, "node 3 extras.a: invalid type: string \"b\", expected u8");
    }

    #[test]
    fn extras_may_be_anything() {
        for value in [json!(5), json!("text"), json!([1]), json!(null), json!({"a": null}), json!({})] {
            assert_eq!(extra::<u8>(&extras(&value), "a", "node 0").unwrap(), None);
        }
        assert_eq!(extra::<u8>(&None, "a", "node 0").unwrap(), None);
        assert_eq!(extra::<u8>(&extras(&json!({"a": 7, "b": [[]]})), "a", "node 0").unwrap(), Some(7));
    }
}
