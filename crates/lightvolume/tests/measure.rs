//! Measurements, not checks: triangles against error, time of a picture. Run with `--ignored --nocapture`.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::adaptive;
use glam::Vec3;
use ground_truth::{Reference, Settings};
use lightvolume::{Anchor, Criterion, LightVolume, LightVolumes, Options, SignedAirlight, Tessellation};
use scene::{Bvh, Camera, Interval, Light, LightId, LitIntervals, Medium, Scene, SpotLight};
use shadowmap::{MapSurface, draw_maps_for};
use std::path::Path;
use std::time::Instant;

const SIZE: (u32, u32) = (256, 256);

struct View {
    scene: Scene,
    bvh: Bvh,
    camera: Camera,
    lights: [Light; 1],
    medium: Medium,
}

/// Sponza with a spot in its nave, if the scenes are there.
fn sponza() -> Option<View> {
    let folder = std::env::var("AIRLIGHT_SCENES").ok()?;
    let scene = scene::import::load_gltf(&Path::new(&folder).join("sponza_dabrovic_66k.glb")).unwrap();
    let bvh = Bvh::build(&scene).unwrap();
    let (eye, target) = (Vec3::new(-11.0, 1.6, 0.4), Vec3::new(6.0, 2.6, 0.0));
    let camera = Camera::look_at(eye, target, Vec3::Y, 60_f32.to_radians()).unwrap();
    let position = Vec3::new(-12.28, 8.52, 1.64);
    let direction = Vec3::new(-3.6, -1.05, -0.3) - position;
    let cone = [30_f32, 40.0].map(f32::to_radians);
    let spot = SpotLight::new(position, direction, cone[0], cone[1], Vec3::splat(300.0)).unwrap();
    // an optical depth of 0.3 over the 17 m that are in view
    let medium = Medium::homogeneous([0.3 / 17.0; 3], [0.0; 3]).unwrap();
    Some(View { scene, bvh, camera, lights: [Light::Spot(spot)], medium })
}

impl View {
    fn reference(&self, shadows_in_medium: bool) -> Reference<'_> {
        let settings = Settings { shadows_in_medium, airlight_only: true, ..Settings::default() };
        Reference::new(&self.scene.materials, &self.bvh, &self.medium, &self.lights, settings).unwrap()
    }

    fn picture(&self, reference: &Reference<'_>) -> Vec<f64> {
        let rows = reference.render(&self.camera, SIZE, &|_| ());
        rows.iter().map(|pixel| f64::from(pixel[0])).collect()
    }
}

/// ‖a − b‖/‖u − b‖: the error as a share of what shadows change at all.
fn shadow_err(a: &[f64], b: &[f64], u: &[f64]) -> f64 {
    let apart = |a: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    apart(a) / apart(u)
}

#[test]
#[ignore = "a measurement; set AIRLIGHT_SCENES to the folder of the scenes"]
fn triangles_against_error() {
    let Some(view) = sponza() else { return println!("no scenes: nothing measured") };
    let exact = view.picture(&view.reference(true));
    let open = view.picture(&view.reference(false));
    for n in [512, 1024] {
        let maps = draw_maps_for(&view.lights, &view.scene, n, MapSurface::Linear).unwrap();
        let map = maps[0].as_ref().unwrap();
        let mut of_map = Vec::new();
        let mut tessellations = vec![Tessellation::Static];
        for metres in [0.003, 0.01, 0.03, 0.1, 0.3, 1.0] {
            for criterion in [Criterion::Distance, Criterion::Laplacian] {
                tessellations.push(Tessellation::Adaptive { criterion, threshold: metres });
            }
            tessellations.push(Tessellation::Delaunay { bound: metres });
        }
        for tessellation in tessellations {
            let time = Instant::now();
            let volumes = [Some(LightVolume::build(map, &Options::new(tessellation)).unwrap())];
            let built = time.elapsed();
            let own = LightVolumes::new(&volumes, &view.lights).unwrap();
            let indexed = time.elapsed() - built;
            let picture = view.picture(&view.reference(true).with_shadows(&own));
            if of_map.is_empty() {
                of_map.clone_from(&picture);
            }
            println!(
                "{n}: {tessellation:?}: {} triangles, built in {built:.2?}, indexed in {indexed:.2?}, picture in \
                 {:.2?}, shadow_err {:.5}, against the map {:.6}",
                volumes[0].as_ref().unwrap().triangles().len(),
                time.elapsed() - built - indexed,
                shadow_err(&picture, &exact, &open),
                shadow_err(&picture, &of_map, &open),
            );
        }
    }
}

#[test]
#[ignore = "a measurement; set AIRLIGHT_SCENES to the folder of the scenes"]
fn a_picture() {
    let Some(view) = sponza() else { return println!("no scenes: nothing measured") };
    let rays: Vec<_> = (0..SIZE.0 * SIZE.1)
        .map(|i| view.camera.pixel_ray(i % SIZE.0, i / SIZE.0, SIZE))
        .map(|ray| (ray, view.reference(true).end_of(&ray).1))
        .collect();
    for n in [512, 1024, 2048] {
        let maps = draw_maps_for(&view.lights, &view.scene, n, MapSurface::Linear).unwrap();
        for options in [Options::default(), adaptive(Criterion::Distance, 0.1)] {
            let volumes = [Some(LightVolume::build(maps[0].as_ref().unwrap(), &options).unwrap())];
            let own = LightVolumes::new(&volumes, &view.lights).unwrap();
            let (time, mut out, mut pieces) = (Instant::now(), Vec::new(), 0);
            for (ray, end) in &rays {
                own.lit_intervals(ray, Interval::new(0.0, *end), LightId(0), &mut out);
                pieces += out.len();
            }
            let found = time.elapsed();
            for anchor in [Anchor::Near, Anchor::Far] {
                let (time, signed) = (Instant::now(), SignedAirlight::<f32>::new(&view.medium, &own, anchor));
                let signed = signed.unwrap();
                let sum: f64 = rays.iter().map(|(ray, end)| f64::from(signed.airlight(ray, *end)[0])).sum();
                println!(
                    "{n} {options:?} {anchor:?}: {:?} on one core ({found:?} for {pieces} pieces), mean {}",
                    time.elapsed(),
                    sum / rays.len() as f64
                );
            }
        }
    }
}
