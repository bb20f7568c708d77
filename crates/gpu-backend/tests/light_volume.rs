//! Light volumes on the GPU against the exact traversal of the same map in its linear meaning.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use common::{Stage, compare, fog, gpus, upload};
use gpu_backend::{Criterion, DEFAULT_MOST_LEAVES, Technique, Tessellation};
use scene::Light;
use shadowmap::MapSurface;

fn volume(tessellation: Tessellation, kept: Option<u32>) -> Technique {
    Technique::LightVolume { tessellation, kept }
}

fn adaptive(threshold: f32, kept: Option<u32>) -> Technique {
    let tessellation = Tessellation::Adaptive {
        criterion: Criterion::Distance,
        threshold,
        most_leaves: DEFAULT_MOST_LEAVES,
    };
    volume(tessellation, kept)
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::Point(_) => "point",
        Light::Spot(_) => "spot",
        Light::Directional(_) => "directional",
    }
}

/// Bars of the difference to the traversal in f64: relative RMSE, and as a share of what shadows change.
const BARS: (f64, f64) = (1e-4, 2e-4);

#[test]
fn every_tessellation_is_the_linear_surface() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        for name in ["sphere", "slats", "hall"] {
            let stage = Stage::procedural(name, (96, 96), 0.3);
            for light in stage.lights() {
                let map = stage.map(&light, 130, MapSurface::Linear);
                let uploaded = upload(&gpu, map.as_ref().unwrap());
                let wanted = stage.traversed(&light, &map, MapSurface::Linear);
                let open = stage.traversed(&light, &None, MapSurface::Linear);
                let (changed, _) = compare(&open, &wanted);
                for (how, technique) in [
                    ("grid", volume(Tessellation::Grid, None)),
                    ("indexed", volume(Tessellation::IndexedGrid, None)),
                    ("adaptive, exact", adaptive(0.0, None)),
                    ("adaptive", adaptive(0.01, None)),
                    ("blended", adaptive(0.01, Some(0))),
                    ("partly kept", adaptive(0.01, Some(1))),
                    ("kept", adaptive(0.01, Some(8))),
                ] {
                    let got = stage.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), technique);
                    let (error, p99) = compare(&got, &wanted);
                    let shadow = if changed > 0.0 { error / changed } else { 0.0 };
                    println!("{name} {} {how}: {error:.1e} {shadow:.1e} {p99:.1e}", kind(&light));
                    assert!(error <= BARS.0 && shadow <= BARS.1, "{name} {} {how}", kind(&light));
                }
            }
        }
    }
}
