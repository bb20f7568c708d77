//! The workspace as cargo sees it.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The folder of the whole project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Text of a file of the project.
pub fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// What cargo prints in the project's folder; it must succeed. Without the network first: all is there where it was built.
pub fn cargo(arguments: &[&str]) -> String {
    let run = |more: &[&str]| {
        let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Command::new(program).current_dir(root()).args(arguments).args(more).output().unwrap()
    };
    let mut output = run(&["--locked", "--offline"]);
    if !output.status.success() {
        output = run(&["--locked"]);
    }
    assert!(
        output.status.success(),
        "cargo {}: {}",
        arguments.join(" "),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// `cargo metadata` of all packages, for every platform.
pub fn metadata() -> Value {
    serde_json::from_str(&cargo(&["metadata", "--format-version", "1"])).unwrap()
}

/// The packages of the workspace, by what [`metadata`] says of them.
pub fn members(metadata: &Value) -> Vec<&Value> {
    packages(metadata).filter(|package| package["source"].is_null()).collect()
}

/// All packages.
pub fn packages(metadata: &Value) -> impl Iterator<Item = &Value> {
    metadata["packages"].as_array().unwrap().iter()
}

/// Whether a package is for others to use.
pub fn is_publishable(package: &Value) -> bool {
    // null: anywhere; an empty list: nowhere
    package["publish"].is_null()
}
