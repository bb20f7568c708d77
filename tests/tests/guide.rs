//! The guide shows no code that is not compiled: each of its blocks stands, line by line, in a file that is.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use std::path::Path;

/// Where the guide's code comes from.
const SOURCES: [&str; 2] = ["crates/gpu-backend/examples/host/main.rs", "crates/gpu-backend/tests/guide.rs"];

fn read(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    std::fs::read_to_string(root.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

#[test]
fn every_block_of_the_guide_is_compiled_code() {
    let guide = read("docs/guide-wgpu.md");
    let sources = SOURCES.map(read);
    let sources = sources.each_ref().map(|text| lines(text));
    let blocks: Vec<&str> =
        guide.split("```rust\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 10, "{} blocks", blocks.len());
    for block in blocks {
        let wanted = lines(block);
        assert!(!wanted.is_empty());
        let found = sources.iter().any(|source| source.windows(wanted.len()).any(|window| window == wanted));
        assert!(found, "not in {SOURCES:?}:\n{block}");
    }
    // a block of another language shows no Rust
    let fences = guide.lines().filter(|line| line.starts_with("```") && *line != "```");
    assert!(
        fences.clone().all(|fence| fence == "```rust" || fence == "```toml"),
        "{:?}",
        fences.collect::<Vec<_>>()
    );
}

/// Links between the pages lead somewhere.
#[test]
fn links_in_the_pages_lead_to_files() {
    for page in ["README.md", "ARCHITECTURE.md", "docs/guide-wgpu.md", "docs/choosing.md", "docs/licences.md"]
    {
        let text = read(page);
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(page);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if !link.contains("://") {
                let target = link.split('#').next().unwrap_or_default();
                assert!(folder.parent().unwrap().join(target).exists(), "{page}: {link}");
            }
        }
    }
}
