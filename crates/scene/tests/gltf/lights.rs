//! Cameras, lights and light textures.

use crate::writer::File;
use glam::{DVec3, Vec3};
use scene::import::{ColorSpace, load_light_texture};
use scene::{Light, LightTexture, SpotLight, TextureFilter};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use std::sync::Arc;

/// A quarter turn about Y that takes −Z to −X and +X to −Z.
const TURN: [f64; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-6
}

#[test]
fn camera_axes() {
    let mut file = File::new();
    file.push(
        "cameras",
        json!({"type": "perspective", "name": "wide", "perspective": {"yfov": 1.25, "znear": 0.1}}),
    );
    file.push("cameras", json!({"type": "orthographic", "name": "flat", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}));
    file.node(json!({"camera": 0, "translation": [1, 2, 3], "rotation": TURN, "scale": [2, 3, 4]}));
    file.node(json!({"camera": 0, "name": "front"}));
    file.node(json!({"camera": 1}));
    file.node(json!({"camera": 0, "scale": [-1, 1, 1]}));
    let scene = file.load().unwrap();
    let [turned, front, mirrored] = &scene.cameras[..] else { panic!("{:?}", scene.cameras) };
    assert_eq!(turned.name.as_deref(), Some("wide"));
    assert_eq!((turned.position, turned.fov_y), (Vec3::new(1.0, 2.0, 3.0), 1.25));
    assert!(near(turned.forward, Vec3::NEG_X) && near(turned.right, Vec3::NEG_Z) && near(turned.up, Vec3::Y));
    assert_eq!(front.name.as_deref(), Some("front"));
    assert_eq!((front.forward, front.right, front.up), (Vec3::NEG_Z, Vec3::X, Vec3::Y));
    // a mirror does not make the frame left-handed
    assert_eq!((mirrored.forward, mirrored.right, mirrored.up), (Vec3::NEG_Z, Vec3::X, Vec3::Y));
    assert_eq!(scene.notes, ["camera 1 \"flat\": orthographic cameras are skipped"]);
}

#[test]
fn camera_nonsense() {
    let refused = |camera: Value, why: &str| {
        let mut file = File::new();
        file.push("cameras", camera);
        file.node(json!({"camera": 0}));
        assert_eq!(file.error(), why);
    };
    let yfov = |yfov: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.1}});
    refused(yfov(0.0), "camera 0: yfov must lie between 0 and pi, got 0");
    refused(yfov(3.2), "camera 0: yfov must lie between 0 and pi, got 3.2");
    refused(json!({"type": "perspective"}), "cameras[0].perspective: Missing data");
    let orthographic = json!({"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9});
    refused(
        json!({"type": "perspective", "orthographic": orthographic}),
        "cameras[0].perspective: Missing data",
    );
    let perspective = json!({"yfov": 1, "znear": 0.1});
    refused(json!({"type": "fish", "perspective": perspective}), "cameras[0].type: Invalid value");
}

#[test]
fn the_three_kinds_of_light() {
    let mut file = File::new();
    let node = json!({"translation": [1, 2, 3], "rotation": TURN, "scale": [5, 5, 5]});
    file.light(
        json!({"type": "point", "intensity": 110, "color": [0.8181818181818182, 0.7272727272727273, 1]}),
        node.clone(),
    );
    file.light(json!({"type": "directional", "intensity": 3}), node.clone());
    file.light(json!({"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}), node);
    file.light(json!({"type": "spot", "range": 7}), json!({}));
    let scene = file.load().unwrap();
    let [Light::Point(point), Light::Directional(sun), Light::Spot(spot), Light::Spot(plain)] =
        &scene.lights[..]
    else {
        panic!("{:?}", scene.lights)
    };
    let position = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!((point.position, point.intensity), (position, Vec3::new(90.0, 80.0, 110.0)));
    assert!(near(sun.direction, Vec3::NEG_X) && sun.irradiance == Vec3::splat(3.0));
    assert_eq!((spot.position, spot.inner, spot.outer, spot.intensity), (position, 0.25, 0.5, Vec3::ONE));
    assert!(near(spot.direction, Vec3::NEG_X) && near(spot.right, Vec3::NEG_Z) && near(spot.top(), Vec3::Y));
    // glTF's defaults
    assert_eq!((plain.inner, plain.outer), (0.0, std::f32::consts::FRAC_PI_4));
    assert_eq!((plain.direction, plain.right, plain.top()), (Vec3::NEG_Z, Vec3::X, Vec3::Y));
    assert_eq!(scene.notes, ["light 3: the light's range is ignored, it shines to infinity"]);
}

#[test]
fn light_nonsense() {
    let refused = |light: Value, why: &str| {
        let mut file = File::new();
        file.light(light, json!({}));
        let error = file.error();
        assert!(error.starts_with(why), "{error}");
    };
    let power = "light 0: intensity and color must be finite and at least 0, got ";
    refused(json!({"type": "point", "intensity": -1}), &format!("{power}-1"));
    refused(json!({"type": "point", "intensity": 1e39}), power);
    refused(json!({"type": "point", "color": [1, -1, 1]}), power);
    let lights = "extensions.KHR_lights_punctual.lights[0]";
    refused(
        json!({"type": "point", "intensity": "NaN"}),
        &format!("{lights}.intensity: invalid type: string \"NaN\", expected f32"),
    );
    refused(
        json!({"type": "point", "intensity": 1e38, "color": [100, 1, 1]}),
        "light 0: intensity times color",
    );
    refused(json!({"type": "point", "color": [1, 1]}), &format!("{lights}.color: invalid length 2"));
    refused(json!({"type": "area"}), "extensions.khrLightsPunctual.lights[0].type: Invalid value");
    refused(json!({"name": "sun"}), &format!("{lights}: missing field `type`"));
    let cone = |inner: f64, outer: f64| json!({"name": "l", "type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
    for (inner, outer) in [(0.0, FRAC_PI_2), (0.5, 0.25), (-0.1, 0.25), (0.0, 1e300)] {
        refused(cone(inner, outer), "light 0 \"l\": light: cone half-angles must satisfy");
    }
    let mut file = File::new();
    file.light(json!({"type": "point"}), json!({"name": "lamp"}));
    file.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1.into();
    assert_eq!(file.error(), "nodes[0].extensions.khrLightsPunctual.light: Index out of bounds");
    file.json["nodes"][0]["extensions"]["KHR_lights_punctual"] = json!({});
    assert_eq!(file.error(), "nodes[0].extensions.KHR_lights_punctual: missing field `light`");
}

/// Top row red and half grey, bottom row blue and white.
fn picture() -> Vec<u8> {
    let pixels = [[255, 0, 0], [188, 188, 188], [0, 0, 255], [255, 255, 255]].concat();
    let image = image::RgbImage::from_raw(2, 2, pixels).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn projector(extras: Value) -> File {
    let mut file = File::new();
    let view = file.view(&picture());
    file.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    file.light(json!({"type": "spot"}), json!({"extras": {"light_texture": extras}}));
    file
}

fn texture(file: &File) -> Arc<LightTexture> {
    match &file.load().unwrap().lights[0] {
        Light::Spot(SpotLight { texture: Some(texture), .. }) => Arc::clone(texture),
        other => panic!("{other:?}"),
    }
}

#[test]
fn light_textures() {
    let default = texture(&projector(json!({"image": 0})));
    assert_eq!((default.width, default.height, default.filter), (2, 2, TextureFilter::Linear));
    // 188 of 255 is half the light
    let grey = default.texels[1];
    assert!(grey.iter().all(|&channel| (channel - 0.5028865).abs() < 1e-6), "{grey:?}");
    assert_eq!(
        [default.texels[0], default.texels[2], default.texels[3]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]]
    );
    let linear = texture(&projector(json!({"image": 0, "filter": "nearest", "color_space": "linear"})));
    assert_eq!(linear.filter, TextureFilter::Nearest);
    assert_eq!(linear.texels[1], [188.0 / 255.0; 3]);
    let scene = projector(json!({"image": 0, "filter": "nearest"})).load().unwrap();
    let Light::Spot(spot) = &scene.lights[0] else { panic!("{:?}", scene.lights) };
    // a little up and to the left of the axis, seen along it: the red texel
    let red = spot.intensity_towards(DVec3::new(-0.1, 0.1, -1.0));
    assert!(red.x > 0.0 && red.y == 0.0 && red.z == 0.0, "{red}");
    let uri = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, picture());
    let mut embedded = projector(json!({"image": 0}));
    embedded.json["images"][0] = json!({"uri": format!("data:image/png;base64,{uri}")});
    assert_eq!(texture(&embedded), default);
}

#[test]
fn lights_share_a_texture() {
    let mut file = projector(json!({"image": 0}));
    file.light(
        json!({"type": "spot"}),
        json!({"extras": {"light_texture": {"image": 0, "color_space": "srgb"}}}),
    );
    let lights = file.load().unwrap().lights;
    let textures = lights.iter().map(|light| match light {
        Light::Spot(SpotLight { texture: Some(texture), .. }) => Arc::as_ptr(texture),
        other => panic!("{other:?}"),
    });
    let textures: Vec<_> = textures.collect();
    assert_eq!(textures[0], textures[1]);
}

#[test]
fn light_texture_nonsense() {
    let refused = |extras: Value, why: &str| {
        let error = projector(extras).error();
        assert!(error.starts_with(why), "{error}");
    };
    refused(json!({}), "node 0 extras.light_texture: missing field `image`");
    refused(json!(3), "node 0 extras.light_texture: invalid type: integer `3`");
    refused(json!({"image": 1}), "node 0 extras.light_texture.image: there is no image 1, the file has 1");
    refused(json!({"image": "0"}), "node 0 extras.light_texture.image: invalid type: string \"0\"");
    let filter =
        "node 0 extras.light_texture.filter: unknown variant `cubic`, expected `nearest` or `linear`";
    refused(json!({"image": 0, "filter": "cubic"}), filter);
    let space =
        "node 0 extras.light_texture.color_space: unknown variant `rec709`, expected `srgb` or `linear`";
    refused(json!({"image": 0, "color_space": "rec709"}), space);

    let mut file = projector(json!({"image": 0}));
    file.bin[30] ^= 0xff;
    assert!(file.error().starts_with("image 0: not usable as a light texture"), "{}", file.error());
    file.json["images"][0] = json!({});
    assert_eq!(file.error(), "image 0: has neither a bufferView nor a uri");
    file.json["images"][0] = json!({"uri": "picture.png"});
    assert!(file.error().starts_with("image 0 uri: refers to the file \"picture.png\""), "{}", file.error());
}

#[test]
fn a_texture_on_something_else_is_said() {
    let mut file = projector(json!({"image": 0}));
    file.json["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "point".into();
    file.node(json!({"extras": {"light_texture": {"image": 0}}}));
    assert_eq!(
        file.load().unwrap().notes,
        [
            "node 0: extras.light_texture is ignored, the light is not a spot",
            "node 1: extras.light_texture is ignored, the node has no light",
        ]
    );
}

#[test]
fn textures_from_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("window.png");
    std::fs::write(&path, picture()).unwrap();
    let load = |space| load_light_texture(&path, TextureFilter::Nearest, space).unwrap();
    assert_eq!(load(ColorSpace::Linear).texels[1], [188.0 / 255.0; 3]);
    assert!((load(ColorSpace::Srgb).texels[1][0] - 0.5028865).abs() < 1e-6);
    let missing = folder.path().join("none.png");
    let error =
        load_light_texture(&missing, TextureFilter::Linear, ColorSpace::Srgb).unwrap_err().to_string();
    assert!(error.contains("none.png: cannot be read"), "{error}");
}
