//! Light volumes on the GPU against the exact traversal of the same map in its linear meaning.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use common::{Stage, compare, fog, gpu, gpus, render, upload};
use glam::Vec3;
use gpu_backend::{
    Criterion, DEFAULT_MOST_LEAVES, Fog, Frame, Lamp, LightMesh, Sampling, SceneDepth, ShadowMap, Shadows,
    Technique, Tessellation, View,
};
use lightvolume::{LightVolume, LightVolumes, Options};
use media_math::PhaseFunction;
use scene::{AirlightModel, Camera, Light, Medium};
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

#[test]
fn leaves_are_those_of_the_cpu() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        for name in ["slats", "hall"] {
            let stage = Stage::procedural(name, (8, 8), 0.3);
            for light in stage.lights() {
                let map = stage.map(&light, 150, MapSurface::Linear).unwrap();
                let uploaded = upload(&gpu, &map);
                for criterion in [Criterion::Distance, Criterion::Laplacian] {
                    let tessellation = Tessellation::Adaptive {
                        criterion,
                        threshold: 0.02,
                        most_leaves: DEFAULT_MOST_LEAVES,
                    };
                    let technique = volume(tessellation, None);
                    stage.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), technique);
                    let got = uploaded.read_leaves(&gpu.device, &gpu.queue).unwrap();
                    let mut got: Vec<_> = got
                        .into_iter()
                        .map(|[at, how]| (how >> 16, how & 0xff, at & 0xffff, at >> 16, how >> 8 & 0xff))
                        .collect();
                    let options = Options {
                        tessellation: lightvolume::Tessellation::Adaptive { criterion, threshold: 0.02 },
                        far: Some(1e6),
                    };
                    let wanted = LightVolume::build(&map, &options).unwrap();
                    let mut wanted: Vec<_> = wanted
                        .leaves()
                        .iter()
                        .map(|leaf| (leaf.face, leaf.level, leaf.x, leaf.y, leaf.configuration))
                        .collect();
                    got.sort_unstable();
                    wanted.sort_unstable();
                    let both = got.iter().filter(|leaf| wanted.binary_search(leaf).is_ok()).count();
                    let differ = got.len().max(wanted.len()) - both;
                    println!("{name} {} {criterion:?}: {} leaves, {differ} differ", kind(&light), got.len());
                    // a criterion next to its threshold may fall on either side, and takes neighbours with it
                    assert!(1000 * differ <= wanted.len() + 2000, "{} of {}", differ, wanted.len());
                }
            }
        }
    }
}

#[test]
fn a_light_that_stands_still_keeps_its_leaves() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    let stage = Stage::procedural("sphere", (16, 16), 0.3);
    let light = &stage.lights()[1];
    let map = stage.map(light, 64, MapSurface::Linear).unwrap();
    let uploaded = upload(&gpu, &map);
    let built = |fog: &mut Fog| {
        stage.on_gpu(&gpu, fog, light, Some(&uploaded), adaptive(0.01, None));
        fog.stats().tessellations_built
    };
    assert_eq!((built(&mut fog), built(&mut fog)), (1, 0));
    uploaded.touch();
    assert_eq!((built(&mut fog), built(&mut fog)), (1, 0));
    // what only a tessellation needs is not there for a grid
    stage.on_gpu(&gpu, &mut fog, light, Some(&upload(&gpu, &map)), volume(Tessellation::IndexedGrid, None));
    assert!(!fog.stats().passes.iter().any(|pass| pass.contains("tessellation")));
}

#[test]
fn where_leaves_do_not_fit_they_are_coarser_and_the_surface_has_no_hole() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    let stage = Stage::procedural("hall", (48, 48), 0.3);
    for light in stage.lights() {
        let map = stage.map(&light, 128, MapSurface::Linear);
        let uploaded = upload(&gpu, map.as_ref().unwrap());
        let exact = stage.traversed(&light, &map, MapSurface::Linear);
        let mut last = 0.0;
        for most_leaves in [1 << 20, 3000, 400, 1] {
            let tessellation =
                Tessellation::Adaptive { criterion: Criterion::Distance, threshold: 0.01, most_leaves };
            let got = stage.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), volume(tessellation, None));
            let count = uploaded.read_leaf_count(&gpu.device, &gpu.queue).unwrap();
            let (error, _) = compare(&got, &exact);
            println!("{} {most_leaves}: {count:?} {error:.1e}", kind(&light));
            // a cube's seams have their cells whatever is asked for
            let seams = if matches!(light, Light::Point(_)) { 6 * 64 * 127 } else { 0 };
            assert!(count.leaves <= most_leaves.max(seams), "{count:?}");
            assert!(count.left_out > 0 || count.leaves <= most_leaves.max(seams));
            // a hole would let all of the light of a ray through, or none
            let brightest = exact.iter().flatten().fold(0.0_f32, |a, &b| a.max(b));
            assert!(got.iter().flatten().all(|&v| v.is_finite() && v <= 4.0 * brightest.max(1e-3)));
            assert!(error + 1e-4 >= last * 0.2, "coarser leaves err no less");
            last = error;
        }
    }
}

#[test]
fn triangles_made_beforehand_are_drawn_as_they_are() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("hall", (64, 64), 0.3);
        for light in &stage.lights()[1..] {
            let map = stage.map(light, 100, MapSurface::Linear).unwrap();
            let options = Options::new(lightvolume::Tessellation::Delaunay { bound: 0.02 });
            let volumes = [Some(LightVolume::build(&map, &options).unwrap())];
            let mesh = LightMesh::upload(&gpu.device, volumes[0].as_ref().unwrap()).unwrap();
            let uploaded = upload(&gpu, &map).with_mesh(mesh);
            let got = stage.on_gpu(&gpu, &mut fog, light, Some(&uploaded), volume(Tessellation::Mesh, None));
            let lights = std::slice::from_ref(light);
            let shadows = LightVolumes::new(&volumes, lights).unwrap();
            let settings = ground_truth::Settings::default();
            let reference = ground_truth::Reference::new(&[], &stage.bvh, &stage.medium, lights, settings)
                .unwrap()
                .with_shadows(&shadows);
            let wanted = stage.by_ray(|ray, end| reference.airlight(ray, end).as_vec3().to_array());
            let (error, p99) = compare(&got, &wanted);
            println!("{}: {error:.1e} {p99:.1e}", kind(light));
            assert!(error <= 1e-3, "{}: {error}", kind(light));
        }
        let cube = stage.map(&stage.lights()[0], 8, MapSurface::Linear).unwrap();
        let cube = LightVolume::build(&cube, &Options::default()).unwrap();
        assert!(LightMesh::upload(&gpu.device, &cube).is_err());
    }
}

/// A camera at `position` that looks at `target`, through the stage's medium.
fn moved(stage: &Stage, position: Vec3, target: Vec3) -> Stage {
    let camera = Camera::look_at(position, target, Vec3::Y, 1.0).unwrap();
    Stage::new(&stage.name, stage.scene.clone(), camera, stage.size, 0.3)
}

#[test]
fn cameras_in_awkward_places_see_no_holes() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("sphere", (48, 48), 0.3);
        for light in stage.lights() {
            let map = stage.map(&light, 64, MapSurface::Linear);
            let uploaded = upload(&gpu, map.as_ref().unwrap());
            let made = map.as_ref().unwrap();
            let face = &made.projection().faces()[0];
            let size = made.size();
            // a point on the surface itself, on a wall of the volume, far below, just beside the light
            let mut places = vec![(
                "on the surface",
                face.unproject(30.0, 33.0, f64::from(made.depth(0, 29, 32)).min(5.0), size),
            )];
            places.push(("on a wall", face.unproject(0.5, 20.3, 2.0, size)));
            places.push(("far behind", face.unproject(20.0, 20.0, 60.0, size)));
            if let Light::Point(_) | Light::Spot(_) = light {
                places.push(("beside the light", face.unproject(32.0, 32.0, 0.01, size)));
            }
            for (place, position) in places {
                let seen = moved(&stage, position.as_vec3(), Vec3::new(0.1, 1.0, 0.2));
                let wanted = seen.traversed(&light, &map, MapSurface::Linear);
                let open = seen.traversed(&light, &None, MapSurface::Linear);
                let bright = open.iter().flatten().fold(0.0_f32, |a, &b| a.max(b));
                for kept in [Some(0), Some(6)] {
                    let technique = volume(Tessellation::IndexedGrid, kept);
                    let got = seen.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), technique);
                    // a missed crossing errs by all of a ray's light
                    let missed =
                        got.iter().zip(&wanted).filter(|(a, b)| (a[0] - b[0]).abs() > 0.05 * bright).count();
                    let (error, _) = compare(&got, &wanted);
                    println!("{} {place} {kept:?}: {error:.1e}, {missed} pixels off", kind(&light));
                    assert!(missed == 0 && error < 1e-2, "{} {place}: {error:.1e}, {missed}", kind(&light));
                }
            }
        }
    }
}

/// There airlight is without bound, but which pixels have any is known.
#[test]
fn a_camera_at_a_spot_sees_its_light() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("sphere", (48, 48), 0.3);
        let Light::Spot(spot) = &stage.lights()[1] else { panic!("the second is a spot") };
        let seen = moved(&stage, spot.position, spot.position + spot.direction);
        // narrow enough for its walls to lie in the picture
        let light = Light::Spot(scene::SpotLight { inner: 0.2, outer: 0.3, ..spot.clone() });
        let map = seen.map(&light, 64, MapSurface::Linear);
        let delaunay = Options::new(lightvolume::Tessellation::Delaunay { bound: 0.02 });
        let mesh = LightVolume::build(map.as_ref().unwrap(), &delaunay).unwrap();
        let mesh = LightMesh::upload(&gpu.device, &mesh).unwrap();
        let uploaded = upload(&gpu, map.as_ref().unwrap()).with_mesh(mesh);
        let wanted = seen.traversed(&light, &map, MapSurface::Linear);
        let lit = wanted.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit > 200 && lit < wanted.len());
        for technique in [
            volume(Tessellation::Grid, None),
            volume(Tessellation::IndexedGrid, None),
            adaptive(0.01, None),
            volume(Tessellation::Mesh, None),
        ] {
            let got = seen.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), technique);
            let wrong = got.iter().zip(&wanted).filter(|(a, b)| (a[0] > 0.0) != (b[0] > 0.0)).count();
            assert_eq!(wrong, 0, "{technique:?}: of {lit} lit pixels");
        }
    }
}

#[test]
fn lights_add_up_in_a_coloured_medium_that_scatters_forwards() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let mut stage = Stage::procedural("hall", (48, 48), 0.3);
        let medium = Medium::homogeneous([0.02, 0.03, 0.05], [0.01, 0.0, 0.02]).unwrap();
        let phase = PhaseFunction::henyey_greenstein(0.6).unwrap();
        stage.medium = Medium { phase, ..medium };
        let lights = stage.lights();
        let maps: Vec<_> = lights.iter().map(|light| stage.map(light, 100, MapSurface::Linear)).collect();
        let uploaded: Vec<_> = maps.iter().map(|map| upload(&gpu, map.as_ref().unwrap())).collect();
        let casters = stage.bvh.bounds();
        let lamps: Vec<Lamp<'_>> = lights
            .iter()
            .zip(&uploaded)
            .map(|(light, map)| Lamp { light, shadows: Some(Shadows::Map { map, casters }), volume: None })
            .collect();
        let ends = stage.ends_f32();
        let view = View {
            camera: &stage.camera,
            size: stage.size,
            depth: SceneDepth::Distances(&ends),
            max_distance: f64::INFINITY,
        };
        let parts: Vec<_> = lights
            .iter()
            .zip(&maps)
            .map(|(light, map)| stage.traversed(light, map, MapSurface::Linear))
            .collect();
        let wanted: Vec<[f32; 3]> =
            (0..ends.len()).map(|i| [0, 1, 2].map(|c| parts.iter().map(|part| part[i][c]).sum())).collect();
        for kept in [Some(0), None] {
            let frame = Frame {
                views: &[view],
                medium: &stage.medium,
                lamps: &lamps,
                model: AirlightModel::Sun,
                technique: adaptive(1e-3, kept),
                sampling: Sampling::Pixels,
            };
            let (error, p99) = compare(&render(&gpu, &mut fog, &frame), &wanted);
            println!("{kept:?}: {error:.1e} {p99:.1e}");
            assert!(error <= 1e-4, "{kept:?}: {error:.1e}");
            // for blocks of pixels it is the same filter as for any technique
            let coarse = Frame { sampling: Sampling::blocks(2), ..frame };
            let (error, _) = compare(&render(&gpu, &mut fog, &coarse), &wanted);
            assert!(error <= 0.05, "blocks: {error:.1e}");
        }
    }
}

#[test]
fn what_a_light_volume_cannot_take_is_named() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    let stage = Stage::procedural("sphere", (8, 8), 0.3);
    let light = &stage.lights()[1];
    let map = stage.map(light, 16, MapSurface::Linear).unwrap();
    let mut refused = |map: &ShadowMap, tessellation| {
        let casters = stage.bvh.bounds();
        let lamps = [Lamp { light, shadows: Some(Shadows::Map { map, casters }), volume: None }];
        let view = View {
            camera: &stage.camera,
            size: stage.size,
            depth: SceneDepth::Nothing,
            max_distance: f64::INFINITY,
        };
        let frame = Frame {
            views: &[view],
            medium: &stage.medium,
            lamps: &lamps,
            model: AirlightModel::Sun,
            technique: volume(tessellation, None),
            sampling: Sampling::Pixels,
        };
        fog.prepare(&gpu.device, &gpu.queue, &frame).err().map(|error| error.to_string())
    };
    let uploaded = upload(&gpu, &map);
    assert_eq!(refused(&uploaded, Tessellation::IndexedGrid), None);
    assert!(refused(&uploaded, Tessellation::Mesh).unwrap().contains("ShadowMap::with_mesh"));
    let lit = uploaded.clone().with_outside(shadowmap::Outside::Lit);
    assert!(refused(&lit, Tessellation::Grid).unwrap().contains("light-volume"));
    let other = stage.map(light, 17, MapSurface::Linear).unwrap();
    let mesh = LightVolume::build(&other, &Options::default()).unwrap();
    let wrong = uploaded.with_mesh(LightMesh::upload(&gpu.device, &mesh).unwrap());
    assert!(refused(&wrong, Tessellation::Mesh).unwrap().contains("of its size"));
}

#[test]
fn maps_of_a_few_texels_are_fine() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    let stage = Stage::procedural("sphere", (32, 32), 0.3);
    for light in stage.lights() {
        for side in [2, 3, 5] {
            let map = stage.map(&light, side, MapSurface::Linear);
            let uploaded = upload(&gpu, map.as_ref().unwrap());
            let wanted = stage.traversed(&light, &map, MapSurface::Linear);
            for tessellation in [Tessellation::Grid, Tessellation::IndexedGrid, Tessellation::default()] {
                let got = stage.on_gpu(&gpu, &mut fog, &light, Some(&uploaded), volume(tessellation, None));
                let (error, _) = compare(&got, &wanted);
                assert!(error <= 1e-3, "{} {side} {tessellation:?}: {error:.1e}", kind(&light));
            }
        }
    }
}

#[test]
fn little_is_clamped_and_only_where_terms_are_summed() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("hall", (96, 96), 0.3);
        for light in stage.lights() {
            let map = stage.map(&light, 128, MapSurface::Linear);
            let uploaded = upload(&gpu, map.as_ref().unwrap());
            let open = stage.traversed(&light, &None, MapSurface::Linear);
            for kept in [Some(0), None] {
                stage.on_gpu(
                    &gpu,
                    &mut fog,
                    &light,
                    Some(&uploaded),
                    volume(Tessellation::IndexedGrid, kept),
                );
                let clamped = fog.read_clamped(&gpu.device, &gpu.queue, 0).unwrap();
                let count = clamped.iter().filter(|&&amount| amount > 0.0).count();
                let share = |(&amount, whole): (&f32, &[f32; 3])| amount / whole[0].max(1e-20);
                let most = clamped.iter().zip(&open).map(share).fold(0.0_f32, f32::max);
                println!("{} {kept:?}: {count} pixels, {most:.1e} of the unshadowed at most", kind(&light));
                assert!(most <= 2e-5 && (kept.is_some() || count == 0), "{} {kept:?}", kind(&light));
            }
        }
    }
}

/// Two triangles meet at an edge that is seen from its side, next to the end of a ray: what one puts in front of the end
/// the other puts behind it. A pixel of this picture, at (304, 210), is met that way.
#[test]
fn what_a_ray_crosses_twice_at_its_end_adds_nothing() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("lampshade", (512, 512), 1.0);
        let light = stage.lights().remove(0);
        let uploaded = upload(&gpu, &stage.map(&light, 32, MapSurface::Linear).unwrap());
        let mut picture = |kept| {
            stage.on_gpu(
                &gpu,
                &mut fog,
                &light,
                Some(&uploaded),
                volume(Tessellation::IndexedGrid, Some(kept)),
            )
        };
        let (summed, sorted) = (picture(0), picture(40));
        let (error, _) = compare(&summed, &sorted);
        assert!(error < 1e-5, "{error:.1e}");
    }
}
