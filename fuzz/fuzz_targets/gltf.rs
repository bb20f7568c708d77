//! Any bytes as a glTF file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| airlight_tests::fuzzed::gltf(bytes));
