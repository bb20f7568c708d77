//! Writes small glTF files.

use base64::Engine as _;
use scene::Scene;
use scene::import::{ImportError, load_gltf_bytes};
use serde_json::{Value, json};

/// A glTF file under construction; `json` may be changed at will before it is written.
#[derive(Clone)]
pub(crate) struct File {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl File {
    /// A scene without nodes.
    pub(crate) fn new() -> Self {
        let json = json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]});
        Self { json, bin: Vec::new() }
    }

    /// One triangle with u16 indices, seen by a node without a transform.
    pub(crate) fn triangle() -> Self {
        let mut file = Self::new();
        let positions = file.positions(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let indices = file.indices(5123, &[0, 1, 2]);
        let mesh = file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
        file.node(json!({"mesh": mesh}));
        file
    }

    /// Appends to a list of the document; returns the index.
    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let items = list.as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    /// A buffer view of `bytes`.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend(bytes);
        self.push("bufferViews", view)
    }

    /// A buffer view of floats.
    pub(crate) fn floats(&mut self, values: &[f32]) -> usize {
        let bytes: Vec<_> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.view(&bytes)
    }

    /// An accessor of positions.
    pub(crate) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let view = self.floats(positions.as_flattened());
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": positions.len()}),
        )
    }

    /// An accessor of indices of the given component type.
    pub(crate) fn indices(&mut self, component: u32, indices: &[u32]) -> usize {
        let size = match component {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let bytes: Vec<_> = indices.iter().flat_map(|index| index.to_le_bytes()[..size].to_vec()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": "SCALAR", "count": indices.len()}),
        )
    }

    /// A mesh of one primitive.
    pub(crate) fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"primitives": [primitive]}))
    }

    /// A root node of the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(index.into());
        index
    }

    /// A light on a root node, which gets the further fields of `node`.
    pub(crate) fn light(&mut self, light: Value, mut node: Value) {
        let lights = &mut self.json["extensions"]["KHR_lights_punctual"]["lights"];
        if lights.is_null() {
            *lights = json!([]);
        }
        let lights = lights.as_array_mut().unwrap();
        lights.push(light);
        node["extensions"] = json!({"KHR_lights_punctual": {"light": lights.len() - 1}});
        self.node(node);
    }

    /// As `.glb`.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bin.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        }
        let chunk = |kind: &[u8], mut bytes: Vec<u8>, fill: u8| {
            bytes.resize(bytes.len().next_multiple_of(4), fill);
            [&(bytes.len() as u32).to_le_bytes(), kind, &bytes].concat()
        };
        let mut body = chunk(b"JSON", json.to_string().into_bytes(), b' ');
        if !self.bin.is_empty() {
            body.extend(chunk(b"BIN\0", self.bin.clone(), 0));
        }
        [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }

    /// As `.gltf` whose buffer is at `uri`.
    pub(crate) fn gltf(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bin.len(), "uri": uri}]);
        json.to_string().into_bytes()
    }

    /// The buffer as a data URI.
    pub(crate) fn data_uri(&self) -> String {
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        format!("data:application/octet-stream;base64,{data}")
    }

    /// Reads the `.glb` back.
    pub(crate) fn load(&self) -> Result<Scene, ImportError> {
        load_gltf_bytes(&self.glb(), None)
    }

    /// The text of the error that reading the `.glb` gives.
    pub(crate) fn error(&self) -> String {
        let error = self.load().expect_err("the file should have been refused").to_string();
        assert!(!error.contains('\n'), "more than one line: {error}");
        error
    }
}
