//! Light volumes on the GPU against the exact traversal of the same map in its linear meaning.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use common::{Stage, compare, fog, gpus, upload};
use gpu_backend::{Criterion, DEFAULT_MOST_LEAVES, Technique, Tessellation};
use scene::Light;
use shadowmap::MapSurface;

fn volume(tessellation: Tessellation) -> Technique {
    Technique::LightVolume { tessellation, kept: 6 }
}

fn adaptive(threshold: f32) -> Technique {
    volume(Tessellation::Adaptive {
        criterion: Criterion::Distance,
        threshold,
        most_leaves: DEFAULT_MOST_LEAVES,
    })
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::Point(_) => "point",
        Light::Spot(_) => "spot",
        Light::Directional(_) => "directional",
    }
}

#[test]
fn a_grid_is_the_linear_surface() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        for name in ["sphere", "slats", "hall"] {
            let stage = Stage::procedural(name, (96, 96), 0.3);
            for light in stage.lights() {
                let map = stage.map(&light, 128, MapSurface::Linear);
                let uploaded = upload(&gpu, map.as_ref().unwrap());
                let wanted = stage.traversed(&light, &map, MapSurface::Linear);
                let lit = stage.traversed(&light, &None, MapSurface::Linear);
                for (how, technique) in [
                    ("grid", volume(Tessellation::Grid)),
                    ("indexed", volume(Tessellation::IndexedGrid)),
                    ("adaptive 0", adaptive(0.0)),
                    ("adaptive", adaptive(0.01)),
                ] {
                    let got = stage.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), technique);
                    let (error, p99) = compare(&got, &wanted);
                    let (changed, _) = compare(&lit, &wanted);
                    let count = uploaded.read_leaf_count(&gpu.device, &gpu.queue).ok();
                    println!(
                        "{name} {} {how}: rel_rmse {error:.2e}, shadow_err {:.2e}, p99 {p99:.1e} {count:?}",
                        kind(&light),
                        error / changed
                    );
                }
            }
        }
    }
}
