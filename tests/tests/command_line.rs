//! The command line's contract: exit codes, messages, and files that are whole or absent.
//!
//! Bad input ends with exit code 2 and a single line on stderr that starts with `error:` and names the file or flag.
#![expect(clippy::panic, reason = "helpers of tests, which clippy does not take for tests")]

use airlight_tests::cli::{Desk, NO_ADAPTER, OUT, all_right, json_of, keys};
use airlight_tests::glb::Glb;
use airlight_tests::picture::{read_npy, rel_rmse, write_npy};
use serde_json::{Value, json};

/// A render of a scene that needs nothing else, in a moment.
const RENDER: &str = "render procedural:triangle --size 8x6 -o out/a.npy";

#[test]
fn usage() {
    let desk = Desk::default();
    all_right([
        desk.misrefused("", "command"),
        desk.misrefused("paint", "paint"),
        desk.misrefused("--colour", "--colour"),
        desk.misrefused("render", "SCENE"),
        desk.misrefused("render procedural:triangle", "--output"),
        desk.misrefused(&format!("{RENDER} --colour"), "--colour"),
        desk.misrefused(&format!("{RENDER} procedural:wall"), "procedural:wall"),
        desk.misrefused(&format!("{RENDER} --size"), "--size"),
        desk.misrefused("compare a.npy", "<B>"),
        desk.misrefused("eval", "KIND"),
        desk.misrefused("repro --preset slow", "--preset"),
        desk.misrefused("bench --colour", "--colour"),
    ]);
    let help = desk.done("--help");
    assert!(help.stderr.is_empty() && help.stdout.contains("render"), "{help:?}");
    assert!(desk.done("render --help").stdout.contains("--airlight-only"), "help must know every flag");
    assert!(desk.done("--version").stdout.starts_with("cargo xtask"), "a version has a name");
}

#[test]
fn outputs_that_cannot_be_written() {
    let desk = Desk::default();
    desk.write("file", "not a folder");
    let base = "render procedural:triangle --size 8x6";
    all_right([
        desk.misrefused(&format!("{base} -o out.xyz"), "out.xyz"),
        desk.misrefused(&format!("{base} -o out/picture"), "out/picture"),
        desk.misrefused(&format!("{base} -o absent/a.png"), "absent/a.png"),
        desk.misrefused(&format!("{base} -o file/a.png"), "file/a.png"),
        desk.misrefused(&format!("{base} -o {OUT}"), OUT),
        desk.misrefused("eval f cases.json -o absent/a.json", "absent/a.json"),
        desk.misrefused("eval f cases.json -o file/a.json", "file/a.json"),
        desk.misrefused("repro airlight-accuracy --preset smoke --out file", "--out"),
    ]);
}

/// Only on Linux is Vulkan the one way to a GPU, which a desk can close.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_there_is_no_gpu_backend() {
    let desk = Desk::default();
    all_right([
        desk.misrefused(&format!("{RENDER} --backend gpu"), "--backend"),
        desk.misrefused("repro airlight-accuracy --backend gpu --out out/r", "--backend"),
    ]);
}

/// Drivers have their own views of what belongs on stderr; whoever reads ours is not to see them.
#[test]
fn a_gpu_adds_no_line() {
    let desk = Desk::with_gpu();
    let cases = airlight_tests::data("F_public.json");
    all_right([
        desk.misrefused("eval airlight absent.json -o out/x.json", "absent.json"),
        desk.misrefused(
            &format!("eval f {} -o out/x.json --adapter {NO_ADAPTER}", cases.display()),
            "--adapter",
        ),
        desk.misrefused(&format!("{RENDER} --adapter {NO_ADAPTER}"), "--adapter"),
        desk.misrefused(&format!("repro airlight-accuracy --adapter {NO_ADAPTER} --out out/r"), "--adapter"),
    ]);
    let ended = desk.done(&format!("eval f {} -o out/f.json", cases.display()));
    assert!(ended.said().is_empty(), "{}", ended.stderr);
}

#[test]
fn the_hybrid_is_nearer_to_the_exact_picture_than_the_march() {
    let desk = Desk::default();
    let error = |technique: &str| {
        let command = format!(
            "render procedural:sphere -o out/a.npy --size 32x32 --airlight-only --technique {technique} --against exact"
        );
        let found: Value = serde_json::from_str(&desk.done(&command).stdout).unwrap();
        found["shadow_err"].as_f64().unwrap()
    };
    let march = error("brute-force --samples 64");
    for rest in ["", " --visibility map --shadow-map 1024"] {
        let hybrid = error(&format!("hybrid --samples 16{rest}"));
        assert!(hybrid < 0.3 * march, "hybrid{rest} {hybrid}, march {march}");
    }
    // blocks of pixels are coarser, and still know where the shadows are
    let (half, quarter) = (
        error("hybrid --samples 16 --scattering-scale 2"),
        error("hybrid --samples 16 --scattering-scale 4"),
    );
    assert!(half < 0.5 && quarter < 0.8 && half > 1e-4 && quarter > half, "{half} {quarter}");
}

#[test]
fn strange_names_stay_on_one_line() {
    let desk = Desk::default();
    all_right([
        desk.misrefused_words(
            ["render", "a\nb.glb", "-o", "out/a.npy"],
            "line feed in a scene's name",
            "error",
        ),
        desk.misrefused_words(
            ["render", "a.glb", "-o", "out/a\n\nb"],
            "line feeds in an output's name",
            "error",
        ),
        desk.misrefused_words(
            ["render", "a.glb", "-o", "out/a.npy", "--size", "8\n\n8"],
            "line feeds in a size",
            "--size",
        ),
        desk.misrefused_words(["repro", "a\nb"], "line feed in an experiment's name", "error"),
    ]);
    #[cfg(unix)]
    {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;
        let name = OsStr::from_bytes(b"caf\xe9.glb");
        let words = ["render".as_ref(), name, "-o".as_ref(), "out/a.npy".as_ref()];
        all_right([desk.misrefused_words(words, "a name that is not UTF-8", "error")]);
    }
}

#[test]
fn eval_of_bad_files() {
    let desk = Desk::default();
    let public = std::fs::read_to_string(airlight_tests::data("airlight_public.json")).unwrap();
    desk.write("truncated.json", &public[..public.len() / 2]);
    desk.write("empty.json", "");
    let mut cases = json_of(&public);
    cases["cases"][3].as_object_mut().unwrap().remove("kappa_t");
    desk.write("missing.json", cases.to_string());
    let mut cases = json_of(&public);
    cases["cases"][5]["kappa_s"] = json!(-1.0);
    desk.write("negative.json", cases.to_string());
    let mut cases = json_of(&public);
    cases["cases"][5]["phase"] = json!({"type": "hg", "g": 1.5});
    desk.write("phase.json", cases.to_string());
    let files =
        ["absent.json", "truncated.json", "empty.json", "missing.json", "negative.json", "phase.json"];
    all_right(files.iter().map(|name| desk.misrefused(&format!("eval airlight {name} -o out/x.json"), name)));
    let wrong_schema = airlight_tests::data("F_public.json");
    all_right([
        desk.misrefused(&format!("eval airlight {} -o out/x.json", wrong_schema.display()), "F_public.json"),
        desk.misrefused("eval nonsense cases.json -o out/x.json", "nonsense"),
        desk.misrefused(
            &format!("eval f {} -o out/x.json --adapter {NO_ADAPTER}", wrong_schema.display()),
            "--adapter",
        ),
    ]);
}

#[test]
fn eval_of_the_reference_cases() {
    let desk = Desk::default();
    let files = [
        ("airlight", "airlight_public.json", vec!["cases"], vec!["f32", "f64", "gpu", "id"]),
        ("f", "F_public.json", vec!["F", "difference"], vec!["f32", "f64", "gpu"]),
        ("intervals", "multi_interval_public.json", vec!["rays"], vec!["f32", "f32_signed", "f64", "gpu"]),
        ("hoffman-preetham", "hoffman_preetham_public.json", vec!["cases"], vec!["f_ex", "l", "l_in"]),
    ];
    for (kind, file, lists, fields) in files {
        let path = airlight_tests::data(file);
        let cases = json_of(&std::fs::read_to_string(&path).unwrap());
        let count: usize = lists.iter().map(|list| cases[list].as_array().map_or(0, Vec::len)).sum();
        let ended = desk.done(&format!("eval {kind} {} -o out/{kind}.json", path.display()));
        assert!(ended.stdout.is_empty() && ended.stderr.is_empty(), "{ended:?}");
        let results = json_of(&std::fs::read_to_string(desk.path(&format!("out/{kind}.json"))).unwrap());
        let results = results.as_array().unwrap_or_else(|| panic!("{kind}: not an array"));
        assert!(count > 0 && results.len() == count, "{kind}: {} results of {count} cases", results.len());
        for result in results {
            let mut found = keys(result);
            found.sort_unstable();
            assert_eq!(found, fields, "{kind}");
        }
        if kind == "airlight" {
            let first = &cases["cases"][0];
            assert_eq!(results[0]["id"], first["id"], "results come in the order of the cases");
            let (got, exact) = (results[0]["f64"].as_f64(), first["foot"]["value"].as_f64());
            assert!((got.unwrap() / exact.unwrap() - 1.0).abs() < 1e-12, "{got:?} {exact:?}");
        }
    }
    assert_eq!(desk.outputs(), ["airlight.json", "f.json", "hoffman-preetham.json", "intervals.json"]);
}

#[test]
fn pictures_by_extension() {
    let desk = Desk::default();
    let base = "render procedural:triangle --size 8x6";
    for extension in ["npy", "png", "exr", "PNG"] {
        let ended = desk.done(&format!("{base} -o out/a.{extension}"));
        // a scene with camera, light and medium: nothing is assumed, so nothing is said
        assert!(ended.stdout.is_empty() && ended.said().is_empty(), "{ended:?}");
    }
    assert_eq!(desk.outputs(), ["a.PNG", "a.exr", "a.npy", "a.png"]);
    let (pixels, size) = read_npy(&desk.path("out/a.npy"));
    assert_eq!(size, (8, 6));
    assert!(pixels.as_flattened().iter().all(|v| v.is_finite()), "a value is not finite");
    assert!(pixels.as_flattened().iter().any(|v| *v > 0.0), "the picture is black");
    let same = json_of(&desk.done("compare out/a.npy out/a.exr").stdout);
    assert_eq!(same["max_abs"], 0.0, "{same}");
    let png = std::fs::read(desk.path("out/a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"), "no PNG");
    desk.done(&format!("{base} -o out/bright.png --exposure 3"));
    assert_ne!(png, std::fs::read(desk.path("out/bright.png")).unwrap(), "exposure changes nothing");
    assert_eq!(read_npy(&desk.path("out/a.npy")).0, pixels, "a second picture changed the first");
}

#[test]
fn without_triangles_everything_is_lit() {
    let desk = Desk::default();
    for technique in
        ["exact", "brute-force", "exact-shadow-map", "brute-force --visibility map", "light-volume"]
    {
        let base = format!("render procedural:empty --size 9x9 --technique {technique}");
        // the largest map there is costs nothing where nothing is drawn into it
        desk.done(&format!("{base} --shadow-map 16384 -o out/shadowed.npy --json out/a.json"));
        assert!(map_of(&desk).is_null(), "{technique}: a map without triangles");
        desk.done(&format!("{base} --unshadowed -o out/lit.npy"));
        let (a, b) = (read_npy(&desk.path("out/shadowed.npy")).0, read_npy(&desk.path("out/lit.npy")).0);
        assert_eq!(a, b, "{technique}");
    }
    desk.done(&format!("{RENDER} --airlight-only"));
    desk.done("render procedural:triangle --size 8x6 --airlight-only --unshadowed -o out/lit.npy");
    let (a, b) = (read_npy(&desk.path("out/a.npy")).0, read_npy(&desk.path("out/lit.npy")).0);
    assert!(a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| a <= b), "a shadow adds light");
    assert_ne!(a, b, "--unshadowed changes nothing");
}

#[test]
fn pictures_by_light_volumes() {
    let desk = Desk::default();
    let base = "render procedural:slats --size 24x18 --airlight-only --shadow-map 128 --json out/a.json";
    for (light, flag) in [
        ("point", ""),
        ("spot", "--spot-light -0.4,2.6,-2:0.2,0.9,1:20:29:20"),
        ("directional", "--directional-light 0.2,-0.6,1:3"),
    ] {
        let mut triangles = Vec::new();
        // Delaunay triangles keep to the nodes alone: where a cell lies across an edge, either diagonal is right
        for (tessellation, most) in
            [("static", 1e-6), ("adaptive:1e-5", 1e-3), ("adaptive", 0.1), ("delaunay:1e-3", 0.1)]
        {
            if light == "point" && tessellation.starts_with("delaunay") {
                continue;
            }
            let ended = desk.done(&format!(
                "{base} -o out/a.npy {flag} --technique light-volume --tessellation {tessellation} --map-surface linear --against exact-shadow-map"
            ));
            assert!(ended.said().is_empty(), "{}", ended.stderr);
            let error = json_of(&ended.stdout)["shadow_err"].as_f64().unwrap_or(f64::NAN);
            assert!(error < most, "{light}, {tessellation}: {error}");
            let said = json_of(&std::fs::read_to_string(desk.path("out/a.json")).unwrap());
            triangles.push(said["mesh_triangles"].as_u64().unwrap_or(0));
            assert_eq!(said["shadow_map"]["surface"], "linear", "{said}");
        }
        // none is finer than the one before, but for the last
        println!("{light}: {triangles:?}");
        assert!(
            triangles[0] > triangles[1] && triangles[1] >= triangles[2] && triangles[2] > 0,
            "{triangles:?}"
        );
    }
    // the linear meaning is the only one
    desk.done(&format!("{base} -o out/b.npy --technique light-volume"));
    desk.done(&format!("{base} -o out/a.npy --technique light-volume --map-surface linear"));
    assert_eq!(read_npy(&desk.path("out/a.npy")).0, read_npy(&desk.path("out/b.npy")).0);
    let ended =
        desk.done(&format!("{base} -o out/b.npy --technique light-volume --map-surface step --samples 3"));
    assert_eq!(ended.said().len(), 2, "{}", ended.stderr);
    assert_eq!(read_npy(&desk.path("out/a.npy")).0, read_npy(&desk.path("out/b.npy")).0);
    // nothing casts a shadow: no mesh
    desk.done(&format!("{base} -o out/a.npy --technique light-volume --unshadowed"));
    let said = json_of(&std::fs::read_to_string(desk.path("out/a.json")).unwrap());
    assert!(said["shadow_map"].is_null() && said["mesh_triangles"] == 0, "{said}");
}

/// What the last render says of its shadow map.
fn map_of(desk: &Desk) -> Value {
    let text = std::fs::read_to_string(desk.path("out/a.json"));
    let said = json_of(&text.unwrap_or_else(|e| panic!("out/a.json: {e}")));
    let passes = said["passes"].as_array().cloned().unwrap_or_default();
    let drawn = passes.iter().any(|pass| pass["name"] == "shadow map" && pass["ms"].is_number());
    assert_eq!(drawn, said["ms_map"].is_number(), "{said}");
    assert_eq!(drawn, !said["shadow_map"].is_null(), "{said}");
    said["shadow_map"].clone()
}

#[test]
fn pictures_by_shadow_maps() {
    let desk = Desk::default();
    let base = "render procedural:slats --size 24x18 --airlight-only --shadow-map 256 --json out/a.json";
    let lights = [
        ("point", ""),
        ("spot", "--spot-light -0.4,2.6,-2:0.2,0.9,1:20:29:20"),
        ("directional", "--directional-light 0.2,-0.6,1:3"),
    ];
    for (light, flag) in lights {
        for surface in ["step", "linear"] {
            let error = |technique: &str, against: &str| {
                let flags =
                    format!("--technique {technique} --map-surface {surface} --against {against} {flag}");
                let ended = desk.done(&format!("{base} -o out/a.npy {flags}"));
                assert!(ended.said().is_empty(), "{}", ended.stderr);
                let map = map_of(&desk);
                let faces = if light == "point" { 6 } else { 1 };
                assert_eq!(map["bytes"], faces * 256 * 256 * 4, "{map}");
                assert_eq!((&map["size"], &map["surface"]), (&json!(256), &json!(surface)), "{map}");
                json_of(&ended.stdout)["shadow_err"].as_f64().unwrap_or(f64::NAN)
            };
            let scene = error("exact-shadow-map", "exact");
            // thin slats against the sky: in the linear meaning the sun's map is a texel short of them
            assert!(scene > 0.0 && scene < 0.25, "{light}, {surface}: {scene} from exact");
            let march = error("brute-force --visibility map --samples 1000", "exact-shadow-map");
            assert!(march > 0.0 && march < 0.02, "{light}, {surface}: {march} from the traversal");
        }
    }
    // nothing casts a shadow: no map
    desk.done(&format!("{base} -o out/lit.npy --technique exact-shadow-map --unshadowed"));
    assert!(map_of(&desk).is_null());
    desk.done("render procedural:slats --size 24x18 --airlight-only --unshadowed -o out/exact.npy");
    assert_eq!(read_npy(&desk.path("out/lit.npy")).0, read_npy(&desk.path("out/exact.npy")).0);
}

#[test]
fn a_shadow_map_in_a_bounded_medium() {
    let desk = Desk::default();
    let medium = json!({"sigma_s": [0.1, 0.1, 0.1], "sigma_a": [0, 0, 0],
                        "bounds": {"min": [-2, -1, -2], "max": [2, 2, 2]}});
    desk.write(
        "bounded.glb",
        Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = medium).bytes(),
    );
    let flags = "--technique exact-shadow-map --against exact --airlight-only";
    let figures =
        json_of(&desk.done(&format!("render bounded.glb --size 16x16 -o out/a.npy {flags}")).stdout);
    assert!(figures["shadow_err"].as_f64() < Some(0.05), "{figures}");
}

#[test]
fn flags_without_use_are_said() {
    let desk = Desk::default();
    let map = "--visibility map --shadow-map 16 --map-surface linear";
    for (flags, said) in [
        (format!("--technique exact {map}"), vec!["--visibility", "--map-surface", "--shadow-map"]),
        (format!("--technique exact-shadow-map {map} --samples 9"), vec!["--visibility", "--samples"]),
        (format!("--technique brute-force {map} --samples 9"), vec![]),
        ("--technique brute-force --visibility bvh --shadow-map 16".into(), vec!["--shadow-map"]),
        ("--technique exact --against exact-shadow-map --shadow-map 16".into(), vec![]),
        (
            "--technique exact --against brute-force --samples 9 --map-surface step".into(),
            vec!["--map-surface"],
        ),
    ] {
        let ended = desk.done(&format!("{RENDER} {flags}"));
        let lines = ended.said();
        assert_eq!(lines.len(), said.len(), "{flags}: {}", ended.stderr);
        for flag in said {
            assert!(lines.iter().any(|line| line.contains(flag)), "{flags}: {}", ended.stderr);
        }
    }
}

#[test]
fn defaults_are_said() {
    let desk = Desk::default();
    desk.write("bare.glb", Glb::triangle().bytes());
    let ended = desk.done("render bare.glb --size 8x8 -o out/a.npy");
    for what in ["no camera", "no light", "no medium"] {
        assert!(ended.stderr.lines().any(|line| line.contains(what)), "{what}: {}", ended.stderr);
    }
    assert_eq!(ended.said().len(), 3, "{}", ended.stderr);
    assert!(ended.stdout.is_empty(), "{}", ended.stdout);
    let (pixels, _) = read_npy(&desk.path("out/a.npy"));
    assert!(pixels.as_flattened().iter().any(|v| *v > 0.0), "the picture is black");
    // the same file as .gltf with its buffer beside it
    let glb = Glb::triangle();
    desk.write("buffer 1.bin", &glb.bin);
    desk.write("bare.gltf", glb.gltf("buffer%201.bin"));
    desk.done("render bare.gltf --size 8x8 -o out/b.npy");
    assert_eq!(read_npy(&desk.path("out/b.npy")).0, pixels);
    // flags without use are said too, and cost nothing else
    let ended = desk.done(&format!("{RENDER} --samples 5 --voxel-size 3"));
    assert!(ended.stderr.contains("--samples") && ended.stderr.contains("--voxel-size"), "{}", ended.stderr);
}

#[test]
fn values_with_a_minus_sign() {
    let desk = Desk::default();
    let flags = "--eye -1,2,-3 --target -0.5,-1,-2 --up -0.1,1,0 --point-light -1,-2,-3:5 \
                 --spot-light -1,2,-3:-1,0,-3:10:20:1,2,3 --directional-light -1,-1,-1:0.5 --phase hg:-0.5 \
                 --exposure -1.5 --sigma-a 0,0.01,0.02 --fov 60 --max-distance 9 --model hoffman-preetham";
    let ended = desk.done(&format!("{RENDER} {flags}"));
    assert!(ended.said().is_empty(), "{}", ended.stderr);
    assert!(read_npy(&desk.path("out/a.npy")).0.as_flattened().iter().all(|v| v.is_finite()), "not finite");
}

#[test]
fn light_textures() {
    let desk = Desk::default();
    desk.done("render procedural:triangle --size 16x16 -o out/texture.png");
    desk.write("garbage.png", [7; 100]);
    let spot = "--spot-light 0.5,2.5,2:0,0.5,0:20:30:9";
    all_right([
        desk.misrefused(&format!("{RENDER} --light-texture out/texture.png"), "--light-texture"),
        desk.misrefused(&format!("{RENDER} {spot} --light-texture garbage.png"), "garbage.png"),
        desk.misrefused(&format!("{RENDER} {spot} --light-texture out"), "out"),
    ]);
    desk.done(&format!("{RENDER} {spot} --airlight-only"));
    let plain = read_npy(&desk.path("out/a.npy")).0;
    desk.done(&format!("{RENDER} {spot} --airlight-only --light-texture out/texture.png"));
    let textured = read_npy(&desk.path("out/a.npy")).0;
    let sum = |pixels: &[[f32; 3]]| pixels.as_flattened().iter().sum::<f32>();
    assert!(
        sum(&textured) > 0.0 && sum(&textured) < sum(&plain),
        "a picture in front of a light takes light away"
    );
}

#[test]
fn json_says_what_was_done() {
    let desk = Desk::default();
    let ended = desk.done(&format!("{RENDER} --technique brute-force --samples 7 --json out/a.json"));
    assert!(ended.stdout.is_empty(), "{}", ended.stdout);
    let said = json_of(&std::fs::read_to_string(desk.path("out/a.json")).unwrap());
    for key in ["adapter", "technique", "why", "passes", "triangles", "rays", "samples", "bytes"] {
        assert!(!said[key].is_null(), "{key} is missing: {said}");
    }
    for key in ["name", "backend", "kind"] {
        assert!(said["adapter"][key].is_string(), "adapter.{key}: {said}");
    }
    assert_eq!((&said["technique"], &said["triangles"]), (&json!("brute-force"), &json!(1)), "{said}");
    let passes = said["passes"].as_array().map_or(&[][..], Vec::as_slice);
    assert!(!passes.is_empty() && passes.iter().all(|pass| pass["ms"].is_number()), "{said}");
    assert!(said["bytes"].as_u64() > Some(0) && said["samples"].as_u64() > Some(0), "{said}");
    assert_eq!(desk.outputs(), ["a.json", "a.npy"]);
}

#[test]
fn against_prints_the_comparison() {
    let desk = Desk::default();
    let flags = "--technique brute-force --samples 16 --against exact --json out/a.json --airlight-only";
    let ended = desk.done(&format!("{RENDER} {flags}"));
    let figures = json_of(&ended.stdout);
    for key in ["rel_rmse", "shadow_err", "nmae", "p99", "max_abs", "flip"] {
        assert!(figures[key].as_f64() > Some(0.0), "{key}: {figures}");
    }
    assert_eq!(figures["nan"], 0, "{figures}");
    // the same figures as from the files
    desk.done("render procedural:triangle --size 8x6 --airlight-only -o out/exact.npy");
    desk.done("render procedural:triangle --size 8x6 --airlight-only --unshadowed -o out/lit.npy");
    let compared = json_of(&desk.done("compare out/a.npy out/exact.npy --unshadowed out/lit.npy").stdout);
    for key in keys(&compared) {
        assert_eq!(compared[key], figures[key], "{key}");
    }
    let outputs = desk.outputs();
    assert!(outputs.iter().any(|name| name.starts_with("a.") && name.ends_with(".png")), "{outputs:?}");
}

#[test]
fn comparisons() {
    let desk = Desk::default();
    let picture = |width: u32, value: f32| -> Vec<[f32; 3]> { vec![[value, 0.5, 1.0]; 2 * width as usize] };
    let store = |name: &str, width, value| write_npy(&desk.path(name), (width, 2), &picture(width, value));
    store("a.npy", 4, 1.0);
    store("brighter.npy", 4, 2.0);
    store("wide.npy", 5, 1.0);
    store("nan.npy", 4, f32::NAN);
    store("infinite.npy", 4, f32::INFINITY);
    desk.write("garbage.npy", [0x93; 200]);
    desk.write("empty.npy", "");
    desk.write("garbage.exr", [7; 200]);
    let whole = std::fs::read(desk.path("a.npy")).unwrap();
    desk.write("truncated.npy", &whole[..whole.len() - 4]);

    let same = desk.done("compare a.npy a.npy --unshadowed brighter.npy");
    assert!(same.stderr.is_empty(), "{}", same.stderr);
    let figures = json_of(&same.stdout);
    for key in ["rel_rmse", "nmae", "p99", "max_abs", "flip", "nan", "shadow_err"] {
        assert_eq!(figures[key].as_f64(), Some(0.0), "{key}: {figures}");
    }
    assert_eq!(same.stdout.lines().count(), 1, "one JSON object");
    let brighter = json_of(&desk.done("compare brighter.npy a.npy").stdout);
    let expected = rel_rmse(&picture(4, 2.0), &picture(4, 1.0));
    assert!((brighter["rel_rmse"].as_f64().unwrap() / expected - 1.0).abs() < 1e-12, "{brighter}");
    assert_eq!(brighter["max_abs"], 1.0, "{brighter}");
    assert!(brighter.get("shadow_err").is_none(), "{brighter}");

    for (broken, reference) in [("nan.npy", "a.npy"), ("a.npy", "nan.npy"), ("infinite.npy", "a.npy")] {
        let ended = desk.run(&format!("compare {broken} {reference}"));
        assert_eq!(ended.code, 1, "{ended:?}");
        assert_eq!(json_of(&ended.stdout)["nan"], 8, "{ended:?}");
        assert!(ended.stderr.starts_with("error: ") && ended.stderr.lines().count() == 1, "{ended:?}");
    }
    all_right([
        desk.misrefused("compare a.npy wide.npy", "wide.npy"),
        desk.misrefused("compare a.npy a.npy --unshadowed wide.npy", "wide.npy"),
        desk.misrefused("compare garbage.npy a.npy", "garbage.npy"),
        desk.misrefused("compare a.npy garbage.exr", "garbage.exr"),
        desk.misrefused("compare a.npy truncated.npy", "truncated.npy"),
        desk.misrefused("compare empty.npy a.npy", "empty.npy"),
        desk.misrefused("compare a.npy absent.npy", "absent.npy"),
        desk.misrefused("compare a.npy a.npy --mask absent.png", "absent.png"),
        desk.misrefused("compare a.npy a.npy --mask a.npy", "a.npy"),
        desk.misrefused("compare a.npy a.png", "a.png"),
        desk.misrefused("compare a.npy out", "out"),
    ]);
}

#[test]
fn doctor_has_something_to_say() {
    let desk = Desk::default();
    let ended = desk.done("doctor");
    assert!(ended.stdout.contains("processor"), "{}", ended.stdout);
}
