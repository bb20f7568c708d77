//! The airlight integral on the GPU against the reference cases with proven digits.

mod common;

use common::{core_gpu, gpu};
use gpu_backend::{AirlightProbe, GpuError, PrepareError, Problem};
use serde::Deserialize;

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    id: String,
    f32: Option<Block>,
}

#[derive(Deserialize)]
struct Block {
    kappa_s: f32,
    kappa_t: f32,
    intensity: f32,
    x_foot: f32,
    h: f32,
    x0: f32,
    x1: f32,
    #[serde(default)]
    g: f32,
    value: Option<f64>,
}

#[test]
fn every_case_is_within_its_bar() {
    let Some(gpu) = gpu() else { return };
    let text = include_str!("../../../tests/data/airlight_public.json");
    let file: File = serde_json::from_str(text).unwrap();
    let cases: Vec<(&str, &Block)> =
        file.cases.iter().filter_map(|case| Some((case.id.as_str(), case.f32.as_ref()?))).collect();
    let problems: Vec<(Problem, Vec<[f32; 2]>)> = cases
        .iter()
        .map(|(_, b)| {
            let problem = Problem {
                sigma_s: b.kappa_s,
                sigma_t: b.kappa_t,
                intensity: b.intensity,
                x_foot: b.x_foot,
                h: b.h,
                g: b.g,
            };
            (problem, vec![[b.x0, b.x1]])
        })
        .collect();
    let results = AirlightProbe::new(&gpu).unwrap().evaluate(&problems).unwrap();
    let mut normal = 0;
    for ((id, block), got) in cases.iter().zip(results) {
        let Some(exact) = block.value else { continue };
        assert!(got.is_finite(), "{id}: {got}");
        if exact < f64::from(f32::MIN_POSITIVE) {
            assert!(f64::from(got) <= 2.0 * f64::from(f32::MIN_POSITIVE), "{id}: {got} for {exact:e}");
            continue;
        }
        let a = f64::from(block.x0) - f64::from(block.x_foot);
        let tau = f64::from(block.kappa_t) * (f64::from(block.x0) + a.hypot(f64::from(block.h)));
        let error = (f64::from(got) / exact - 1.0).abs();
        assert!(error <= 2e-5 * (tau / 20.0).max(1.0), "{id}: {got} for {exact:e}, error {error:e}");
        normal += 1;
    }
    assert!(normal > 500, "only {normal} cases had a normal value");
}

#[test]
fn nothing_and_too_much_are_no_panic() {
    let Some(gpu) = core_gpu() else { return };
    let probe = AirlightProbe::new(&gpu).unwrap();
    assert!(probe.evaluate(&[]).unwrap().is_empty());
    let problem = Problem { sigma_s: 0.1, sigma_t: 0.1, intensity: 1.0, x_foot: 1.0, h: 1.0, g: 0.0 };
    assert_eq!(probe.evaluate(&[(problem, vec![])]).unwrap(), [0.0]);
    let many = vec![[0.0_f32, 1.0]; 1 << 25];
    assert!(matches!(
        probe.evaluate(&[(problem, many)]),
        Err(GpuError::Prepare(PrepareError::TooLarge { .. }))
    ));
}
