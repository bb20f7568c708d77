//! Every dependency has a licence that `deny.toml` allows, and `docs/licences.md` lists them.
//!
//! `AIRLIGHT_BLESS=1 cargo test -p airlight-tests --test licences` writes the list anew.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use airlight_tests::workspace::{is_publishable, members, metadata, packages, read, root};
use serde_json::Value;
use spdx::{Expression, ParseMode};

const LIST: &str = "docs/licences.md";

const HEAD: &str = "# Licences\n\n\
    The project is under either of [Apache License 2.0](../LICENSE-APACHE) or [MIT](../LICENSE-MIT). What it depends on, by the\n\
    licence that each crate states, on every platform; made and checked by `tests/tests/licences.rs` against the list in\n\
    [deny.toml](../deny.toml).\n";

/// A crate's name and the licence that it states.
type Licensed = (String, String);

fn text<'a>(value: &'a Value, field: &str) -> &'a str {
    value[field].as_str().unwrap_or_default()
}

/// What the publishable crates bring along, and what only tools, tests and benchmarks do.
fn dependencies(metadata: &Value) -> [BTreeSet<Licensed>; 2] {
    let nodes: BTreeMap<&str, &Value> = metadata["resolve"]["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|node| (text(node, "id"), node))
        .collect();
    let mut queue: Vec<&str> = members(metadata)
        .into_iter()
        .filter(|package| is_publishable(package))
        .map(|p| text(p, "id"))
        .collect();
    assert!(!queue.is_empty());
    let mut brought = BTreeSet::new();
    while let Some(id) = queue.pop() {
        if !brought.insert(id) {
            continue;
        }
        for dependency in nodes[id]["deps"].as_array().unwrap() {
            let mut kinds = dependency["dep_kinds"].as_array().unwrap().iter();
            if kinds.any(|kind| kind["kind"] != "dev") {
                queue.push(text(dependency, "pkg"));
            }
        }
    }
    let mut lists = [BTreeSet::new(), BTreeSet::new()];
    for package in packages(metadata).filter(|package| !package["source"].is_null()) {
        let list = usize::from(!brought.contains(text(package, "id")));
        lists[list].insert((text(package, "name").to_owned(), text(package, "license").replace('/', " OR ")));
    }
    lists
}

fn section(title: &str, crates: &BTreeSet<Licensed>) -> String {
    let mut by_licence = BTreeMap::<&str, Vec<&str>>::new();
    for (name, licence) in crates {
        by_licence.entry(licence).or_default().push(name);
    }
    let mut page = format!("\n## {title}\n\n| licence | crates |\n| --- | --- |\n");
    for (licence, names) in by_licence {
        let _ = writeln!(page, "| {licence} | {} |", names.join(", "));
    }
    page
}

#[test]
fn every_licence_is_allowed_and_listed() {
    let settings: toml::Table = toml::from_str(&read("deny.toml")).unwrap();
    let allowed: Vec<&str> =
        settings["licenses"]["allow"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    let [crates, tools] = dependencies(&metadata());
    assert!(crates.len() > 50 && tools.len() > 50, "{} and {}", crates.len(), tools.len());
    for (name, licence) in crates.iter().chain(&tools) {
        let expression = Expression::parse_mode(licence, ParseMode::LAX);
        let expression = expression.unwrap_or_else(|e| panic!("{name}: {licence:?}: {e}"));
        let may = expression.evaluate(|wanted| allowed.contains(&wanted.to_string().as_str()));
        assert!(may, "{name}: {licence} is not allowed by deny.toml");
    }
    let page = format!(
        "{HEAD}{}{}",
        section("What the library crates bring along", &crates),
        section("What only the command line, tests and benchmarks do", &tools)
    );
    if std::env::var_os("AIRLIGHT_BLESS").is_some() {
        std::fs::write(root().join(LIST), &page).unwrap();
    }
    let stated = std::fs::read_to_string(root().join(LIST)).unwrap_or_default();
    assert!(
        stated == page,
        "{LIST} is out of date: AIRLIGHT_BLESS=1 cargo test -p airlight-tests --test licences"
    );
}

/// A licence that nothing has is no reason to allow it, and some are not to be.
#[test]
fn the_list_says_no() {
    let settings: toml::Table = toml::from_str(&read("deny.toml")).unwrap();
    let allowed = settings["licenses"]["allow"].as_array().unwrap();
    for refused in ["GPL-3.0-only", "LGPL-2.1-or-later", "MPL-2.0"] {
        assert!(allowed.iter().all(|name| name.as_str() != Some(refused)), "{refused}");
    }
}
