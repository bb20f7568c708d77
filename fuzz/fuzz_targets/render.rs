//! Any bytes as the parameters of a few pixels.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| airlight_tests::fuzzed::render(bytes));
