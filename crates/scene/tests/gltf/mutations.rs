//! Random damage to a valid file: any answer will do, but there must be one.

use crate::writer::File;
use proptest::prelude::*;
use scene::import::load_gltf_bytes;
use serde_json::json;

/// A file with a bit of everything.
fn rich() -> File {
    let mut file = File::triangle();
    let picture = image::RgbImage::from_raw(2, 1, vec![255, 128, 0, 1, 2, 3]).unwrap();
    let mut png = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let view = file.view(&png.into_inner());
    file.push("images", json!({"bufferView": view}));
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}));
    file.push("materials", json!({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}));
    file.push("nodes", json!({"camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,1,0,1]}));
    file.json["nodes"][0]["children"] = json!([1]);
    file.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    let spot =
        json!({"type": "spot", "intensity": 5, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}});
    file.light(spot, json!({"extras": {"light_texture": {"image": 0}}}));
    let grid = file.floats(&[0.5, 1.0]);
    let which = file.view(&[2]);
    let values = file.floats(&[0.0, 2.0, 0.0]);
    file.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": which, "componentType": 5121}, "values": {"bufferView": values},
    });
    let bounds = json!({"min": [0, 0, 0], "max": [1, 1, 1]});
    file.json["scenes"][0]["extras"] = json!({"medium": {
        "sigma_s": [0.1, 0.2, 0.3], "phase": {"type": "rayleigh-mie", "g": 0.5, "fraction": 0.5}, "bounds": bounds,
        "density": {"type": "grid", "size": [2, 1, 1], "bounds": bounds, "buffer_view": grid},
    }});
    file
}

#[test]
fn the_undamaged_file_is_whole() {
    let scene = rich().load().unwrap();
    assert_eq!((scene.triangle_count(), scene.cameras.len(), scene.lights.len()), (1, 1, 1));
    assert!(scene.medium.is_some_and(|medium| medium.density.is_some()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn flipped_and_cut_bytes(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut bytes = rich().glb();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Err(error) = load_gltf_bytes(&bytes, None) {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
    }

    /// Bytes of the document alone, where most of them still are a document.
    #[test]
    fn other_digits(changes in prop::collection::vec((any::<prop::sample::Index>(), b'0'..=b'9'), 1..4)) {
        let mut bytes = rich().glb();
        let digits: Vec<_> =
            (20..bytes.len() - rich().bin.len()).filter(|&at| bytes[at].is_ascii_digit()).collect();
        for (at, digit) in changes {
            bytes[digits[at.index(digits.len())]] = digit;
        }
        let _ = load_gltf_bytes(&bytes, None);
    }
}
