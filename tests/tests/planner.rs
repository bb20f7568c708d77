//! What `render` chooses by itself, and whether the error that was asked for is met.
#![expect(clippy::unwrap_used, reason = "test code")]

use airlight_tests::cli::Desk;
use airlight_tests::glb::Glb;
use serde_json::{Value, json};

/// Renders with `arguments`; what `--json` says.
fn rendered(desk: &Desk, arguments: &str) -> Value {
    desk.done(&format!("render {arguments} -o out/a.npy --json out/a.json"));
    serde_json::from_str(&std::fs::read_to_string(desk.path("out/a.json")).unwrap()).unwrap()
}

/// What was chosen for a target is there, said and met.
fn meets(said: &Value, target: f64) {
    let plan = &said["plan"];
    assert_eq!(plan["target_error"], target, "{plan}");
    assert_eq!(plan["technique"], said["technique"], "{plan}");
    assert_eq!(plan["measured_ms"], said["ms"], "{plan}");
    let (found, most) =
        (plan["predicted_error"].as_f64().unwrap(), plan["predicted_error_at_most"].as_f64().unwrap());
    assert!(found <= most && most <= target, "{plan}");
    assert!(said["error"]["shadow_err"].as_f64().unwrap() <= target, "{}: {plan}", said["error"]);
    assert_eq!(
        plan["reasons"].as_array().unwrap().len(),
        said["lights"].as_u64().unwrap() as usize,
        "{plan}"
    );
}

#[test]
fn targets_are_met_on_a_gpu() {
    let Some(desk) = Desk::with_working_gpu() else { return };
    let mut chosen = Vec::new();
    for (scene, target) in [
        ("procedural:slats", 0.05),
        ("procedural:slats --directional-light 0.3,-1,0.1:5", 0.02),
        ("procedural:sphere --spot-light 0,3,1:0,0.5,0:20:30:80", 0.01),
        ("procedural:lampshade", 1e-5),
    ] {
        let said = rendered(
            &desk,
            &format!("{scene} --size 96x64 --backend gpu --target-error {target} --against exact"),
        );
        meets(&said, target);
        chosen.push(said["plan"]["backend"].clone());
    }
    // no map is as fine as that
    assert_eq!(chosen, ["gpu", "gpu", "gpu", "cpu"]);
}

#[test]
fn targets_are_met_on_the_cpu() {
    let desk = Desk::default();
    let mut chosen = Vec::new();
    for (scene, target) in [
        ("procedural:hall --size 96x64", 0.05),
        ("procedural:sphere --size 96x64 --spot-light 0,3,1:0,0.5,0:20:30:80", 0.01),
        ("procedural:lampshade --size 48x32", 1e-5),
    ] {
        let arguments = format!("{scene} --backend cpu --target-error {target} --against exact");
        let said = rendered(&desk, &arguments);
        meets(&said, target);
        assert_eq!(said["plan"]["backend"], "cpu");
        chosen.push(said["technique"] == "exact");
    }
    // there is something faster than the reference, on one of them even on a busy machine, unless no map is fine enough
    assert!(chosen.contains(&false) && chosen[2], "{chosen:?}");
    // who asks for no error gets none
    let said = rendered(&desk, "procedural:slats --size 48x32 --backend cpu");
    assert_eq!(said["technique"], "exact");
}

#[test]
fn a_picture_is_not_compared_with_what_it_left_out_itself() {
    let Some(desk) = Desk::with_working_gpu() else { return };
    let said = rendered(
        &desk,
        "procedural:hall --size 256x256 --airlight-only --backend gpu --technique exact-shadow-map --shadow-map 64 \
         --target-error 0.5 --against exact-shadow-map",
    );
    assert!(said["plan"]["sampling"]["adaptive"].is_object(), "{}", said["plan"]);
    // without interpolation it would be rounding, some 1e-6
    let error = said["error"]["shadow_err"].as_f64().unwrap();
    assert!((1e-4..=0.5).contains(&error), "{}", said["error"]);
}

#[test]
fn without_a_target_it_is_one_percent() {
    let Some(desk) = Desk::with_working_gpu() else { return };
    let said = rendered(&desk, "procedural:slats --size 48x48 --backend gpu --against exact");
    meets(&said, 0.01);
    let said = rendered(&desk, "procedural:empty --size 16x16 --backend gpu --against exact");
    // nothing is in shadow, so there is no share of it either
    assert!(said["plan"]["predicted_error_at_most"].as_f64().unwrap() <= 0.01, "{said}");
    assert!(said["plan"]["reasons"][0].as_str().unwrap().contains("no occluder"), "{}", said["plan"]);
}

#[test]
fn a_technique_that_is_asked_for_gets_settings_that_meet_the_target() {
    let desk = Desk::default();
    for (technique, target) in [
        ("brute-force", 0.02),
        ("brute-force --visibility map", 0.05),
        ("hybrid --visibility map", 0.02),
        ("exact-shadow-map", 0.01),
        ("light-volume", 0.02),
    ] {
        let scene = "procedural:sphere --size 64x64 --airlight-only";
        let said = rendered(
            &desk,
            &format!("{scene} --technique {technique} --target-error {target} --against exact"),
        );
        meets(&said, target);
        assert!(technique.starts_with(said["technique"].as_str().unwrap()), "{said}");
    }
    // what is given stays, and what then cannot be met is said
    let ended = desk.done(
        "render procedural:sphere --size 64x64 -o out/b.npy --technique brute-force --samples 8 --target-error 1e-4",
    );
    assert!(ended.stderr.contains("--target-error 0.0001"), "{}", ended.stderr);
    let ended = desk
        .done("render procedural:sphere --size 16x16 -o out/b.npy --technique froxel --target-error 0.01");
    assert!(ended.stderr.contains("--target-error: no use for it in froxel"), "{}", ended.stderr);
}

#[test]
fn what_has_no_exact_picture_is_marched_until_it_converges() {
    let desk = Desk::default();
    let medium = json!({"sigma_s": [0.1, 0.1, 0.2], "sigma_a": [0, 0.05, 0],
                        "density": {"type": "height", "y0": 0, "scale": 2}});
    desk.write(
        "foggy.glb",
        Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = medium).bytes(),
    );
    let scene = "foggy.glb --size 32x32 --airlight-only --point-light 0.3,2,0.1:9";
    let said = rendered(&desk, &format!("{scene} --target-error 0.1"));
    let plan = &said["plan"];
    assert_eq!(said["technique"], "brute-force", "{plan}");
    let samples = plan["samples"].as_u64().unwrap();
    assert!(plan["predicted_error_at_most"].as_f64().unwrap() <= 0.1 && samples >= 8, "{plan}");
    std::fs::rename(desk.path("out/a.npy"), desk.path("out/chosen.npy")).unwrap();
    desk.done(&format!("render {scene} --technique brute-force --samples 8000 -o out/fine.npy"));
    desk.done(&format!("render {scene} --technique brute-force --samples 8000 --unshadowed -o out/open.npy"));
    let found: Value = serde_json::from_str(
        &desk.done("compare out/chosen.npy out/fine.npy --unshadowed out/open.npy").stdout,
    )
    .unwrap();
    assert!(found["shadow_err"].as_f64().unwrap() <= 0.1, "{found}");
}

#[test]
fn many_viewers_share_a_grid() {
    let desk = Desk::default();
    let said = rendered(&desk, "procedural:slats --size 32x32 --viewers 3");
    assert_eq!(said["technique"], "shared-grid", "{said}");
    assert!(said["plan"]["reasons"][0].as_str().unwrap().contains("3 viewers"), "{said}");
}
