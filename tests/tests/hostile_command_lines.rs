//! Random and hostile flags, and damaged files, for `render`: it draws the picture, or refuses in one line.
//!
//! `AIRLIGHT_FUZZ_COMMANDS` sets how many commands are tried.
#![allow(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use std::path::Path;

use airlight_tests::cli::{Desk, Ended};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::TestRunner;

/// Commands where nothing else is asked for.
const USUAL_COMMANDS: u32 = 96;

/// Generated scenes of few triangles, and names of none.
const SCENES: [&str; 9] = [
    "procedural:triangle",
    "procedural:triangle",
    "procedural:empty",
    "procedural:wall",
    "procedural:slats",
    "procedural:lampshade",
    "procedural:",
    "procedural:../triangle",
    "absent.glb",
];

/// Words that are no value of anything, or a strange one.
const HOSTILE: [&str; 24] = [
    "",
    " ",
    "-",
    "--",
    "--help",
    "nan",
    "inf",
    "-inf",
    "1e39",
    "-1e39",
    "1e-46",
    "0",
    "-0",
    "-1",
    "4294967296",
    "1,2",
    ",,",
    ":",
    "::::",
    "0x10",
    "１",
    "\u{202e}1",
    "..",
    "a\nb",
];

const NUMBERS: [&str; 12] =
    ["0", "1", "-1", "0.5", "1e-30", "1e30", "3e38", "-3e38", "1e-45", "1e15", "0.1", "90"];

/// A value that makes sense more often than not; `kind` says of what.
fn number() -> BoxedStrategy<String> {
    prop_oneof![
        4 => (-10.0..10.0_f32).prop_map(|value| value.to_string()),
        2 => select(&NUMBERS[..]).prop_map(str::to_owned),
        1 => any::<f32>().prop_map(|value| value.to_string()),
    ]
    .boxed()
}

fn triple() -> BoxedStrategy<String> {
    [number(), number(), number()].prop_map(|values| values.join(",")).boxed()
}

fn colour() -> BoxedStrategy<String> {
    let shade = || (0.0..20.0_f32).prop_map(|value| value.to_string());
    prop_oneof![3 => shade(), 1 => [shade(), shade(), shade()].prop_map(|c| c.join(",")), 1 => triple(), 1 => number()]
        .boxed()
}

fn joined(parts: Vec<BoxedStrategy<String>>) -> BoxedStrategy<String> {
    parts.prop_map(|parts| parts.join(":")).boxed()
}

fn words(words: &'static [&'static str]) -> BoxedStrategy<String> {
    select(words).prop_map(str::to_owned).boxed()
}

fn angle() -> BoxedStrategy<String> {
    prop_oneof![4 => (0.0..90.0_f32).prop_map(|value| value.to_string()), 1 => number()].boxed()
}

/// A flag with a value of its kind, or a hostile one; never one that asks for much work.
fn flag() -> impl Strategy<Value = Vec<String>> {
    const TECHNIQUES: &[&str] =
        &["exact", "exact-shadow-map", "brute-force", "hybrid", "light-volume", "froxel", "shared-grid"];
    let phases = prop_oneof![
        words(&["isotropic", "rayleigh", "hg", "rayleigh-mie:0.5"]),
        number().prop_map(|g| format!("hg:{g}")),
        (number(), number()).prop_map(|(g, share)| format!("rayleigh-mie:{g}:{share}")),
    ];
    let kinds: Vec<(&'static str, BoxedStrategy<String>)> = vec![
        ("--technique", words(TECHNIQUES)),
        ("--against", words(TECHNIQUES)),
        ("--backend", words(&["auto", "cpu", "gpu"])),
        ("--size", words(&["1x1", "2x3", "3x1", "0x1", "16385x1", "1x", "5x5"])),
        ("--visibility", words(&["bvh", "map"])),
        ("--map-surface", words(&["step", "linear"])),
        ("--model", words(&["sun", "hoffman-preetham"])),
        ("--max-distance", number()),
        ("--camera", words(&["0", "1", "-1", "main", "18446744073709551616"])),
        ("--eye", triple()),
        ("--target", triple()),
        ("--up", triple()),
        ("--fov", number()),
        ("--sigma-s", colour()),
        ("--sigma-a", colour()),
        ("--phase", phases.boxed()),
        ("--point-light", joined(vec![triple(), colour()])),
        ("--spot-light", joined(vec![triple(), triple(), angle(), angle(), colour()])),
        ("--directional-light", joined(vec![triple(), colour()])),
        ("--light-texture", words(&["picture.png", "scene.glb", "absent.png", "."])),
        ("--samples", words(&["0", "1", "2", "7", "-3", "10000001"])),
        ("--shadow-map", words(&["0", "1", "2", "3", "17", "16385"])),
        (
            "--tessellation",
            prop_oneof![
                words(&["static", "adaptive", "delaunay"]),
                number().prop_map(|metres| format!("adaptive:{metres}")),
                number().prop_map(|metres| format!("delaunay:{metres}")),
            ]
            .boxed(),
        ),
        ("--scattering-scale", words(&["1", "2", "4", "3"])),
        ("--voxel-size", words(&["0.5", "1", "1e30", "1e-30", "0", "3e38"])),
        ("--viewers", words(&["1", "2", "0", "257"])),
        ("--target-error", number()),
        ("--exposure", number()),
        ("--json", words(&["out/a.json", "out/a.png", "absent/a.json", "out"])),
        ("--adapter", words(&["abacus"])),
    ];
    let strategies = kinds.into_iter().map(|(name, value)| {
        let value = prop_oneof![19 => value, 1 => words(&HOSTILE)];
        value.prop_map(move |value| vec![name.to_owned(), value]).boxed()
    });
    let bare =
        words(&["--airlight-only", "--unshadowed", "--nonsense", "extra", "--"]).prop_map(|word| vec![word]);
    prop_oneof![12 => proptest::strategy::Union::new(strategies), 2 => bare.boxed()]
}

/// What is done to a file that was whole.
#[derive(Debug, Clone)]
struct Damage {
    seed: Index,
    bytes: Vec<(Index, u8)>,
    cut: Option<Index>,
}

fn damage() -> impl Strategy<Value = Damage> {
    let bytes = prop::collection::vec((any::<Index>(), prop_oneof![any::<u8>(), b'0'..=b'9']), 0..4);
    (any::<Index>(), bytes, prop::option::weighted(0.1, any::<Index>()))
        .prop_map(|(seed, bytes, cut)| Damage { seed, bytes, cut })
}

/// The files that the importer's fuzzer starts from.
fn whole_files() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds/gltf");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    paths.sort();
    assert!(!paths.is_empty());
    paths.into_iter().map(|path| std::fs::read(path).unwrap()).collect()
}

impl Damage {
    fn to(&self, files: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = self.seed.get(files).clone();
        for (at, value) in &self.bytes {
            let at = at.index(bytes.len());
            bytes[at] = *value;
        }
        if let Some(cut) = self.cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        bytes
    }
}

/// What is wrong with how a command ended, if anything: it draws its picture and leaves nothing behind but the files that
/// it names, or refuses in one line and leaves nothing.
fn wrong(
    arguments: &[String],
    ended: &Ended,
    before: &[String],
    after: &[String],
    output: &str,
) -> Option<String> {
    let lines: Vec<&str> = ended.stderr.lines().collect();
    if ended.stderr.contains("panicked") {
        return Some("a panic".into());
    }
    match ended.code {
        0 if !after.contains(&output.to_owned()) => Some("no picture".into()),
        0 => {
            let named: Vec<&str> = arguments.iter().filter_map(|word| word.strip_prefix("out/")).collect();
            let strange = after.iter().find(|name| *name != "a.error.png" && !named.contains(&name.as_str()));
            strange.map(|name| format!("left {name} behind"))
        }
        2 if !matches!(lines[..], [line] if line.starts_with("error: ")) => Some("not one line".into()),
        2 if !ended.stdout.is_empty() => Some("printed something".into()),
        2 if after != before => Some(format!("left {after:?} behind")),
        2 => None,
        code => Some(format!("exit code {code}")),
    }
}

#[test]
fn any_command_is_drawn_or_refused() {
    let cases =
        std::env::var("AIRLIGHT_FUZZ_COMMANDS").map_or(USUAL_COMMANDS, |cases| cases.parse().unwrap());
    let files = whole_files();
    let scene = prop_oneof![3 => words(&SCENES), 2 => words(&["scene.glb"])];
    let commands =
        (scene, damage(), prop::collection::vec(flag(), 0..6), select(&["a.png", "a.npy", "a.exr"][..]));
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    };
    let (mut drawn, mut refused) = (0, 0);
    let tally = std::cell::RefCell::new((&mut drawn, &mut refused));
    let tried = TestRunner::new(config).run(&commands, |(scene, damage, flags, output)| {
        let desk = Desk::default();
        desk.write("scene.glb", damage.to(&files));
        desk.write("picture.png", include_bytes!("../../docs/images/lampshade.png"));
        let mut arguments =
            ["render", &scene, "--size", "4x3", "-o", &format!("out/{output}")].map(str::to_owned).to_vec();
        if flags.iter().any(|flag| flag[0] == "--size") {
            arguments.drain(2..4);
        }
        arguments.extend(flags.into_iter().flatten());
        let before = desk.outputs();
        let ended = desk.run_words(&arguments);
        if let Some(wrong) = wrong(&arguments, &ended, &before, &desk.outputs(), output) {
            return Err(TestCaseError::fail(format!("{arguments:?}: {wrong}: {}", ended.stderr)));
        }
        let mut tally = tally.borrow_mut();
        *(if ended.code == 0 { &mut *tally.0 } else { &mut *tally.1 }) += 1;
        Ok(())
    });
    if let Err(error) = tried {
        panic!("{error}");
    }
    println!("{drawn} drawn, {refused} refused");
    // most are neither trivially right nor trivially wrong
    assert!(20 * drawn > cases && 20 * refused > cases, "{drawn} drawn, {refused} refused");
}
