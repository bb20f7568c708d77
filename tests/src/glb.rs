//! Small glTF files, whole and broken.

use serde_json::{Value, json};

/// A glTF document with its binary chunk.
#[derive(Debug, Clone)]
pub struct Glb {
    /// The document; change it at will.
    pub json: Value,
    /// The only buffer.
    pub bin: Vec<u8>,
}

impl Glb {
    /// One triangle of 1 m; no camera, no light, no medium.
    pub fn triangle() -> Self {
        Self::of_positions(&[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    /// One triangle with these corners, whatever they are.
    pub fn of_positions(positions: &[[f32; 3]; 3]) -> Self {
        let mut bin: Vec<u8> = positions.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        bin.extend([0_u16, 1, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "buffers": [{"byteLength": bin.len()}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 36},
                {"buffer": 0, "byteOffset": 36, "byteLength": 6},
            ],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3,
                 "min": [-1, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3},
            ],
        });
        Self { json, bin }
    }

    /// The same with the document changed.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Value)) -> Self {
        change(&mut self.json);
        self
    }

    /// The same with a light of the extension's form on a node of its own.
    #[must_use]
    pub fn with_light(self, light: Value) -> Self {
        self.with(|json| {
            json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
            json["extensions"]["KHR_lights_punctual"]["lights"] = json!([light]);
            let node = json!({
                "translation": [0.5, 2.0, 1.0],
                "extensions": {"KHR_lights_punctual": {"light": 0}},
            });
            json["nodes"] = json!([json["nodes"][0], node]);
            json["scenes"][0]["nodes"] = json!([0, 1]);
        })
    }

    /// As the bytes of a .glb file.
    pub fn bytes(&self) -> Vec<u8> {
        let chunk = |kind: &[u8; 4], bytes: &[u8], fill: u8| {
            let mut bytes = bytes.to_vec();
            bytes.resize(bytes.len().next_multiple_of(4), fill);
            [&(bytes.len() as u32).to_le_bytes()[..], kind, &bytes].concat()
        };
        let body =
            [chunk(b"JSON", self.json.to_string().as_bytes(), b' '), chunk(b"BIN\0", &self.bin, 0)].concat();
        [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }

    /// As the text of a .gltf file whose buffer is at `uri`.
    pub fn gltf(&self, uri: &str) -> String {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = uri.into();
        json.to_string()
    }
}
