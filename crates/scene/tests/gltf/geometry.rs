//! Meshes, their indices, transforms and materials.

use crate::writer::File;
use glam::Vec3;
use scene::import::load_gltf_bytes;
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn every_index_type() {
    for component in [5121, 5123, 5125] {
        let mut file = File::new();
        let positions = file.positions(&SQUARE);
        let indices = file.indices(component, &[0, 1, 2, 0, 2, 3]);
        let mesh = file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
        file.node(json!({"mesh": mesh}));
        let scene = file.load().unwrap();
        assert_eq!(scene.meshes.len(), 1);
        assert_eq!(scene.meshes[0].triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(scene.meshes[0].positions(), SQUARE.map(Vec3::from));
        assert!(scene.notes.is_empty(), "{:?}", scene.notes);
        assert!(scene.cameras.is_empty() && scene.lights.is_empty() && scene.medium.is_none());
    }
}

fn with_mode(mode: u32, indices: Option<&[u32]>) -> File {
    let mut file = File::new();
    let positions = file.positions(&[SQUARE.as_slice(), &[[0.5, 2.0, 0.0]]].concat());
    let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
    if let Some(indices) = indices {
        primitive["indices"] = file.indices(5121, indices).into();
    }
    let mesh = file.mesh(primitive);
    file.node(json!({"mesh": mesh}));
    file
}

#[test]
fn strips_fans_and_no_indices() {
    let triangles = |file: File| file.load().unwrap().meshes[0].triangles().to_vec();
    assert_eq!(triangles(with_mode(5, Some(&[0, 1, 3, 2, 4]))), [[0, 1, 3], [1, 2, 3], [3, 2, 4]]);
    assert_eq!(triangles(with_mode(6, Some(&[0, 1, 2, 3]))), [[1, 2, 0], [2, 3, 0]]);
    assert_eq!(triangles(with_mode(6, None)).len(), 3);
    // five corners: the two over do not make a triangle
    let scene = with_mode(4, None).load().unwrap();
    assert_eq!(scene.meshes[0].triangles(), [[0, 1, 2]]);
    assert_eq!(scene.notes, ["mesh 0 primitive 0: corners that do not fill a triangle are left out"]);
}

#[test]
fn points_and_lines_are_skipped_and_said() {
    for mode in 0..4 {
        let scene = with_mode(mode, None).load().unwrap();
        assert!(scene.meshes.is_empty());
        assert_eq!(scene.notes, ["mesh 0 primitive 0: points and lines are skipped"]);
    }
    assert_eq!(with_mode(7, None).error(), "meshes[0].primitives[0].mode: Invalid value");
}

#[test]
fn transforms_reach_the_positions() {
    // a quarter turn about Y (x to -z), below a shift; the child also doubles
    let mut file = File::triangle();
    file.json["nodes"] = json!([
        {"children": [1], "translation": [10, 0, 0]},
        {"mesh": 0, "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2], "scale": [2, 2, 2]},
    ]);
    let mesh = &file.load().unwrap().meshes[0];
    let wanted = [[10.0, 0.0, 0.0], [10.0, 0.0, -2.0], [10.0, 2.0, 0.0]].map(Vec3::from);
    for (&got, wanted) in mesh.positions().iter().zip(wanted) {
        assert!((got - wanted).length() < 1e-6, "{got} {wanted}");
    }
}

#[test]
fn a_mirror_turns_triangles_over() {
    let mut file = File::triangle();
    file.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    file.node(json!({"mesh": 0, "scale": [-1, -1, 1]}));
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!(scene.meshes[0].triangles(), [[0, 2, 1]]);
    assert_eq!(scene.meshes[1].triangles(), [[0, 1, 2]]);
    // the front of the mesh faced +Z, and still does
    for mesh in &scene.meshes {
        let [a, b, c] = mesh.corners().next().unwrap();
        assert!((b - a).cross(c - a).z > 0.0);
    }
}

#[test]
fn what_no_triangle_uses_is_left_out() {
    let mut file = File::new();
    let positions = file.positions(&[SQUARE.as_slice(), &[[900.0, 0.0, 0.0], [2.0, 0.0, 0.0]]].concat());
    let indices = file.indices(5123, &[5, 2, 1]);
    let mesh = file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    file.node(json!({"mesh": mesh}));
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes[0].positions(), [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 0.0, 0.0)]);
    assert_eq!(scene.meshes[0].triangles(), [[2, 1, 0]]);
    assert_eq!(scene.bounds().max, Vec3::new(2.0, 1.0, 0.0));
}

#[test]
fn strides_and_offsets() {
    // positions and something else in turns, after four bytes of a kind
    let mut file = File::triangle();
    let mixed = [7.0, 0.0, 0.0, 0.0, 9.0, 1.0, 0.0, 0.0, 9.0, 0.0, 1.0, 0.0];
    let view = file.floats(&mixed);
    file.json["bufferViews"][view]["byteStride"] = 16.into();
    file.json["accessors"][0]["bufferView"] = view.into();
    file.json["accessors"][0]["byteOffset"] = 4.into();
    assert_eq!(file.load().unwrap(), File::triangle().load().unwrap());
}

/// A triangle of zeros, of which two corners are moved.
fn sparse(base: bool) -> File {
    let mut file = File::new();
    let values = file.floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let which = file.view(&[1, 2]);
    let mut accessor = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
        "count": 2,
        "indices": {"bufferView": which, "componentType": 5121},
        "values": {"bufferView": values},
    }});
    if base {
        accessor["bufferView"] = file.floats(&[0.0, 0.0, 5.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0]).into();
    }
    let accessor = file.push("accessors", accessor);
    let mesh = file.mesh(json!({"attributes": {"POSITION": accessor}}));
    file.node(json!({"mesh": mesh}));
    file
}

#[test]
fn sparse_accessors() {
    assert_eq!(sparse(false).load().unwrap().meshes[0].positions(), [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(sparse(true).load().unwrap().meshes[0].positions(), [5.0 * Vec3::Z, Vec3::X, Vec3::Y]);

    let changed = |change: &dyn Fn(&mut Value, &mut Vec<u8>)| {
        let mut file = sparse(false);
        change(&mut file.json["accessors"][0], &mut file.bin);
        file.error()
    };
    let error = changed(&|_, bin| bin[24] = 2);
    assert_eq!(error, "accessor 0 sparse.indices: must rise strictly, but 2 follows 2");
    let error = changed(&|_, bin| bin[25] = 3);
    assert_eq!(error, "accessor 0 sparse.indices: index 3 is out of range for 3 elements");
    let error = changed(&|accessor, _| accessor["sparse"]["count"] = 3.into());
    assert!(error.starts_with("accessor 0 sparse.values: 3 elements of 12 bytes"), "{error}");
    let error = changed(&|accessor, _| accessor["count"] = 4_000_000_000_u64.into());
    assert!(error.starts_with("accessor 0: 4000000000 elements without a bufferView"), "{error}");
    let error = changed(&|accessor, _| accessor["sparse"]["indices"]["componentType"] = 5126.into());
    assert_eq!(error, "accessors[0].sparse.indices.componentType: Invalid value");
}

#[test]
fn base_colours() {
    let mut file = File::triangle();
    file.push(
        "materials",
        json!({"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0, 1]}}),
    );
    file.push(
        "materials",
        json!({"name": "plain", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
    );
    file.push(
        "materials",
        json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
    );
    file.push("textures", json!({}));
    let scene = file.load().unwrap();
    let colors: Vec<_> = scene.materials.iter().map(|m| (m.name.as_str(), m.base_color)).collect();
    // the last is glTF's default, for the mesh names no material
    assert_eq!(colors, [("red", [0.5, 0.25, 0.0]), ("plain", [1.0; 3]), ("", [1.0; 3]), ("", [1.0; 3])]);
    assert_eq!(scene.meshes[0].material, 3);
    assert_eq!(
        scene.notes,
        [
            "material 1 \"plain\" and 1 more: base colour textures are ignored, surfaces have their base colour factor",
            "material 2: is taken for opaque",
        ]
    );
    file.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    let scene = file.load().unwrap();
    assert_eq!((scene.meshes[0].material, scene.materials.len()), (0, 3));
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 1.5, 0, 1]);
    let error = file.error();
    assert_eq!(error, "material 0 \"red\": baseColorFactor must lie between 0 and 1, got 1.5");
}

#[test]
fn which_scene_is_read() {
    let mut file = File::triangle();
    file.push("scenes", json!({"name": "empty"}));
    assert_eq!(file.load().unwrap().notes, ["scene 0: is the only scene that is read"]);
    file.json["scene"] = 1.into();
    let scene = file.load().unwrap();
    assert!(scene.meshes.is_empty());
    assert_eq!(scene.notes, ["scene 1 \"empty\": is the only scene that is read"]);
    file.json["scene"] = Value::Null;
    assert_eq!(file.load().unwrap().triangle_count(), 1);
    file.json["scenes"] = Value::Null;
    assert_eq!(file.load().unwrap().triangle_count(), 1);
    file.json["scene"] = 0.into();
    assert_eq!(file.error(), "scene: Index out of bounds");
}

#[test]
fn a_file_without_meshes_is_an_empty_scene() {
    let scene = load_gltf_bytes(br#"{"asset": {"version": "2.0"}}"#, None).unwrap();
    assert_eq!(scene, scene::Scene::default());
    assert_eq!(File::new().load().unwrap(), scene::Scene::default());
}

/// What the types or the validation of the crate `gltf` would refuse, though nothing that is read depends on it.
#[test]
fn parts_that_are_not_read_need_not_make_sense() {
    let wanted = File::triangle().load().unwrap();
    let mut file = File::triangle();
    // without bounds of positions as it is; an attribute that glTF does not know
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD"] = 0.into();
    // the source is in an extension
    file.push("textures", json!({"extensions": {"EXT_texture_webp": {"source": 0}}}));
    file.push("samplers", json!({"magFilter": 1}));
    // the target is in an extension
    file.push(
        "animations",
        json!({"channels": [{"sampler": 0, "target": {"path": "pointer"}}], "samplers": []}),
    );
    file.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 5000000000_u64}}),
    );
    let mut scene = file.load().unwrap();
    assert_eq!(scene.notes, ["the document: animations are ignored"]);
    scene.notes.clear();
    assert_eq!(scene, wanted);
}

#[test]
fn what_moves_is_said() {
    let mut file = File::triangle();
    file.json["animations"] = json!([{}]);
    file.json["nodes"][0]["skin"] = 0.into();
    file.push("skins", json!({"joints": [0]}));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{}]);
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]);
    assert_eq!(
        file.load().unwrap().notes,
        [
            "\"EXT_mesh_gpu_instancing\": this extension is ignored",
            "the document: animations are ignored",
            "mesh 0 primitive 0: morph targets are ignored",
            "node 0: its skin is ignored, the mesh keeps its rest pose",
        ]
    );
}
