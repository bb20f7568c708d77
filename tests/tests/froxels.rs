//! Froxels and the shared grid from the command line: pictures, what is said of them, and what is refused.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use airlight_tests::cli::{Desk, all_right, json_of};
use airlight_tests::glb::Glb;
use airlight_tests::picture::read_npy;
use serde_json::{Value, json};

/// A scene with shadows in the air, in a moment.
const RENDER: &str = "render procedural:hall --size 48x32 --airlight-only";

/// The same with froxels enough to be compared with what is exact.
const LARGER: &str = "render procedural:hall --size 160x120 --airlight-only";

fn file_json(desk: &Desk, name: &str) -> Value {
    json_of(&std::fs::read_to_string(desk.path(name)).unwrap())
}

#[test]
fn pictures_come_close_to_the_exact_one() {
    let desk = Desk::default();
    for technique in ["froxel", "shared-grid"] {
        let ended = desk.done(&format!("{LARGER} -o out/a.npy --technique {technique} --against exact"));
        let figures = json_of(&ended.stdout);
        // means of squares are the lamp's glow, which a froxel next to it cannot have
        assert!(figures["nmae"].as_f64() < Some(0.15), "{technique}: {figures}");
        let ranges = ended.said().iter().filter(|line| line.contains("airlight ends")).count();
        assert_eq!(ranges, 1, "where froxels end is said once: {}", ended.stderr);
    }
    // the grid adds little to what froxels err by
    let ended = desk.done(&format!("{LARGER} -o out/a.npy --technique shared-grid --against froxel"));
    let figures = json_of(&ended.stdout);
    assert!(figures["shadow_err"].as_f64() < Some(0.1), "{figures}");
}

#[test]
fn froxels_and_what_they_are_compared_with_end_together() {
    let desk = Desk::default();
    let figures = |range: &str| {
        let flags =
            format!("-o out/a.npy --technique froxel --unshadowed --against exact --max-distance {range}");
        let ended = desk.done(&format!("{LARGER} {flags}"));
        json_of(&ended.stdout)["nmae"].as_f64().unwrap()
    };
    // nearer than any surface, and farther than all
    for range in ["2", "60"] {
        let error = figures(range);
        assert!(error < 0.05, "{range} m: {error}");
    }
}

#[test]
fn what_ran_is_said() {
    let desk = Desk::default();
    let run = |rest: &str| {
        desk.done(&format!("{RENDER} -o out/a.npy --json out/a.json {rest}"));
        file_json(&desk, "out/a.json")
    };
    let said = run("--technique shared-grid --voxel-size 0.5 --viewers 3");
    let froxels = &said["froxels"];
    assert_eq!((&froxels["viewers"], &froxels["voxel_size"]), (&json!(3), &json!(0.5)), "{said}");
    for key in ["froxels", "rays_near", "rays_grid", "voxels", "bytes"] {
        assert!(froxels[key].as_u64() > Some(0), "{key}: {froxels}");
    }
    for key in ["bricks", "missed", "dropped", "not_finite"] {
        assert_eq!(froxels[key], 0, "{key}: {froxels}");
    }
    let sum =
        froxels["rays_near"].as_u64().zip(froxels["rays_grid"].as_u64()).map(|(near, grid)| near + grid);
    assert_eq!(said["rays"].as_u64(), sum, "{said}");
    assert!(froxels["bytes"].as_u64() < said["bytes"].as_u64(), "{said}");
    let (pixels, _) = read_npy(&desk.path("out/a.npy"));

    // others look on, and change neither the picture nor each other's froxels
    let alone = run("--technique shared-grid --voxel-size 0.5");
    assert_eq!(read_npy(&desk.path("out/a.npy")).0, pixels);
    assert!(alone["froxels"]["froxels"].as_u64() < froxels["froxels"].as_u64(), "{alone}");
    assert!(alone["rays"].as_u64() < said["rays"].as_u64(), "{alone}");

    let reference = run("--technique froxel --viewers 3");
    assert_eq!(reference["froxels"]["froxels"], froxels["froxels"]);
    assert!(reference["froxels"]["voxel_size"].is_null());
    assert!(said["rays"].as_u64() < reference["rays"].as_u64(), "{said} {reference}");
    assert!(run("--technique exact")["froxels"].is_null());
}

#[test]
fn flags_that_make_no_sense() {
    let desk = Desk::default();
    let render = |rest: &str| format!("render procedural:triangle --size 8x6 -o out/a.npy {rest}");
    for voxel_size in ["0", "-1", "nan", "inf", "1e-60", "1e60", "small"] {
        let command = render(&format!("--technique shared-grid --voxel-size {voxel_size}"));
        all_right([desk.misrefused(&command, "--voxel-size")]);
    }
    for viewers in ["0", "-1", "257", "two", "1.5"] {
        let command = render(&format!("--technique shared-grid --viewers {viewers}"));
        all_right([desk.misrefused(&command, "--viewers")]);
    }
    let lamps = " --point-light 0,2,0:9".repeat(33);
    all_right([
        desk.misrefused(&render("--technique shared-grid --voxel-size 1e-9"), "--voxel-size"),
        desk.misrefused(&render("--against shared-grid --voxel-size 1e-9"), "--voxel-size"),
        desk.misrefused(&render(&format!("--technique froxel{lamps}")), "at most 32 lights"),
        desk.misrefused(&render(&format!("--against shared-grid{lamps}")), "--against shared-grid"),
    ]);
    let ended = desk.done(&render("--technique froxel --voxel-size 0.5 --viewers 2"));
    assert!(ended.stderr.contains("--voxel-size") && !ended.stderr.contains("--viewers"), "{}", ended.stderr);
}

#[test]
fn every_light_and_medium_has_a_picture() {
    let desk = Desk::default();
    desk.done("render procedural:triangle --size 8x8 -o texture.png");
    let spot = "--spot-light 0.5,2.5,2:0,0.5,0:20:30:9";
    let medium = |extra: Value| {
        let mut medium = json!({"sigma_s": [0.1, 0.1, 0.2], "sigma_a": [0, 0.05, 0]});
        medium.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = medium).bytes()
    };
    for (name, extra) in [
        ("plain.glb", json!({})),
        ("bounded.glb", json!({"bounds": {"min": [-2, -1, -2], "max": [2, 2, 2]}})),
        ("foggy.glb", json!({"density": {"type": "height", "y0": 0, "scale": 2}})),
        ("glowing.glb", json!({"emission": [1, 0.5, 0]})),
    ] {
        desk.write(name, medium(extra));
    }
    for technique in ["froxel", "shared-grid"] {
        for rest in [
            "plain.glb".to_owned(),
            format!("plain.glb {spot}"),
            format!("plain.glb {spot} --light-texture texture.png"),
            "plain.glb --directional-light 0.2,-1,0.1:5 --phase hg:0.6".to_owned(),
            "plain.glb --phase rayleigh-mie:0.7:0.3 --model hoffman-preetham".to_owned(),
            format!("plain.glb{}", " --point-light 0.3,2,0.1:9".repeat(9)),
            "bounded.glb".to_owned(),
            "bounded.glb --directional-light 0.2,-1,0.1:5".to_owned(),
            "foggy.glb".to_owned(),
            "glowing.glb".to_owned(),
            "procedural:empty".to_owned(),
        ] {
            desk.done(&format!("render {rest} --technique {technique} --size 16x16 -o out/a.npy"));
            let (pixels, _) = read_npy(&desk.path("out/a.npy"));
            let values = pixels.as_flattened();
            assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0), "{technique}, {rest}");
            assert!(values.iter().any(|v| *v > 0.0), "{technique}, {rest}: black");
        }
    }
}

#[test]
fn pictures_of_the_gpu_are_those_of_the_cpu() {
    let desk = Desk::with_gpu();
    let probe = "render procedural:slats -o out/probe.npy --size 4x4 --backend gpu --technique brute-force";
    let ended = desk.run(probe);
    if ended.code != 0 {
        assert!(std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but: {}", ended.stderr);
        println!("GPU test did not run: {}", ended.stderr);
        return;
    }
    for technique in [
        "froxel --viewers 2",
        "froxel --phase rayleigh-mie:0.6:0.3 --sigma-a 0.02,0,0.1 --directional-light 0.3,-0.8,0.2:5",
        "shared-grid --viewers 3",
        "shared-grid --voxel-size 0.5 --spot-light 0,3,0.5:0,0,0:30:40:80",
    ] {
        let mut said = Vec::new();
        for backend in ["gpu", "cpu"] {
            desk.done(&format!(
                "{RENDER} -o out/{backend}.npy --backend {backend} --technique {technique} --json out/{backend}.json"
            ));
            said.push(file_json(&desk, &format!("out/{backend}.json")));
        }
        let found = json_of(&desk.done("compare out/gpu.npy out/cpu.npy").stdout);
        assert!(found["rel_rmse"].as_f64() < Some(1e-3), "{technique}: {found}");
        for key in ["froxels", "rays_near", "not_finite"] {
            assert_eq!(said[0]["froxels"][key], said[1]["froxels"][key], "{technique}: {key}");
        }
        let rays = |said: &Value| said["froxels"]["rays_grid"].as_f64().unwrap();
        let (gpu, cpu) = (rays(&said[0]), rays(&said[1]));
        // a point on the face of two voxels may fall to either
        assert!((gpu - cpu).abs() <= 1e-3 * cpu, "{technique}: {gpu} {cpu}");
    }
}

#[test]
fn experiments_have_rows_and_claims() {
    let desk = Desk::default();
    let ids: Vec<String> = desk
        .done("repro --list")
        .stdout
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|id| id.starts_with("grid-"))
        .map(str::to_owned)
        .collect();
    assert!(ids.len() >= 13, "{ids:?}");
    desk.done(&format!("repro {} --preset smoke --out out/r", ids.join(" ")));
    for id in &ids {
        let data = file_json(&desk, &format!("out/r/{id}/data.json"));
        let list = |key: &str| data[key].as_array().cloned().unwrap_or_default();
        assert!(!list("rows").is_empty() && !list("checks").is_empty(), "{id}");
        for row in list("rows") {
            let timed = !row["ms_scatter"].is_null();
            assert_eq!(timed, !row["rel_rmse"].is_null(), "{id}: time and error stand together: {row}");
            assert!(row["viewers"].as_u64() > Some(0), "{id}: {row}");
        }
        for check in list("checks") {
            let claim = check["claim"].as_str().unwrap_or_default();
            // what holds at any size: nothing is negative, no number is none, nothing traces more than the reference
            let always = ["not finite", "shadow rays of the marked grid over"];
            if always.iter().any(|words| claim.contains(words)) {
                assert_eq!(check["holds"], true, "{id}: {check}");
            }
        }
    }
}
