//! The exact reference against noise-free pictures of the same scenes that were computed by other means: analytic
//! solids instead of triangles, other visibility, other quadrature.
#![expect(
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use airlight_tests::gold;
use airlight_tests::picture::rel_rmse;

/// What tessellation may cost at most.
const BAR: f64 = 5e-4;

/// What is held: the pictures were rounded to f32, and triangles stand for round solids.
const HELD: f64 = 5e-5;

fn check(name: &str) {
    let gold = gold::load(name);
    let started = std::time::Instant::now();
    let exact = gold.view.exact();
    let kept = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let fragile = |i: &usize| gold.fragile.contains(i);
        (0..pixels.len()).filter(|i| !fragile(i)).map(|i| pixels[i]).collect()
    };
    assert!(gold.fragile.len() < exact.len() / 100, "{name}: too much is left out");
    let error = rel_rmse(&kept(&exact), &kept(&gold.pixels));
    let everywhere = rel_rmse(&exact, &gold.pixels);
    println!("{name}: {error:.2e} ({everywhere:.2e} with silhouettes), {:.1?}", started.elapsed());
    assert!(
        exact.as_flattened().iter().all(|v| v.is_finite() && *v >= 0.0),
        "{name}: a value makes no sense"
    );
    if !(error <= HELD) {
        let missed = if error <= BAR { "what is held" } else { "the bar itself" };
        panic!("{name}: {error:.3e} misses {missed}");
    }
}

#[test]
fn point_light_over_a_sphere() {
    check("s1_sphere");
}

#[test]
fn slats() {
    check("s2_slats");
}

#[test]
fn directional_light_in_a_bounded_medium() {
    check("s4_sun");
}

#[test]
fn textured_spot() {
    check("s6_spot");
}
