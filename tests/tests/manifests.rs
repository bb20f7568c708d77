//! Manifests say the same of every crate, and all that a registry asks for.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use airlight_tests::workspace::{cargo, is_publishable, members, metadata, read, root};

/// The compiler that the workspace states.
fn stated_version() -> String {
    let manifest: toml::Table = toml::from_str(&read("Cargo.toml")).unwrap();
    manifest["workspace"]["package"]["rust-version"].as_str().unwrap().to_owned()
}

#[test]
fn one_compiler_version_is_stated_everywhere() {
    let version = stated_version();
    let metadata = metadata();
    let members = members(&metadata);
    assert!(members.len() >= 10, "{} members", members.len());
    for package in members {
        // so that there is one place to change it
        let manifest = std::fs::read_to_string(package["manifest_path"].as_str().unwrap()).unwrap();
        assert!(manifest.contains("\nrust-version.workspace = true\n"), "{}", package["name"]);
        assert_eq!(package["rust_version"].as_str(), Some(version.as_str()), "{}", package["name"]);
    }
    // clippy takes it from there, and looks out for what came later, unless its own file says otherwise
    let clippy: toml::Table = toml::from_str(&read("clippy.toml")).unwrap();
    assert!(clippy.get("msrv").is_none_or(|msrv| msrv.as_str() == Some(&version)), "{clippy:?}");
    assert!(
        read("README.md").contains(&format!("Rust {version} or later")),
        "README.md says another than {version}"
    );
}

/// Later compilers than that are no surprise: no dependency asks for one.
#[test]
fn no_dependency_needs_a_later_compiler() {
    let number =
        |version: &str| -> Vec<u32> { version.split('.').map_while(|part| part.parse().ok()).collect() };
    let least = number(&stated_version());
    let metadata = metadata();
    for package in airlight_tests::workspace::packages(&metadata) {
        let wanted = package["rust_version"].as_str().map(number).unwrap_or_default();
        assert!(
            wanted <= [&least[..], &[0]].concat(),
            "{} needs Rust {}",
            package["name"],
            package["rust_version"]
        );
    }
}

#[test]
fn what_is_published_is_described() {
    let metadata = metadata();
    let mut published = 0;
    for package in members(&metadata) {
        let name = package["name"].as_str().unwrap();
        let in_crates = package["manifest_path"].as_str().unwrap().contains("/crates/");
        // tools, tests and benchmarks stay here
        assert_eq!(is_publishable(package), in_crates, "{name}");
        if !in_crates {
            continue;
        }
        published += 1;
        let description = package["description"].as_str().unwrap_or_default();
        assert!((20..=250).contains(&description.len()), "{name}: {description:?}");
        assert_eq!(package["license"], "MIT OR Apache-2.0", "{name}");
        assert_eq!(package["readme"], "README.md", "{name}");
        // the registry's limits
        assert!((1..=5).contains(&package["keywords"].as_array().unwrap().len()), "{name}");
        assert!((1..=5).contains(&package["categories"].as_array().unwrap().len()), "{name}");
        for dependency in package["dependencies"].as_array().unwrap() {
            let here = dependency["path"].is_string() && dependency["kind"].is_null();
            assert!(!here || dependency["req"] != "*", "{name}: {} without a version", dependency["name"]);
        }
    }
    assert_eq!(published, 8);
}

/// A package is built without the rest of the workspace: what it reads at compile time comes along.
#[test]
fn packages_hold_shaders_licences_and_readmes() {
    let metadata = metadata();
    for package in members(&metadata).into_iter().filter(|package| is_publishable(package)) {
        let name = package["name"].as_str().unwrap();
        let list = cargo(&["package", "--list", "--allow-dirty", "--package", name]);
        let files: Vec<&str> = list.lines().collect();
        for wanted in ["Cargo.toml", "README.md", "LICENSE-APACHE", "LICENSE-MIT", "src/lib.rs"] {
            assert!(files.contains(&wanted), "{name}: no {wanted}");
        }
        if name == "gpu-backend" {
            let shaders = shaders();
            assert!(shaders.len() > 50, "{} shaders", shaders.len());
            for shader in shaders {
                assert!(files.contains(&shader.as_str()), "{name}: no {shader}");
            }
        }
    }
}

/// The names of all shaders, as packed.
fn shaders() -> Vec<String> {
    let mut shaders = Vec::new();
    for folder in std::fs::read_dir(root().join("shaders")).unwrap() {
        let folder = folder.unwrap().path();
        for file in std::fs::read_dir(&folder).unwrap() {
            let file = file.unwrap().path();
            let place = file.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
            shaders.push(place);
        }
    }
    shaders
}

/// Features are checked one by one (`.ci/run`); one that is not named there is not.
#[test]
fn every_feature_is_checked_by_itself() {
    let script = read(".ci/run");
    let metadata = metadata();
    for package in members(&metadata).into_iter().filter(|package| is_publishable(package)) {
        let name = package["name"].as_str().unwrap();
        let line = script.lines().find(|line| line.trim_start().starts_with(&format!("check {name} ")));
        let line = line.unwrap_or_else(|| panic!("{name} is not checked in .ci/run"));
        let checked: Vec<&str> = line.split(' ').map(|word| word.trim_matches('"')).collect();
        for feature in package["features"].as_object().unwrap().keys().filter(|name| *name != "default") {
            assert!(
                checked.contains(&feature.as_str()),
                "{name}: {feature} is not checked by itself in .ci/run"
            );
        }
    }
}
