//! Adaptive sampling: the error that is asked for, for fewer rays; and the GPU as the CPU.
#![expect(clippy::unwrap_used, reason = "test code")]

mod common;

use std::sync::Arc;

use common::{Stage, compare, fog, gpu, gpus, render, upload};
use glam::DVec3;
use gpu_backend::{
    Adaptive, Fog, Frame, GpuBvh, GpuContext, Hybrid, Lamp, Lookup, PrepareError, Sampling, SceneDepth,
    ShadowCasters, ShadowVolume, Shadows, Technique, Tessellation, View,
};
use hybrid_march::{Adjacency, BruteForce};
use scene::{AirlightModel, Density, Light, LightTexture, Medium, SpotLight, TextureFilter, WideBvh};
use shadowmap::{Bias, ExactShadowMap, MapSurface};

const EXACT: Technique = Technique::ExactShadowMap { surface: MapSurface::Step };

const SIZE: (u32, u32) = (203, 150);

/// A frame of one light by every way to sample.
struct Case<'a> {
    stage: &'a Stage,
    medium: Medium,
    lamps: Vec<Lamp<'a>>,
    technique: Technique,
    model: AirlightModel,
}

impl Case<'_> {
    fn picture(
        &self,
        gpu: &GpuContext,
        fog: &mut Fog,
        sampling: Sampling,
        shadowed: bool,
    ) -> (Vec<[f32; 3]>, u64) {
        let ends = self.stage.ends_f32();
        let view = View {
            camera: &self.stage.camera,
            size: self.stage.size,
            depth: SceneDepth::Distances(&ends),
            max_distance: f64::INFINITY,
        };
        let mut lamps = self.lamps.clone();
        if !shadowed {
            lamps.iter_mut().for_each(|lamp| lamp.shadows = None);
        }
        let frame = Frame {
            views: &[view],
            medium: &self.medium,
            lamps: &lamps,
            model: self.model,
            technique: self.technique,
            sampling,
        };
        let picture = render(gpu, fog, &frame);
        (picture, fog.read_traced_rays(&gpu.device, &gpu.queue, 0).unwrap())
    }

    /// The sampling error as a share of what shadows take away, and the share of rays that were traced.
    fn error(&self, gpu: &GpuContext, fog: &mut Fog, target_error: f32) -> (f64, f64) {
        let (all, count) = self.picture(gpu, fog, Sampling::Pixels, true);
        let (open, _) = self.picture(gpu, fog, Sampling::Pixels, false);
        let adaptive = Adaptive::new(target_error, self.stage.size);
        let (got, traced) = self.picture(gpu, fog, Sampling::Adaptive(adaptive), true);
        assert_eq!(count, u64::from(self.stage.size.0) * u64::from(self.stage.size.1));
        (share(&got, &all, &open), traced as f64 / count as f64)
    }
}

/// ‖a − b‖₂/‖u − b‖₂.
fn share(a: &[[f32; 3]], b: &[[f32; 3]], u: &[[f32; 3]]) -> f64 {
    let (a, b, u) = (distance(a, b), distance(u, b), u.len());
    assert!(b > 0.0 && u > 0, "nothing is in shadow");
    a / b
}

fn distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
    a.as_flattened().iter().zip(b.as_flattened()).map(square).sum::<f64>().sqrt()
}

#[test]
fn the_error_that_is_asked_for_is_met_with_fewer_rays() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    // in a picture as small as this nearly all of fence, canopy and slats is edges
    for (scene, most_rays) in
        [("sphere", 0.6), ("hall", 0.5), ("slats", 1.0), ("fence", 1.0), ("canopy", 1.0)]
    {
        let stage = Stage::procedural(scene, SIZE, 0.5);
        for light in stage.lights() {
            let map = stage.map(&light, 512, MapSurface::Step).unwrap();
            let map = upload(&gpu, &map);
            let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
            let lamps = vec![Lamp { light: &light, shadows, volume: None }];
            let medium = stage.medium.clone();
            let case = Case { stage: &stage, medium, lamps, technique: EXACT, model: AirlightModel::Sun };
            let mut before = 0.0;
            for target in [0.05, 0.01, 0.002] {
                let (error, traced) = case.error(&gpu, &mut fog, target);
                println!("{scene} {target}: shadow_err {error:.5}, rays {:.1} %", 100.0 * traced);
                assert!(error <= f64::from(target), "{scene} {target}: {error:.5}");
                assert!(traced >= before, "{scene} {target}: fewer rays than for a larger error");
                before = traced;
                assert!(target < 0.01 || traced <= most_rays, "{scene} {target}: {traced:.3} of the rays");
            }
        }
    }
}

#[test]
fn every_technique_by_ray_takes_it() {
    for gpu in gpus() {
        let mut fog = fog(&gpu);
        let stage = Stage::procedural("hall", (200, 150), 0.5);
        let lights = stage.lights();
        let casters = stage.bvh.bounds();
        let maps: Vec<_> = lights
            .iter()
            .map(|light| upload(&gpu, &stage.map(light, 256, MapSurface::Step).unwrap()))
            .collect();
        let bvh = GpuBvh::upload(&gpu.device, &WideBvh::build(&stage.scene).unwrap()).unwrap();
        let mesh = Arc::new(
            ShadowCasters::upload(&gpu.device, &Adjacency::of_scene(&stage.scene).unwrap()).unwrap(),
        );
        let volumes: Vec<_> =
            lights.iter().map(|_| ShadowVolume::new(&gpu.device, Arc::clone(&mesh)).unwrap()).collect();
        let (mapped, traced): (Vec<_>, Vec<_>) = lights
            .iter()
            .zip(&maps)
            .zip(&volumes)
            .map(|((light, map), volume)| {
                let lamp = |shadows| Lamp { light, shadows: Some(shadows), volume: Some(volume) };
                (lamp(Shadows::Map { map, casters }), lamp(Shadows::Rays { bvh: &bvh, casters }))
            })
            .unzip();
        let march = Technique::BruteForce { samples: 60, lookup: Lookup::Nearest };
        let hybrid = Technique::Hybrid(Hybrid { samples: 20, ..Hybrid::default() });
        let fog_of_heights =
            Medium { density: Some(Density::height(casters.min.y, 2.0).unwrap()), ..stage.medium.clone() };
        let glowing = Medium { emission: [0.01, 0.02, 0.03], ..fog_of_heights.clone() };
        let cases = [
            ("traversal, three lights", &mapped, stage.medium.clone(), EXACT),
            ("march, three lights", &mapped, stage.medium.clone(), march),
            ("march by rays", &traced, stage.medium.clone(), march),
            ("hybrid, three lights", &mapped, stage.medium.clone(), hybrid),
            ("hybrid by rays", &traced, stage.medium.clone(), hybrid),
            ("march in height fog", &mapped, fog_of_heights, march),
            ("march by rays in glowing fog", &traced, glowing, march),
        ];
        for (name, lamps, medium, technique) in cases {
            let case =
                Case { stage: &stage, medium, lamps: lamps.clone(), technique, model: AirlightModel::Sun };
            let (error, traced) = case.error(&gpu, &mut fog, 0.01);
            println!("{name}: shadow_err {error:.5}, rays {:.1} %", 100.0 * traced);
            assert!(error <= 0.01, "{name}: {error:.5}");
            assert!(traced < 0.8, "{name}: {traced}");
        }
    }
}

#[test]
fn a_textured_spot_takes_it() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    let stage = Stage::procedural("hall", (120, 90), 0.5);
    let Light::Spot(spot) = stage.lights().remove(1) else { panic!("the second is a spot") };
    let panes = (0..64).map(|i| [(i % 8) as f32 / 8.0, (i / 8) as f32 / 8.0, 0.4]).collect();
    let texture = Arc::new(LightTexture::new(8, 8, panes, TextureFilter::Linear).unwrap());
    let light = Light::Spot(SpotLight { texture: Some(texture), ..spot });
    let casters = stage.bvh.bounds();
    let map = upload(&gpu, &stage.map(&light, 256, MapSurface::Step).unwrap());
    let mesh =
        Arc::new(ShadowCasters::upload(&gpu.device, &Adjacency::of_scene(&stage.scene).unwrap()).unwrap());
    let volume = ShadowVolume::new(&gpu.device, mesh).unwrap();
    let lamps = vec![Lamp {
        light: &light,
        shadows: Some(Shadows::Map { map: &map, casters }),
        volume: Some(&volume),
    }];
    for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
        let technique = Technique::Hybrid(Hybrid::default());
        let case =
            Case { stage: &stage, medium: stage.medium.clone(), lamps: lamps.clone(), technique, model };
        let (error, traced) = case.error(&gpu, &mut fog, 0.01);
        println!("{model:?}: shadow_err {error:.5}, rays {:.1} %", 100.0 * traced);
        assert!(error <= 0.01 && traced < 0.8, "{model:?}: {error:.5}, {traced:.2}");
    }
}

#[test]
fn the_gpu_traces_the_rays_that_the_cpu_traces() {
    let Some(gpu) = gpu() else { return };
    let mut fog = fog(&gpu);
    // the last is large enough for a histogram of every second group
    for (scene, size, target_error, spacing) in [
        ("hall", (97, 64), 0.01, 8),
        ("fence", (97, 64), 0.003, 16),
        ("sphere", (97, 64), 0.05, 2),
        ("hall", (600, 500), 0.01, 8),
    ] {
        let stage = Stage::procedural(scene, size, 0.5);
        let light = &stage.lights()[0];
        let map = [stage.map(light, 256, MapSurface::Step)];
        let on_gpu = upload(&gpu, map[0].as_ref().unwrap());
        let shadows = Some(Shadows::Map { map: &on_gpu, casters: stage.bvh.bounds() });
        let lamps = vec![Lamp { light, shadows, volume: None }];
        let medium = stage.medium.clone();
        let case = Case { stage: &stage, medium, lamps, technique: EXACT, model: AirlightModel::Sun };
        let adaptive = Adaptive { target_error, spacing };
        let (got, traced) = case.picture(&gpu, &mut fog, Sampling::Adaptive(adaptive), true);

        let lights = std::slice::from_ref(light);
        let exact = ExactShadowMap::new(&map, lights, MapSurface::Step, Bias::NONE).unwrap();
        let settings = ground_truth::Settings::default();
        let reference = ground_truth::Reference::new(&[], &stage.bvh, &stage.medium, lights, settings)
            .unwrap()
            .with_shadows(&exact);
        let open = BruteForce {
            medium: &stage.medium,
            lights,
            occluders: None,
            samples: 1,
            model: AirlightModel::Sun,
        };
        let of = |pixels: &[(u32, u32)], airlight: &dyn Fn(&scene::DRay, f64) -> DVec3| -> Vec<DVec3> {
            let ray = |&(x, y): &(u32, u32)| {
                let end = stage.ends[(y * stage.size.0 + x) as usize];
                airlight(&stage.camera.pixel_ray(x, y, stage.size), end)
            };
            pixels.iter().map(ray).collect()
        };
        let (want, wanted) = adaptive
            .picture(
                stage.size,
                &stage.ends_f32(),
                |pixels| of(pixels, &|ray, end| reference.airlight(ray, end)),
                |pixels| of(pixels, &|ray, end| open.airlight(ray, end).airlight.as_dvec3()),
            )
            .unwrap();
        let want: Vec<[f32; 3]> = want.into_iter().map(|value| value.as_vec3().to_array()).collect();
        let (rmse, p99) = compare(&got, &want);
        println!("{scene}: rel_rmse {rmse:.1e}, p99 {p99:.1e}, {traced} rays of {wanted}");
        // a ray whose estimate is within rounding of the tolerance may be traced on one side alone
        assert!(traced.abs_diff(wanted) <= 2 + wanted / 500, "{scene}: {traced} rays, {wanted} on the CPU");
        assert!(p99 <= 1e-4 && rmse <= 1e-3, "{scene}: {rmse:.1e}, {p99:.1e}");
    }
}

#[test]
fn what_it_cannot_take_is_refused() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (32, 32), 0.5);
    let lights = stage.lights();
    let map = upload(&gpu, &stage.map(&lights[1], 64, MapSurface::Linear).unwrap());
    let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
    let lamps = [Lamp { light: &lights[1], shadows, volume: None }];
    let view = View {
        camera: &stage.camera,
        size: stage.size,
        depth: SceneDepth::Nothing,
        max_distance: f64::INFINITY,
    };
    let mut fog = fog(&gpu);
    let mut prepare = |technique, adaptive| {
        let frame = Frame {
            views: &[view],
            medium: &stage.medium,
            lamps: &lamps,
            model: AirlightModel::Sun,
            technique,
            sampling: Sampling::Adaptive(adaptive),
        };
        fog.prepare(&gpu.device, &gpu.queue, &frame)
    };
    let usual = Adaptive::default();
    let volume = Technique::LightVolume { tessellation: Tessellation::IndexedGrid, kept: None };
    assert!(matches!(prepare(volume, usual), Err(PrepareError::Refused(_))));
    let froxels = Technique::Froxels(froxel_grid::Froxels::new(10.0));
    assert!(matches!(prepare(froxels, usual), Err(PrepareError::Refused(_))));
    for target_error in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = prepare(EXACT, Adaptive { target_error, ..usual }).unwrap_err();
        assert!(matches!(error, PrepareError::Sampling(_)), "{error}");
    }
    for spacing in [0, 1, 3, 12, 32, u32::MAX] {
        let error = prepare(EXACT, Adaptive { spacing, ..usual }).unwrap_err();
        assert!(error.to_string().contains("2, 4, 8 or 16"), "{error}");
    }
    prepare(EXACT, usual).unwrap();
}
