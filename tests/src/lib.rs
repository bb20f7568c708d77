//! What the cross-crate tests share: reference cases, reference scenes, pictures and their differences, and the
//! command line.
//!
//! Everything here serves tests only, so a mistake in it is a panic with words.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::missing_panics_doc,
    reason = "helpers of tests, which clippy does not take for tests"
)]

pub mod browser;
pub mod cases;
pub mod cli;
pub mod fuzzed;
pub mod glb;
pub mod gold;
pub mod picture;
pub mod tessellate;
pub mod view;
pub mod workspace;

use std::path::PathBuf;

/// A file of `tests/data`.
pub fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}
