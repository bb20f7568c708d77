//! Writes binary glTF as the scenes have it: one mesh, a primitive for each material, positions and indices alone.

use std::collections::HashMap;

use glam::Vec3;
use scene::{Aabb, Scene};
use serde_json::{Value, json};

use super::fit::Fit;

/// glTF's numbers for component types.
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// The triangles of one material; vertices of equal bits are one.
#[derive(Debug, Default)]
struct Primitive {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// The triangles of a scene where `fit` moves them, without those that have two corners in one place.
pub(super) fn write(scene: &Scene, fit: &Fit) -> Result<Vec<u8>, String> {
    let mut file = json!({
        "asset": {"version": "2.0", "generator": "airlight"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
    });
    let (mut lists, mut bin) = (Lists::default(), Vec::new());
    for (index, material) in scene.materials.iter().enumerate() {
        let primitive = Primitive::of(scene, index, fit);
        if primitive.triangles.is_empty() {
            continue;
        }
        let [r, g, b] = material.base_color;
        let mut item =
            json!({"pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0}});
        if !material.name.is_empty() {
            item["name"] = material.name.as_str().into();
        }
        lists.materials.push(item);
        primitive.append(&mut lists, &mut bin);
    }
    if lists.primitives.is_empty() {
        return Err("has no triangle".into());
    }
    file["meshes"] = json!([{"primitives": lists.primitives}]);
    file["materials"] = lists.materials.into();
    file["accessors"] = lists.accessors.into();
    file["bufferViews"] = lists.views.into();
    file["buffers"] = json!([{"byteLength": bin.len()}]);
    container(&file, bin)
}

/// What primitives add to the document.
#[derive(Debug, Default)]
struct Lists {
    primitives: Vec<Value>,
    materials: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
}

impl Lists {
    /// An accessor of all of `bytes`; its index.
    fn push(&mut self, bin: &mut Vec<u8>, bytes: &[u8], mut accessor: Value) -> usize {
        // four bytes is what every component type is aligned to
        bin.resize(bin.len().next_multiple_of(4), 0);
        accessor["bufferView"] = self.views.len().into();
        self.views.push(json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()}));
        bin.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

impl Primitive {
    fn of(scene: &Scene, material: usize, fit: &Fit) -> Self {
        let mut primitive = Self::default();
        let mut known = HashMap::new();
        for corners in scene.meshes.iter().filter(|mesh| mesh.material == material).flat_map(|m| m.corners())
        {
            let corners = corners.map(|corner| fit.apply(corner));
            let [a, b, c] = corners;
            if a == b || b == c || c == a {
                continue;
            }
            primitive.triangles.push(corners.map(|corner| {
                *known.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                    primitive.positions.push(corner);
                    primitive.positions.len() as u32 - 1
                })
            }));
        }
        primitive
    }

    fn append(&self, lists: &mut Lists, bin: &mut Vec<u8>) {
        let bounds = Aabb::around(self.positions.iter().copied());
        let bytes: Vec<u8> =
            self.positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect();
        let positions = lists.push(
            bin,
            &bytes,
            json!({
                "componentType": F32, "type": "VEC3", "count": self.positions.len(),
                "min": bounds.min.to_array(), "max": bounds.max.to_array(),
            }),
        );
        let indices = self.triangles.as_flattened();
        // the largest number of a type is no index
        let (kind, bytes): (u32, Vec<u8>) = if self.positions.len() <= usize::from(u16::MAX) {
            (U16, indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect())
        } else {
            (U32, indices.iter().flat_map(|index| index.to_le_bytes()).collect())
        };
        let accessor = json!({"componentType": kind, "type": "SCALAR", "count": indices.len()});
        let indices = lists.push(bin, &bytes, accessor);
        lists.primitives.push(json!({
            "attributes": {"POSITION": positions}, "indices": indices, "material": lists.materials.len() - 1,
        }));
    }
}

/// The document and its buffer in one file.
fn container(file: &Value, mut bin: Vec<u8>) -> Result<Vec<u8>, String> {
    let mut text = file.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let length = |bytes: usize| {
        u32::try_from(bytes).map(u32::to_le_bytes).map_err(|_| "is too large for a .glb file".to_owned())
    };
    // 12 bytes of header, 8 before each of two chunks
    let all = length(28 + text.len() + bin.len())?;
    let (text_length, bin_length) = (length(text.len())?, length(bin.len())?);
    let version = 2_u32.to_le_bytes();
    let parts: [&[u8]; 9] =
        [b"glTF", &version, &all, &text_length, b"JSON", &text, &bin_length, b"BIN\0", &bin];
    Ok(parts.concat())
}
