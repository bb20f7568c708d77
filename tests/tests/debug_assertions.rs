//! Whether arithmetic is checked where the tests run: overflow and `debug_assert!` are panics there.
//!
//! `cargo xtask test` sets `REQUIRE_DEBUG_ASSERTIONS` for the crates that need no GPU. The tests of `gpu-backend` and
//! `xtask` themselves run in release; the `xtask` that the tests of this folder start is built as they are.

use std::path::Path;

#[test]
fn arithmetic_is_checked() {
    let exe = std::env::current_exe().unwrap();
    // <target>/<profile>/deps/<test>
    let profile = exe.parent().and_then(Path::parent).and_then(Path::file_name).unwrap();
    let required = std::env::var_os("REQUIRE_DEBUG_ASSERTIONS").is_some() || profile == "debug";
    assert!(cfg!(debug_assertions) || !required, "no debug assertions in {}", exe.display());
    let most = std::hint::black_box(u32::MAX);
    let caught = std::panic::catch_unwind(|| most + std::hint::black_box(1)).is_err();
    assert_eq!(caught, cfg!(debug_assertions), "an overflow");
    println!("debug assertions: {}", cfg!(debug_assertions));
}
