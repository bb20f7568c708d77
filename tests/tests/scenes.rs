//! `scenes`: what is said of a folder, and originals that become scenes.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use airlight_tests::cli::{Desk, all_right};
use airlight_tests::glb::Glb;
use scene::import::load_gltf;
use scene::{Scene, procedural};
use serde_json::json;

/// The only known mesh that can be generated here: a unit ball of 20,480 triangles on the ground.
const BALL: &str = "sphere_20k.glb";

fn ball() -> Scene {
    procedural::generate("sphere").unwrap()
}

/// The lines of a listing that say what became of files.
fn states(stdout: &str) -> Vec<&str> {
    stdout.lines().filter(|line| !line.starts_with(' ') && line.contains(".glb ")).collect()
}

/// As an artist may leave it: in centimetres, off the origin.
fn displaced(scene: &Scene) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mesh = &scene.meshes[0];
    let positions = mesh.positions().iter().map(|p| (100.0 * *p + 7.0).to_array()).collect();
    (positions, mesh.triangles().to_vec())
}

fn obj(scene: &Scene) -> String {
    let (positions, triangles) = displaced(scene);
    let vertices = positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = triangles.iter().map(|t| t.map(|i| i + 1)).map(|[a, b, c]| format!("f {a} {b} {c}\n"));
    vertices.chain(faces).collect()
}

fn ply(scene: &Scene) -> Vec<u8> {
    let (positions, triangles) = displaced(scene);
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    );
    let mut bytes = head.into_bytes();
    bytes.extend(positions.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

fn off(scene: &Scene) -> String {
    let (positions, triangles) = displaced(scene);
    let vertices = positions.iter().map(|[x, y, z]| format!("{x} {y} {z}\n"));
    let faces = triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
    let head = format!("OFF\n{} {} 0\n", positions.len(), triangles.len());
    std::iter::once(head).chain(vertices).chain(faces).collect()
}

fn stl(scene: &Scene) -> Vec<u8> {
    let (positions, triangles) = displaced(scene);
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        let corners = triangle.map(|index| positions[index as usize]);
        bytes.extend(corners.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn what_is_known_is_listed_without_a_folder() {
    let ended = Desk::default().done("scenes");
    let listed = ended.stdout.lines().filter(|line| !line.starts_with(' ') && line.ends_with(".glb")).count();
    assert_eq!(listed, 14, "{}", ended.stdout);
    for part in ["https://graphics.stanford.edu", "CC BY 4.0", "69451", "San Miguel", "procedural:blob-70k"] {
        assert!(ended.stdout.contains(part), "{part}");
    }
    assert_eq!(ended.said().len(), 1, "{}", ended.stderr);
}

#[test]
fn a_folder_is_compared_with_what_is_known() {
    let desk = Desk::default();
    std::fs::create_dir(desk.path("s")).unwrap();
    desk.write("s/bunny_70k.glb", Glb::triangle().bytes());
    desk.write("s/elephant_24k.glb", "no elephant");
    desk.write("s/own.glb", "abc");
    let digits = "BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD";
    let own = json!([{"file": "own.glb", "sha256": digits, "licence": "mine", "more": [1]}]);
    desk.write("s/manifest.json", own.to_string());
    let ended = desk.done("scenes --scenes s");
    let states = states(&ended.stdout);
    assert_eq!(states.len(), 15, "{}", ended.stdout);
    let of = |file: &str| {
        let line = states.iter().find(|line| line.starts_with(file)).unwrap_or_else(|| panic!("no {file}"));
        line[file.len()..].trim().to_owned()
    };
    assert_eq!(of("bunny_70k.glb"), "altered: 1 triangles in another box");
    assert!(of("elephant_24k.glb").starts_with("altered: "), "{}", of("elephant_24k.glb"));
    assert_eq!(of("own.glb"), "present; of manifest.json alone");
    assert_eq!(of(BALL), "missing");
    assert!(ended.stdout.contains("s: 0 of 14 known scenes present, 12 missing, 2 altered"));
}

#[test]
fn originals_become_scenes() {
    let ball = ball();
    let known = ball.bounds();
    for (name, bytes) in [
        ("ball.obj", obj(&ball).into_bytes()),
        ("a/b/Ball.PLY", ply(&ball)),
        ("x.stl", stl(&ball)),
        ("y.off", off(&ball).into_bytes()),
    ] {
        let desk = Desk::default();
        std::fs::create_dir_all(desk.path("o/a/b")).unwrap();
        desk.write(&format!("o/{name}"), bytes);
        desk.write("o/one.glb", Glb::triangle().bytes());
        desk.write("o/readme.txt", "no model");
        let ended = desk.done("scenes --originals o -o out/new");
        assert!(ended.stdout.contains("20480 triangles of 20480 known"), "{}", ended.stdout);
        assert!(
            ended.stdout.contains("o/one.glb: 1 triangles, the shape of no known scene"),
            "{}",
            ended.stdout
        );
        assert!(
            ended.stdout.contains("0 of 14 known scenes present, 13 missing, 1 altered"),
            "{}",
            ended.stdout
        );

        let made = load_gltf(&desk.path(&format!("out/new/{BALL}"))).unwrap();
        assert_eq!(made.triangle_count(), 20480, "{name}");
        assert_eq!(made.meshes[0].positions().len(), 10242, "{name}: vertices are shared");
        // corners in their places, in the order of the original
        let pairs = made.meshes[0].corners().zip(ball.meshes[0].corners());
        let off = pairs.flat_map(|(a, b)| [0, 1, 2].map(|i| a[i].distance(b[i]))).fold(0.0, f32::max);
        assert!(off < 1e-5 * known.diagonal(), "{name}: off by {off} m");

        // what is there already stays
        let again = desk.done("scenes --originals o -o out/new");
        assert!(again.stdout.contains("is there already"), "{}", again.stdout);
    }
}

/// All or nothing: one bad file, and none is written.
#[test]
fn bad_folders_and_files_are_refused() {
    let desk = Desk::default();
    for folder in ["o", "empty", "outside", "nonsense"] {
        std::fs::create_dir(desk.path(folder)).unwrap();
    }
    desk.write("file", "not a folder");
    desk.write("o/a.obj", obj(&ball()));
    desk.write("outside/manifest.json", json!([{"file": "../file", "sha256": ""}]).to_string());
    desk.write("nonsense/manifest.json", "[{]");
    all_right([
        desk.misrefused("scenes --scenes absent", "--scenes absent"),
        desk.misrefused("scenes --scenes file", "--scenes file"),
        desk.misrefused("scenes --scenes outside", "manifest.json"),
        desk.misrefused("scenes --scenes nonsense", "manifest.json"),
        desk.misrefused("scenes --originals o", "--output"),
        desk.misrefused("scenes -o out/new", "--originals"),
        desk.misrefused("scenes --originals absent -o out/new", "--originals absent"),
        desk.misrefused("scenes --originals empty -o out/new", "--originals empty"),
        desk.misrefused("scenes --originals o -o file", "--output file"),
        desk.misrefused("scenes --originals o -o file/new", "--output file/new"),
    ]);
    // what is wrong with a folder that is listed is said before anything is written
    all_right([desk.misrefused("scenes --originals o -o out/new --scenes nonsense", "manifest.json")]);
    for (name, text) in [
        ("b.obj", "v 0 0 0\nf 1 2 3\n"),
        ("b.ply", "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nend_header\n0\n"),
        ("b.stl", "solid b\nfacet\n"),
        ("c.3ds", "MM"),
        ("c.off", "OFF 1"),
        ("b.gltf", "{}"),
        ("b.glb", "glTF"),
    ] {
        desk.write(&format!("o/{name}"), text);
        all_right([desk.misrefused("scenes --originals o -o out/new", name)]);
        std::fs::remove_file(desk.path(&format!("o/{name}"))).unwrap();
    }
    // and without any of them it works, even if there is nothing to convert
    assert!(desk.done("scenes --originals o -o out/new").stdout.contains("1 altered"));
    desk.write("empty/one.glb", Glb::triangle().bytes());
    let ended = desk.done("scenes --originals empty -o out/none");
    assert!(ended.stdout.contains("14 missing") && !desk.path("out/none").exists(), "{}", ended.stdout);
}
