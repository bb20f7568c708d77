//! A JSON value that knows where it stands, so that every complaint can name the place.
//!
//! The document is read from plain JSON values instead of generated types. That gives node transforms and intensities
//! in `f64`, an error that names the object and the field instead of a line and a column, and no complaint about
//! the parts of a file that are not used.

use super::error::{ImportError, one_line, quoted};
use serde_json::Value;
use std::fmt::Display;

/// A value in the document.
#[derive(Debug, Clone)]
pub(super) struct Item<'a> {
    value: &'a Value,
    /// Such as `scene 0 extras.medium`; empty for the whole document.
    place: String,
    /// What stands between the place and the name of a field.
    joint: &'static str,
}

impl<'a> Item<'a> {
    /// The whole document.
    pub(super) fn document(value: &'a Value) -> Self {
        Self { value, place: String::new(), joint: "" }
    }

    /// One of the document's objects, such as `node 3`; its name in the file is added.
    pub(super) fn object(value: &'a Value, word: &str, index: usize) -> Self {
        let name = value.get("name").and_then(Value::as_str).map(|name| format!(" {}", quoted(name)));
        Self { value, place: format!("{word} {index}{}", name.unwrap_or_default()), joint: " " }
    }

    /// The same value under a longer name, such as `mesh 0 primitive 1`.
    pub(super) fn called(self, place: String) -> Self {
        Self { place, joint: " ", ..self }
    }

    /// What errors call it.
    pub(super) fn place(&self) -> &str {
        if self.place.is_empty() { "the document" } else { &self.place }
    }

    /// An error at this value.
    pub(super) fn error(&self, reason: impl Display) -> ImportError {
        ImportError::Item { place: self.place().into(), reason: one_line(reason) }
    }

    fn expected(&self, what: &str) -> ImportError {
        let got = match self.value {
            Value::Null => "null".into(),
            Value::Bool(value) => value.to_string(),
            Value::Number(value) => value.to_string(),
            Value::String(value) => quoted(value),
            Value::Array(_) => "an array".into(),
            Value::Object(_) => "an object".into(),
        };
        self.error(format!("must be {what}, got {got}"))
    }

    fn field_place(&self, key: &str) -> String {
        format!("{}{}{key}", self.place, self.joint)
    }

    /// A field of an object; `null` counts as absent.
    pub(super) fn get(&self, key: &str) -> Result<Option<Self>, ImportError> {
        let object = self.value.as_object().ok_or_else(|| self.expected("an object"))?;
        let value = object.get(key).filter(|value| !value.is_null());
        Ok(value.map(|value| Self { value, place: self.field_place(key), joint: "." }))
    }

    /// A field that must be there.
    pub(super) fn need(&self, key: &str) -> Result<Self, ImportError> {
        self.get(key)?
            .ok_or_else(|| ImportError::Item { place: self.field_place(key), reason: "is missing".into() })
    }

    /// A field of a field of ..., each of which may be absent.
    pub(super) fn path(&self, keys: &[&str]) -> Result<Option<Self>, ImportError> {
        let mut item = self.clone();
        for key in keys {
            match item.get(key)? {
                Some(next) => item = next,
                None => return Ok(None),
            }
        }
        Ok(Some(item))
    }

    /// A field of the `extras`, which the application may have filled with anything.
    pub(super) fn extra(&self, key: &str) -> Result<Option<Self>, ImportError> {
        match self.get("extras")? {
            Some(extras) if extras.value.is_object() => extras.get(key),
            _ => Ok(None),
        }
    }

    /// The values of an array.
    pub(super) fn array(&self) -> Result<&'a [Value], ImportError> {
        self.value.as_array().map(Vec::as_slice).ok_or_else(|| self.expected("an array"))
    }

    /// The elements of an array, each with its place.
    pub(super) fn elements(&self) -> Result<impl Iterator<Item = Self>, ImportError> {
        let place = self.place.clone();
        let element = move |(index, value)| Self { value, place: format!("{place}[{index}]"), joint: "." };
        Ok(self.array()?.iter().enumerate().map(element))
    }

    /// A string.
    pub(super) fn text(&self) -> Result<&'a str, ImportError> {
        self.value.as_str().ok_or_else(|| self.expected("a string"))
    }

    /// A finite number.
    pub(super) fn number(&self) -> Result<f64, ImportError> {
        self.value.as_f64().filter(|n| n.is_finite()).ok_or_else(|| self.expected("a number"))
    }

    /// A number that is finite as `f32` and at least 0.
    pub(super) fn amount(&self) -> Result<f64, ImportError> {
        let value = self.single()?;
        if value >= 0.0 {
            Ok(value)
        } else {
            Err(self.error(format!("must be finite and at least 0, got {value}")))
        }
    }

    /// A number that is finite as `f32`.
    pub(super) fn single(&self) -> Result<f64, ImportError> {
        let value = self.number()?;
        if (value as f32).is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("is out of the range of a 32-bit number: {value:e}")))
        }
    }

    /// A whole number of at least 0; glTF allows `3.0` for 3.
    pub(super) fn whole(&self) -> Result<u64, ImportError> {
        // 2^53: the largest up to which an f64 holds every whole number
        let fraction_zero = |n: f64| (0.0..=9007199254740992.0).contains(&n) && n.fract() == 0.0;
        self.value
            .as_u64()
            .or_else(|| self.value.as_f64().filter(|&n| fraction_zero(n)).map(|n| n as u64))
            .ok_or_else(|| self.expected("a whole number of at least 0"))
    }

    /// `true` or `false`.
    pub(super) fn flag(&self) -> Result<bool, ImportError> {
        self.value.as_bool().ok_or_else(|| self.expected("true or false"))
    }

    /// An array of `N` values that `read` accepts.
    pub(super) fn tuple<T: Copy + Default, const N: usize>(
        &self,
        read: impl Fn(&Self) -> Result<T, ImportError>,
    ) -> Result<[T; N], ImportError> {
        let count = self.array()?.len();
        if count != N {
            return Err(self.error(format!("must be an array of {N}, got {count}")));
        }
        let mut values = [T::default(); N];
        for (value, element) in values.iter_mut().zip(self.elements()?) {
            *value = read(&element)?;
        }
        Ok(values)
    }

    /// Three channels that are finite and at least 0, or one number for all three.
    pub(super) fn channels(&self) -> Result<[f32; 3], ImportError> {
        let values = if self.value.is_number() { [self.amount()?; 3] } else { self.tuple(Self::amount)? };
        Ok(values.map(|value| value as f32))
    }

    /// Three coordinates that are finite as `f32`.
    pub(super) fn point(&self) -> Result<[f32; 3], ImportError> {
        Ok(self.tuple(Self::single)?.map(|value: f64| value as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message<T>(result: Result<T, ImportError>) -> String {
        result.err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn places_are_named() {
        let json: Value = serde_json::from_str(
            r#"{"name": "lamp", "extras": {"a": [1, -2, 3], "b": 0.5, "c": null, "d": [1, 2], "e": 1e39}, "n": 7.0}"#,
        )
        .unwrap();
        let item = Item::object(&json, "node", 3);
        let extra = |key: &str| item.extra(key).unwrap().unwrap();
        assert_eq!(
            message(extra("a").channels()),
            "node 3 \"lamp\" extras.a[1]: must be finite and at least 0, got -2"
        );
        assert_eq!(extra("b").channels().unwrap(), [0.5; 3]);
        assert!(item.extra("c").unwrap().is_none());
        assert_eq!(message(extra("d").channels()), "node 3 \"lamp\" extras.d: must be an array of 3, got 2");
        assert!(message(extra("e").channels()).contains("32-bit"));
        assert_eq!(
            message(extra("b").whole()),
            "node 3 \"lamp\" extras.b: must be a whole number of at least 0, got 0.5"
        );
        assert_eq!(item.need("n").unwrap().whole().unwrap(), 7);
        assert_eq!(message(item.need("gone")), "node 3 \"lamp\" gone: is missing");
        assert_eq!(
            message(item.path(&["name", "first"])),
            "node 3 \"lamp\" name: must be an object, got \"lamp\""
        );
        assert_eq!(message(Item::document(&json).need("nodes")), "nodes: is missing");
    }

    #[test]
    fn extras_may_be_anything() {
        for extras in ["5", "\"text\"", "[1]", "null"] {
            let json: Value = serde_json::from_str(&format!("{{\"extras\": {extras}}}")).unwrap();
            assert!(Item::object(&json, "node", 0).extra("medium").unwrap().is_none());
        }
    }
}
