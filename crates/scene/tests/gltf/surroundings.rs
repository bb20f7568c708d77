//! The medium.

use crate::writer::File;
use glam::{DVec3, Vec3};
use media_math::{Lobe, PhaseFunction};
use scene::{Aabb, Density, Medium};
use serde_json::{Value, json};

fn with(medium: Value) -> File {
    let mut file = File::new();
    file.json["scenes"][0]["extras"] = json!({"author": "someone", "medium": medium});
    file
}

fn medium(medium: Value) -> Medium {
    with(medium).load().unwrap().medium.unwrap()
}

fn refused(medium: Value, why: &str) {
    let error = with(medium).error();
    assert!(error.starts_with(&format!("scene 0 extras.medium{why}")), "{error}");
}

#[test]
fn a_whole_medium() {
    let got = medium(json!({
        "sigma_s": [0.1, 0.14, 0.2], "sigma_a": [0.03, 0.03, 0.03], "phase": {"type": "hg", "g": 0.6},
        "bounds": {"min": [-3, 0, -3], "max": [3, 3, 3]}, "emission": [0, 0.5, 1], "colour of hat": "blue",
    }));
    assert_eq!(got.coefficients.sigma_s(), [0.1, 0.14, 0.2]);
    assert_eq!(got.coefficients.sigma_a(), [0.03; 3]);
    assert_eq!(got.phase, PhaseFunction::henyey_greenstein(0.6).unwrap());
    assert_eq!(got.bounds, Some(Aabb { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::splat(3.0) }));
    assert_eq!((got.density, got.emission), (None, [0.0, 0.5, 1.0]));
}

#[test]
fn a_medium_in_short() {
    let wanted = Medium::homogeneous([0.5; 3], [0.0; 3]).unwrap();
    assert_eq!(medium(json!({"sigma_s": 0.5})), wanted);
    assert_eq!(medium(json!({"sigma_s": 0.5, "sigma_a": 0, "bounds": null, "phase": null})), wanted);
    assert!(File::new().load().unwrap().medium.is_none());
    assert!(with(Value::Null).load().unwrap().medium.is_none());
}

#[test]
fn phase_functions() {
    let phase = |phase: Value| medium(json!({"sigma_s": 1, "phase": phase})).phase;
    assert_eq!(phase(json!({"type": "isotropic"})), PhaseFunction::ISOTROPIC);
    assert_eq!(phase(json!({"type": "hg", "g": 0})), PhaseFunction::ISOTROPIC);
    assert_eq!(phase(json!({"type": "rayleigh"})), PhaseFunction::single(Lobe::Rayleigh).unwrap());
    let mixture = phase(json!({"type": "rayleigh-mie", "g": -0.5, "fraction": 0.25}));
    assert_eq!(mixture, PhaseFunction::rayleigh_mie(-0.5, 0.25).unwrap());
}

#[test]
fn densities() {
    let height = medium(json!({"sigma_s": 1, "density": {"type": "height", "y0": -1, "scale": 2.5}})).density;
    assert_eq!(height, Some(Density::height(-1.0, 2.5).unwrap()));
    let Some(Density::Grid(grid)) = grid(json!([2, 1, 2])).load().unwrap().medium.unwrap().density else {
        panic!()
    };
    assert_eq!((grid.size, &grid.values[..]), ([2, 1, 2], &[1.0, 2.0, 3.0, 4.0][..]));
    // x varies fastest
    assert_eq!(grid.at(DVec3::new(3.0, 0.5, 0.5)), 2.0);
    assert_eq!(grid.at(DVec3::new(1.0, 0.5, 1.5)), 3.0);
}

fn grid(size: Value) -> File {
    let mut file = File::new();
    let view = file.floats(&[1.0, 2.0, 3.0, 4.0]);
    let bounds = json!({"min": [0, 0, 0], "max": [4, 1, 2]});
    let density = json!({"type": "grid", "size": size, "bounds": bounds, "buffer_view": view});
    file.json["scenes"][0]["extras"] = json!({"medium": {"sigma_s": 1, "density": density}});
    file
}

#[test]
fn grid_nonsense() {
    let error = grid(json!([2, 2, 2])).error();
    assert_eq!(
        error,
        "scene 0 extras.medium.density: a grid of [2, 2, 2] f32 takes 32 bytes, buffer view 0 has 16"
    );
    let most = u32::MAX;
    let error = grid(json!([most, most, most])).error();
    assert!(error.contains("takes 316912649835696421541200789500 bytes"), "{error}");
    assert!(grid(json!([4, 1, 0])).error().contains("medium.density: a grid of [4, 1, 0] f32 takes 0 bytes"));
    assert!(grid(json!([4, 1, 4294967296_u64])).error().contains("medium.density: invalid type"));
    assert!(grid(json!([4, 1, 0.5])).error().contains("medium.density: invalid type: floating point `0.5`"));
    let mut none = grid(json!([4, 1, 0]));
    none.json["bufferViews"][0]["byteLength"] = 0.into();
    assert!(none.error().contains("medium.density: density: a grid of [4, 1, 0] cells"), "{}", none.error());
    let mut file = grid(json!([4, 1, 1]));
    file.bin[..4].copy_from_slice(&(-1.0_f32).to_le_bytes());
    assert!(file.error().contains("medium.density: density: a grid's values"), "{}", file.error());
    file.bin[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(file.error().contains("medium.density: density: a grid's values"));
    file.json["scenes"][0]["extras"]["medium"]["density"]["buffer_view"] = 7.into();
    assert!(file.error().contains("medium.density: there is no buffer view 7"));
}

#[test]
fn nonsense_is_named() {
    refused(json!("fog"), ": invalid type: string \"fog\"");
    refused(json!({}), ": missing field `sigma_s`");
    refused(json!({"sigma_s": [1, -1, 1]}), ": sigma_s must be finite and at least 0 per metre, got -1");
    let channels = "must be a number or an array of three numbers";
    for bad in [json!([1, "1", 1]), json!([1, 1]), json!({"r": 1}), json!("1")] {
        refused(json!({"sigma_s": bad}), &format!(".sigma_s: {channels}"));
    }
    refused(
        json!({"sigma_s": 1, "sigma_a": -0.5}),
        ": sigma_a must be finite and at least 0 per metre, got -0.5",
    );
    refused(json!({"sigma_s": 1, "sigma_a": 1e300}), ": sigma_a must be finite");
    refused(json!({"sigma_s": 1, "emission": [0, 0, -2]}), ".emission: must be finite and at least 0");
    refused(json!({"sigma_s": 1, "emission": 1e300}), ".emission: must be finite and at least 0");
    let phase = |phase: Value, why: &str| refused(json!({"sigma_s": 1, "phase": phase}), why);
    phase(json!("hg"), ".phase: invalid type: string \"hg\"");
    phase(
        json!({"type": "mie"}),
        ".phase.type: unknown variant `mie`, expected one of `isotropic`, `rayleigh`, `hg`, `rayleigh-mie`",
    );
    phase(json!({"type": "hg"}), ".phase: missing field `g`");
    for g in [1.0, -1.0, 1.5, 0.999_999_999_9] {
        phase(json!({"type": "hg", "g": g}), ".phase: g must lie strictly between -1 and 1");
    }
    phase(json!({"type": "rayleigh-mie", "g": 0.5}), ".phase: missing field `fraction`");
    phase(
        json!({"type": "rayleigh-mie", "g": 0.5, "fraction": 1.5}),
        ".phase: the weights of a phase mixture must lie in [0, 1]",
    );
    let bounds = |bounds: Value, why: &str| refused(json!({"sigma_s": 1, "bounds": bounds}), why);
    bounds(json!({"min": [0, 0, 0]}), ".bounds: missing field `max`");
    bounds(
        json!({"min": [0, 2, 0], "max": [1, 1, 1]}),
        ".bounds: min[1] must be less than max[1], got 2 and 1",
    );
    bounds(json!({"min": [0, 0, 0], "max": [1, 1, 1e39]}), ".bounds: min[2] must be less than max[2]");
    let density = |density: Value, why: &str| refused(json!({"sigma_s": 1, "density": density}), why);
    density(json!({"type": "noise"}), ".density.type: unknown variant `noise`, expected `height` or `grid`");
    density(json!({"type": "height", "y0": 0}), ".density: missing field `scale`");
    density(
        json!({"type": "height", "y0": 0, "scale": 0}),
        ".density: density: y0 must be finite and scale finite and positive",
    );
}
