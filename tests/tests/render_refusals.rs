//! What `render` refuses: flags, scenes and combinations that make no sense, with exit code 2 and a single line on stderr.

use airlight_tests::cli::{Desk, OUT, all_right};
use airlight_tests::glb::Glb;
use serde_json::{Value, json};

/// A render of a scene that needs nothing else, in a moment.
const RENDER: &str = "render procedural:triangle --size 8x6 -o out/a.npy";

/// Part of the name of no adapter.
const NO_ADAPTER: &str = "abacus";

#[test]
fn flags_of_render() {
    let desk = Desk::default();
    let bad = [
        ("--size", vec!["0x0", "99999999x1", "12", "axb", "8x", "-8x8", "8x8x8", "1e3x2"]),
        ("--technique", vec!["nonsense", "Exact"]),
        ("--backend", vec!["cuda"]),
        ("--adapter", vec![NO_ADAPTER]),
        ("--visibility", vec!["eyes", "Map"]),
        ("--map-surface", vec!["bumpy"]),
        ("--camera", vec!["nope", "1", "-1"]),
        ("--fov", vec!["0", "180", "-10", "nan", "inf", "wide"]),
        ("--sigma-s", vec!["-0.1", "nan", "inf", "1,2", "1,2,3,4", "0.1,-0.1,0.1", "fog"]),
        ("--sigma-a", vec!["-0.1", "nan", "1,2"]),
        ("--phase", vec!["hg:1", "hg:-1", "hg:-1.2", "hg:nan", "hg", "mie", "rayleigh-mie:0.5:1.5"]),
        ("--model", vec!["moon"]),
        (
            "--point-light",
            vec!["0,1,0:-5", "0,1,0:nan", "0,1,0:inf", "0,1:5", "0,1,0", "nan,1,0:5", "0,1,0:1,2"],
        ),
        (
            "--spot-light",
            vec![
                "0,1,2:0,0,2:20:10:1",
                "0,1,2:0,0,2:10:90:1",
                "0,1,2:0,0,2:-1:20:1",
                "0,1,2:0,1,2:10:20:1",
                "0,1,2:0,0,2:10:20:-1",
                "0,1,2:0,0,2:10:nan:1",
                "0,1,2:0,0,2:10:1",
            ],
        ),
        ("--directional-light", vec!["0,0,0:1", "0,-1,0:-1", "0,-1,0:nan", "0,-1:1", "0,inf,0:1"]),
        ("--light-texture", vec!["absent.png"]),
        ("--samples", vec!["0", "-1", "many", "99999999999"]),
        ("--shadow-map", vec!["0", "-1", "16385", "64x64", "large"]),
        ("--max-distance", vec!["0", "-1", "nan", "far"]),
        ("--exposure", vec!["nan", "inf", "bright"]),
        ("--scattering-scale", vec!["3", "0"]),
        ("--against", vec!["nonsense"]),
        (
            "--tessellation",
            vec![
                "nonsense",
                "Static",
                "static:1",
                "adaptive:0",
                "adaptive:-1",
                "adaptive:nan",
                "adaptive:inf",
                "adaptive:",
                "adaptive:1:2",
                "delaunay:0",
                "delaunay:fine",
            ],
        ),
        ("--json", vec!["absent/a.json", "out"]),
    ];
    let each = bad.into_iter().flat_map(|(flag, values)| values.into_iter().map(move |value| (flag, value)));
    all_right(each.map(|(flag, value)| {
        desk.misrefused(&format!("{RENDER} {flag} {value}"), flag_or_file(flag, value))
    }));
    all_right([
        desk.misrefused(&format!("{RENDER} --eye 1,2,3"), "--target"),
        desk.misrefused(&format!("{RENDER} --target 1,2,3"), "--eye"),
        desk.misrefused(&format!("{RENDER} --up 0,1,0"), "--eye"),
        desk.misrefused(&format!("{RENDER} --eye 1,2,3 --target 1,2,3"), "--eye"),
        desk.misrefused(&format!("{RENDER} --eye 1,2,3 --target 1,5,3"), "--up"),
        desk.misrefused(&format!("{RENDER} --eye 1,2,nan --target 1,5,3"), "--eye"),
        desk.misrefused(&format!("{RENDER} --eye 1,2 --target 1,5,3"), "--eye"),
        desk.misrefused(&format!("{RENDER} --eye 1,2,3 --target 0,0,0 --up 0,0,0"), "--up"),
        desk.misrefused(&format!("{RENDER} --eye 1,2,3 --target 0,0,0 --camera 0"), "--camera"),
    ]);
}

/// What the message must name: the value where that is a file.
fn flag_or_file<'a>(flag: &'a str, value: &'a str) -> &'a str {
    if matches!(flag, "--json" | "--light-texture") { value } else { flag }
}

#[test]
fn scenes_that_make_no_sense() {
    let desk = Desk::default();
    let good = Glb::triangle();
    let whole = good.bytes();
    let light = |intensity: Value| good.clone().with_light(json!({"type": "point", "intensity": intensity}));
    let medium = |medium: Value| good.clone().with(|json| json["scenes"][0]["extras"]["medium"] = medium);
    let corner = |x: f32| Glb::of_positions(&[[x, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("empty.glb", Vec::new()),
        ("half-a-header.glb", whole[..9].to_vec()),
        ("truncated-in-json.glb", whole[..100].to_vec()),
        ("truncated-in-bin.glb", whole[..whole.len() - 20].to_vec()),
        ("garbage.glb", (0..4000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()),
        ("garbage.gltf", b"{\"asset\": ".to_vec()),
        ("no-buffer.gltf", good.gltf("absent.bin").into_bytes()),
        ("nan.glb", corner(f32::NAN).bytes()),
        ("infinite.glb", corner(f32::NEG_INFINITY).bytes()),
        ("index.glb", {
            let mut glb = good.clone();
            glb.bin[40] = 7;
            glb.bytes()
        }),
        ("accessor.glb", good.clone().with(|json| json["accessors"][0]["count"] = 4.into()).bytes()),
        (
            "accessor-huge.glb",
            good.clone().with(|json| json["accessors"][1]["count"] = u64::MAX.into()).bytes(),
        ),
        ("view.glb", good.clone().with(|json| json["bufferViews"][1]["byteLength"] = 600.into()).bytes()),
        ("cycle.glb", good.clone().with(|json| json["nodes"][0]["children"] = json!([0])).bytes()),
        ("light-negative.glb", light((-5).into()).bytes()),
        ("light-text.glb", light("bright".into()).bytes()),
        ("medium-negative.glb", medium(json!({"sigma_s": [-0.1, 0.1, 0.1], "sigma_a": [0, 0, 0]})).bytes()),
        ("medium-short.glb", medium(json!({"sigma_s": [0.1, 0.1], "sigma_a": [0, 0, 0]})).bytes()),
        (
            "medium-g.glb",
            medium(
                json!({"sigma_s": [0.1, 0.1, 0.1], "sigma_a": [0, 0, 0], "phase": {"type": "hg", "g": 1.0}}),
            )
            .bytes(),
        ),
    ];
    for (name, bytes) in &files {
        desk.write(name, bytes);
    }
    let names = files.iter().map(|(name, _)| *name).chain(["absent.glb", "absent.gltf", OUT]);
    all_right(names.map(|name| desk.misrefused(&format!("render {name} --size 8x8 -o out/a.npy"), name)));
    all_right([
        desk.misrefused("render procedural:teapot --size 8x8 -o out/a.npy", "teapot"),
        desk.misrefused("render procedural: --size 8x8 -o out/a.npy", "procedural"),
        desk.misrefused_words(["render", "", "-o", "out/a.npy"], "a scene without a name", "error"),
    ]);
}

/// What is said on the way, of defaults and of flags without use, must not come before an error.
#[test]
fn a_refusal_is_the_only_line() {
    let desk = Desk::default();
    // neither camera nor light nor medium: three lines on stderr if all goes well
    desk.write("bare.glb", Glb::triangle().bytes());
    // a note: the light's range is ignored
    let light = json!({"type": "point", "intensity": 5, "range": 3});
    desk.write("noted.glb", Glb::triangle().with_light(light).bytes());
    let glowing = json!({"sigma_s": [0.1, 0.1, 0.1], "sigma_a": [0, 0, 0], "emission": [1, 1, 1]});
    let glowing = Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = glowing);
    desk.write("glowing.glb", glowing.bytes());
    let foggy = json!({"sigma_s": [0.1, 0.1, 0.1], "sigma_a": [0, 0, 0],
                       "density": {"type": "height", "y0": 0, "scale": 2}});
    let foggy = Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = foggy);
    desk.write("foggy.glb", foggy.bytes());
    let render = |rest: &str| format!("render {rest} --size 8x8 -o out/a.npy");
    all_right([
        // a map too large, after flags without use, and for the second of two pictures
        desk.misrefused(
            &render("bare.glb --technique brute-force --visibility map --shadow-map 16384 --viewers 3"),
            "--shadow-map 16384",
        ),
        desk.misrefused(
            &render("bare.glb --against exact-shadow-map --shadow-map 16384"),
            "--shadow-map 16384",
        ),
        desk.misrefused(&render("bare.glb --technique shared-grid --voxel-size 1e-9"), "--voxel-size"),
        desk.misrefused(&render("bare.glb --against shared-grid --voxel-size 1e-9"), "--voxel-size"),
        desk.misrefused(&render("glowing.glb --technique hybrid"), "hybrid cannot take an emitting medium"),
        desk.misrefused(
            &render("foggy.glb --technique hybrid"),
            "hybrid cannot take a heterogeneous density",
        ),
        desk.misrefused(&render("foggy.glb --against hybrid"), "--against"),
        desk.misrefused(
            &render("bare.glb --technique hybrid --model hoffman-preetham --point-light 0,2,0:9"),
            "hybrid cannot take Hoffman",
        ),
        desk.misrefused(
            &render("bare.glb --technique hybrid --visibility map --shadow-map 1 --map-surface linear"),
            "--shadow-map",
        ),
        desk.misrefused(&render("bare.glb --light-texture absent.png"), "absent.png"),
        desk.misrefused(
            &render("bare.glb --sigma-s 1 --technique shared-grid --voxel-size 1e-9"),
            "--voxel-size",
        ),
        desk.misrefused(&render("noted.glb --camera nope"), "--camera"),
        desk.misrefused(&render("noted.glb --technique shared-grid --voxel-size 1e-9"), "--voxel-size"),
        desk.misrefused(&render("glowing.glb --technique exact"), "exact"),
        desk.misrefused(&render("glowing.glb --technique exact-shadow-map"), "exact-shadow-map cannot take"),
        desk.misrefused(&render("glowing.glb --against exact-shadow-map"), "--against"),
        desk.misrefused(&render("foggy.glb --technique exact-shadow-map"), "exact-shadow-map cannot take"),
        desk.misrefused(
            &render("bare.glb --technique exact-shadow-map --shadow-map 1 --map-surface linear"),
            "--shadow-map",
        ),
        desk.misrefused(
            &render("bare.glb --technique brute-force --visibility map --shadow-map 1 --map-surface linear"),
            "--shadow-map",
        ),
        desk.misrefused(
            &render("bare.glb --against exact-shadow-map --shadow-map 1 --map-surface linear"),
            "--shadow-map",
        ),
        // flags without use are not said before
        desk.misrefused(
            &render("procedural:triangle --technique shared-grid --samples 5 --voxel-size 1e-9"),
            "--voxel-size",
        ),
    ]);
}

#[test]
fn what_a_light_volume_cannot_take() {
    let desk = Desk::default();
    let medium = |extra: Value| {
        let mut medium = json!({"sigma_s": [0.1, 0.1, 0.1], "sigma_a": [0, 0, 0]});
        medium.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        Glb::triangle().with(|json| json["scenes"][0]["extras"]["medium"] = medium).bytes()
    };
    let files = [
        ("bounded.glb", json!({"bounds": {"min": [-2, -1, -2], "max": [2, 2, 2]}}), "a bounded medium"),
        ("glowing.glb", json!({"emission": [1, 1, 1]}), "an emitting medium"),
        ("foggy.glb", json!({"density": {"type": "height", "y0": 0, "scale": 2}}), "a heterogeneous density"),
    ];
    let render = |rest: &str| format!("render {rest} --size 8x8 --shadow-map 16 -o out/a.npy");
    for (name, extra, feature) in files {
        desk.write(name, medium(extra));
        let wanted = format!("light-volume cannot take {feature}; use brute-force");
        all_right([
            desk.misrefused(&render(&format!("{name} --technique light-volume")), &wanted),
            desk.misrefused(
                &render(&format!("{name} --technique brute-force --against light-volume")),
                &wanted,
            ),
        ]);
    }
    desk.done("render procedural:triangle --size 8x8 -o texture.png");
    let spot = "--spot-light 0.5,2.5,2:0,0.5,0:20:30:9";
    all_right([
        desk.misrefused(
            &render(&format!(
                "procedural:triangle --technique light-volume {spot} --light-texture texture.png"
            )),
            "light-volume cannot take a textured spot light; use brute-force",
        ),
        desk.misrefused(
            &render("procedural:triangle --technique light-volume --model hoffman-preetham"),
            "light-volume cannot take Hoffman and Preetham's model for a local light",
        ),
        // a cube has no Delaunay triangles
        desk.misrefused(
            &render("procedural:triangle --technique light-volume --tessellation delaunay"),
            "--tessellation",
        ),
        desk.misrefused(
            &render("procedural:triangle --against light-volume --tessellation delaunay:0.1"),
            "--tessellation",
        ),
        desk.misrefused(
            "render procedural:triangle --technique light-volume --size 8x8 --shadow-map 1 -o out/a.npy",
            "--shadow-map",
        ),
    ]);
    // a single image has
    desk.done(&render(&format!(
        "procedural:triangle --technique light-volume {spot} --tessellation delaunay"
    )));
}
