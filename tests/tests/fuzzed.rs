//! The seeds of `fuzz/` and random bytes, through the functions of its targets.
//!
//! `AIRLIGHT_FUZZ_CASES` sets how many random cases there are.
#![allow(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use std::path::Path;

use airlight_tests::fuzzed;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// Random cases where nothing else is asked for.
const USUAL_CASES: u32 = 2000;

/// Every file of `fuzz/seeds` for a target, by its name.
fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds").join(target);
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| (path.display().to_string(), std::fs::read(path).unwrap())).collect()
}

/// Runs every seed, and names the one that fails.
fn replay(target: &str, run: fn(&[u8])) {
    let seeds = seeds(target);
    assert!(seeds.len() >= 5, "{target}: {} seeds", seeds.len());
    for (name, bytes) in seeds {
        let ended = std::panic::catch_unwind(|| run(&bytes));
        assert!(ended.is_ok(), "{name} ended in a panic");
    }
}

fn try_random_bytes(run: fn(&[u8])) {
    let cases = std::env::var("AIRLIGHT_FUZZ_CASES").map_or(USUAL_CASES, |cases| cases.parse().unwrap());
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    let bytes = prop::collection::vec(any::<u8>(), 0..700);
    let tried = TestRunner::new(config).run(&bytes, |bytes| {
        run(&bytes);
        Ok(())
    });
    tried.unwrap();
}

#[test]
fn seeds_of_files() {
    replay("gltf", fuzzed::gltf);
}

#[test]
fn seeds_of_parameters() {
    replay("render", fuzzed::render);
}

#[test]
fn random_parameters() {
    try_random_bytes(fuzzed::render);
}
