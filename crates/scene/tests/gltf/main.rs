//! glTF import from end to end, on tiny files that the tests write themselves.
#![cfg(feature = "gltf")]
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod files;
mod geometry;
mod lights;
mod mutations;
mod refusals;
mod surroundings;
mod writer;
