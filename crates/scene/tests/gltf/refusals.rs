//! Bad files: each is one clear error, at once.

use crate::writer::File;
use scene::import::{ImportError, load_gltf, load_gltf_bytes};
use serde_json::{Value, json};

/// A valid triangle after `change`.
fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut file = File::triangle();
    file.json["buffers"] = json!([{"byteLength": file.bin.len()}]);
    change(&mut file.json);
    file.error()
}

#[test]
fn containers() {
    let message = |bytes: &[u8]| load_gltf_bytes(bytes, None).unwrap_err().to_string();
    assert_eq!(message(b""), "not a glTF file: the file is empty");
    assert!(message(&[0xde; 300]).starts_with("not a glTF file"));
    let whole = File::triangle().glb();
    for end in 0..whole.len() {
        assert!(message(&whole[..end]).starts_with("not a glTF file"), "cut after {end} bytes");
    }
    let text = File::triangle().gltf(&File::triangle().data_uri());
    for end in 1..text.len() {
        assert!(message(&text[..end]).starts_with("not valid JSON"), "cut after {end} bytes");
    }
}

#[test]
fn versions_and_extensions() {
    assert_eq!(changed(|json| json["asset"] = Value::Null), "the document: missing field `asset`");
    assert_eq!(changed(|json| json["asset"] = json!({})), "asset: missing field `version`");
    let error = changed(|json| json["asset"]["version"] = "1.0".into());
    assert_eq!(error, "asset.version: only glTF 2 can be read, got \"1.0\"");
    let error = changed(|json| json["asset"]["minVersion"] = "2.1".into());
    assert_eq!(error, "asset.minVersion: only glTF 2.0 can be read, got \"2.1\"");
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization", "VENDOR_x"]
    {
        let error = changed(|json| json["extensionsRequired"] = json!(["KHR_lights_punctual", name]));
        assert_eq!(error, format!("requires the extension \"{name}\", which is not supported"));
    }
    let mut file = File::triangle();
    file.json["extensionsRequired"] =
        json!(["KHR_lights_punctual", "KHR_materials_unlit", "KHR_texture_transform"]);
    assert!(file.load().is_ok());
}

#[test]
fn numbers_of_positions_and_indices() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = File::triangle();
        file.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        assert!(file.error().starts_with("mesh 0 primitive 0: position 1 is not finite"), "{}", file.error());
    }
    let mut file = File::triangle();
    file.json["meshes"][0]["name"] = "foo".into();
    file.bin[36..38].copy_from_slice(&999_u16.to_le_bytes());
    assert_eq!(file.error(), "mesh 0 \"foo\" primitive 0: index 999 is out of range for 3 positions");
    let mut file = File::triangle();
    file.json["nodes"][0]["scale"] = json!([1e39, 1, 1]);
    assert_eq!(
        file.error(),
        "node 0: its transform, with those of its parents, is not finite or not invertible"
    );
    file.json["nodes"][0]["scale"] = json!([3e38, 1, 1]);
    file.bin[12..16].copy_from_slice(&2_f32.to_le_bytes());
    assert_eq!(file.error(), "mesh 0 primitive 0: node 0 puts position 1 out of the range of 32-bit numbers");
}

#[test]
fn accessors() {
    let accessor =
        |index: usize, key: &str, value: Value| changed(|json| json["accessors"][index][key] = value);
    let huge = 1_u64 << 31;
    let start = std::time::Instant::now();
    assert!(accessor(0, "count", huge.into()).starts_with("accessor 0: 2147483648 elements of 12 bytes"));
    assert!(accessor(1, "count", huge.into()).starts_with("accessor 1: 2147483648 elements of 2 bytes"));
    assert!(
        accessor(0, "count", u64::MAX.into())
            .starts_with("accessor 0: 18446744073709551615 elements are more")
    );
    assert!(accessor(0, "byteOffset", u64::MAX.into()).contains("do not fit in buffer view 0"));
    assert!(accessor(0, "byteOffset", 4.into()).contains("do not fit in buffer view 0"));
    assert!(start.elapsed().as_secs_f64() < 1.0, "counts were believed");
    for count in [json!(-3), json!(2.5), json!("3")] {
        let error = accessor(0, "count", count);
        assert!(
            error.starts_with("accessors[0].count: invalid") && error.contains("expected u64"),
            "{error}"
        );
    }
    assert_eq!(accessor(0, "type", "VEC4".into()), "accessor 0: must be Vec3 here, got Vec4");
    assert_eq!(accessor(1, "type", "VEC3".into()), "accessor 1: must be Scalar here, got Vec3");
    assert!(
        accessor(0, "componentType", 5123.into())
            .contains("accessor 0: positions must be f32 (5126), got 5123")
    );
    assert!(accessor(1, "componentType", 5126.into()).contains("accessor 1: indices must be u8"));
    assert!(accessor(1, "componentType", 5122.into()).contains("accessor 1: indices must be u8"));
    assert_eq!(accessor(1, "componentType", 5127.into()), "accessors[1].componentType: Invalid value");
    // 2^32 + 5125, which is 5125 in 32 bits
    assert!(
        accessor(1, "componentType", json!(4294972421_u64))
            .starts_with("accessors[1].componentType: invalid type")
    );
    assert!(accessor(0, "normalized", true.into()).contains("cannot be normalised"));
    assert_eq!(accessor(0, "bufferView", 9.into()), "accessors[0].bufferView: Index out of bounds");
    assert_eq!(accessor(0, "bufferView", Value::Null), "accessors[0].bufferView: Missing data");
    assert!(changed(|json| json["accessors"] = json!(5)).starts_with("accessors: invalid type: integer `5`"));
    // 0 in 32 bits
    let error = changed(|json| json["nodes"][0]["mesh"] = (1_u64 << 32).into());
    assert!(error.starts_with("nodes[0].mesh: invalid type: floating point `4294967296.0`"), "{error}");
}

#[test]
fn views_and_buffers() {
    let view = |key: &str, value: Value| changed(|json| json["bufferViews"][0][key] = value);
    assert!(
        view("byteLength", 1000.into())
            .contains("buffer view 0: 1000 bytes from 0 on do not fit in buffer 0")
    );
    assert!(view("byteLength", u64::MAX.into()).contains("do not fit in buffer 0"));
    assert!(view("byteOffset", u64::MAX.into()).contains("do not fit in buffer 0"));
    assert_eq!(view("buffer", 1.into()), "bufferViews[0].buffer: Index out of bounds");
    assert!(view("byteStride", 8.into()).contains("overlap in buffer view 0"));
    for stride in [0, 3, 253] {
        assert_eq!(view("byteStride", stride.into()), "bufferViews[0].byteStride: Invalid value");
    }
    assert!(view("byteStride", u64::MAX.into()).starts_with("bufferViews[0].byteStride: invalid type"));
    let buffers = |buffers: Value| changed(|json| json["buffers"] = buffers);
    assert_eq!(
        buffers(json!([{"byteLength": 400}])),
        "buffer 0: should have 400 bytes, but only 44 are there"
    );
    assert!(buffers(json!([{"byteLength": 1_u64 << 60}])).contains("but only 44"));
    assert!(buffers(json!([{}])).contains("do not fit in buffer 0, which has 0"));
    assert!(buffers(json!([{"byteLength": 44}, {"byteLength": 4}])).contains("buffer 1: has no uri"));
    assert!(buffers(json!([{"byteLength": 44, "uri": "data:,ab"}])).contains("only 2 are there"));
    assert!(
        buffers(json!([{"byteLength": 44, "uri": 5}])).contains("buffers[0].uri: invalid type: integer `5`")
    );
    assert!(buffers(json!([{"byteLength": 44, "uri": "http://x/y"}])).contains("only data URIs"));
}

#[test]
fn primitives() {
    let primitive = |key: &str, value: Value| changed(|json| json["meshes"][0]["primitives"][0][key] = value);
    let place = "meshes[0].primitives[0]";
    assert_eq!(primitive("attributes", json!({})), format!("{place}.attributes[\"POSITION\"]: Missing data"));
    assert_eq!(
        primitive("attributes", json!({"POSITION": 7})),
        format!("{place}.attributes.POSITION: Index out of bounds")
    );
    assert!(
        primitive("attributes", json!({"POSITION": "0"}))
            .starts_with(&format!("{place}.attributes.POSITION: invalid type: string"))
    );
    assert_eq!(primitive("attributes", Value::Null), format!("{place}: missing field `attributes`"));
    assert_eq!(primitive("indices", 7.into()), format!("{place}.indices: Index out of bounds"));
    assert_eq!(primitive("material", 0.into()), format!("{place}.material: Index out of bounds"));
    assert_eq!(changed(|json| json["meshes"][0] = json!({})), "meshes[0]: missing field `primitives`");
    assert!(changed(|json| json["meshes"][0] = json!(1)).starts_with("meshes[0]: invalid type: integer `1`"));
}

/// 2^20 triangles of which 64 primitives and 33 nodes would make 2^31 and more.
#[test]
fn too_many_triangles_are_counted_before_they_are_made() {
    let mut file = File::new();
    let positions = file.positions(&[[0.0; 3]; 3]);
    let view = file.view(&vec![0; 3 << 20]);
    let indices = file.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5121, "type": "SCALAR", "count": 3 << 20}),
    );
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    file.push("meshes", json!({"primitives": vec![primitive; 64]}));
    for _ in 0..33 {
        file.node(json!({"mesh": 0}));
    }
    let start = std::time::Instant::now();
    let error = file.load().unwrap_err();
    assert!(matches!(error, ImportError::TooManyTriangles(count) if count == 33 << 26), "{error}");
    assert!(start.elapsed().as_secs_f64() < 5.0, "triangles were made");
}

#[test]
fn files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let message = || load_gltf(&path).unwrap_err().to_string();
    assert!(message().starts_with(&format!("{}: cannot be read: ", path.display())), "{}", message());
    std::fs::write(&path, File::triangle().gltf("missing.bin")).unwrap();
    assert!(
        message().contains("scene.gltf: buffer 0 uri: ") && message().contains("missing.bin"),
        "{}",
        message()
    );
    let error = load_gltf(folder.path()).unwrap_err().to_string();
    assert!(error.contains("cannot be read"), "{error}");
}
