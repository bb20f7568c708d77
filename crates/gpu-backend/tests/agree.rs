//! GPU against CPU, pixel by pixel, on the same map.

mod common;

use common::{Stage, compare, fog, gpus, upload};
use gpu_backend::{Lookup, Technique};
use scene::AirlightModel;
use shadowmap::{Bias, Filter, MapSurface, MapVisibility};

#[test]
fn marches_agree() {
    for gpu in gpus().iter().take(1) {
        let mut fog = fog(gpu);
        for name in ["hall", "sphere", "slats"] {
            let stage = Stage::procedural(name, (128, 128), 1.0);
            for (kind, light) in ["point", "spot", "directional"].iter().zip(stage.lights()) {
                let map = [stage.map(&light, 512, MapSurface::Step)];
                let visibility = MapVisibility::new(&map, Filter::Nearest, Bias::NONE);
                for samples in [50, 150, 1000] {
                    let cpu = stage.marched(&light, Some(&visibility), samples, AirlightModel::Sun);
                    let on_gpu = upload(gpu, map[0].as_ref().unwrap());
                    let technique = Technique::BruteForce { samples, lookup: Lookup::Nearest };
                    let got = stage.on_gpu(gpu, &mut fog, &light, Some(&on_gpu), technique);
                    let (rmse, p99) = compare(&got, &cpu);
                    println!("{name} {kind} {samples}: rel_rmse {rmse:.2e} p99 {p99:.2e}");
                }
            }
        }
    }
}

#[test]
fn traversals_agree() {
    for gpu in gpus().iter().take(1) {
        let mut fog = fog(gpu);
        for name in ["hall", "sphere", "slats"] {
            let stage = Stage::procedural(name, (128, 128), 1.0);
            for (kind, light) in ["point", "spot", "directional"].iter().zip(stage.lights()) {
                for surface in [MapSurface::Step, MapSurface::Linear] {
                    for side in [37, 512] {
                        let map = stage.map(&light, side, surface);
                        let cpu = stage.traversed(&light, &map, surface);
                        let on_gpu = upload(gpu, map.as_ref().unwrap());
                        let technique = Technique::ExactShadowMap { surface };
                        let got = stage.on_gpu(gpu, &mut fog, &light, Some(&on_gpu), technique);
                        let (rmse, p99) = compare(&got, &cpu);
                        println!("{name} {kind} {surface:?} {side}: rel_rmse {rmse:.2e} p99 {p99:.2e}");
                    }
                }
            }
        }
    }
}
