//! Files on disk: what they refer to, and a folder of real scenes.

use crate::writer::File;
use scene::import::{load_gltf, load_gltf_bytes};
use serde_json::Value;
use std::path::Path;

#[test]
fn the_three_places_of_a_buffer() {
    let file = File::triangle();
    let wanted = file.load().unwrap();
    assert_eq!(load_gltf_bytes(&file.gltf(&file.data_uri()), None).unwrap(), wanted);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("part s")).unwrap();
    std::fs::write(folder.path().join("part s/b\u{e4}r.bin"), &file.bin).unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, file.gltf("part%20s/b%C3%A4r.bin")).unwrap();
    assert_eq!(load_gltf(&path).unwrap(), wanted);
    assert_eq!(load_gltf_bytes(&std::fs::read(&path).unwrap(), Some(folder.path())).unwrap(), wanted);
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, file.glb()).unwrap();
    assert_eq!(load_gltf(&path).unwrap(), wanted);
}

fn numbers(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap() as f32).collect()
}

/// Every scene of the folder `AIRLIGHT_SCENES` has the triangles and the extent that its `manifest.json` states.
#[test]
fn scenes_match_their_manifest() {
    let Some(folder) = std::env::var_os("AIRLIGHT_SCENES") else {
        println!("skipped: AIRLIGHT_SCENES is not set");
        return;
    };
    let folder = Path::new(&folder);
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
    let entries = manifest.as_array().unwrap();
    assert!(!entries.is_empty());
    for entry in entries {
        let name = entry["file"].as_str().unwrap();
        let start = std::time::Instant::now();
        let scene = load_gltf(&folder.join(name)).unwrap();
        println!("{name}: {:.0} ms", 1e3 * start.elapsed().as_secs_f64());
        assert_eq!(Some(scene.triangle_count() as u64), entry["triangles"].as_u64(), "{name}");
        let bounds = scene.bounds();
        for (got, wanted) in [(bounds.min, &entry["bbox_min"]), (bounds.max, &entry["bbox_max"])] {
            for (got, wanted) in got.to_array().into_iter().zip(numbers(wanted)) {
                // the manifest has four digits after the point
                assert!((got - wanted).abs() < 1e-4, "{name}: {got} {wanted}");
            }
        }
    }
}
