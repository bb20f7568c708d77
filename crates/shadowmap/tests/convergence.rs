//! What a map misses of a scene falls as the map grows.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use glam::DVec3;
use ground_truth::ExactShadows;
use media_math::{Foot, HomogeneousMedium, PhaseFunction, airlight, directional_airlight};
use scene::{Bvh, Camera, DRay, DirectionalLight, Interval, Light, LightId, LitIntervals, Scene, procedural};
use shadowmap::{Bias, ExactShadowMap, MapSurface, draw_maps};

const SIZE: (u32, u32) = (40, 40);

fn picture(bvh: &Bvh, camera: &Camera, light: &Light, shadows: &dyn LitIntervals) -> Vec<f64> {
    let medium = HomogeneousMedium::<f64, f64>::new(0.1, 0.0).unwrap();
    let phase = PhaseFunction::<f64>::default();
    let mut lit = Vec::new();
    let mut pixel = |ray: &DRay| {
        let end = bvh.closest_hit(ray, 60.0).map_or(60.0, |hit| hit.distance);
        shadows.lit_intervals(ray, Interval::new(0.0, end), LightId(0), &mut lit);
        let piece = |piece: &Interval| match light {
            Light::Point(light) => {
                let to: DVec3 = light.position.as_dvec3() - ray.origin;
                let foot = Foot::new(to.to_array(), ray.direction.to_array());
                airlight(&medium, &phase, 1.0, &foot, piece.start, piece.end)
            }
            _ => directional_airlight(&medium, 0.08, 1.0, piece.start, piece.end),
        };
        lit.iter().map(piece).sum::<f64>()
    };
    (0..SIZE.0 * SIZE.1).map(|i| pixel(&camera.pixel_ray(i % SIZE.0, i / SIZE.0, SIZE))).collect()
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

fn errors(scene: &Scene, light: Light, surface: MapSurface) -> Vec<f64> {
    let bvh = Bvh::build(scene).unwrap();
    let lights = [light];
    let (camera, light) = (&scene.cameras[0], &lights[0]);
    let exact = picture(&bvh, camera, light, &ExactShadows::new(&bvh, &lights));
    let unshadowed = picture(&bvh, camera, light, &scene::Unoccluded);
    let effect = norm(exact.iter().zip(&unshadowed).map(|(a, b)| a - b));
    [64, 256, 512]
        .map(|side| {
            let maps = draw_maps(&lights, scene, side).unwrap();
            let shadows = ExactShadowMap::new(&maps, &lights, surface, Bias::NONE).unwrap();
            let ours = picture(&bvh, camera, light, &shadows);
            norm(ours.iter().zip(&exact).map(|(a, b)| a - b)) / effect
        })
        .to_vec()
}

#[test]
fn airlight_approaches_the_exact_reference() {
    let sun = DirectionalLight::new(glam::Vec3::new(0.3, -1.0, 0.2), glam::Vec3::ONE).unwrap();
    for (name, light) in [
        ("sphere-plane", None),
        ("slats", None),
        ("lampshade", None),
        ("sphere", Some(sun)),
        ("slats", Some(sun)),
        ("spring", Some(sun)),
    ] {
        let scene = procedural::generate(name).unwrap();
        let light = light.map_or_else(|| scene.lights[0].clone(), Light::Directional);
        for surface in [MapSurface::Step, MapSurface::Linear] {
            let errors = errors(&scene, light.clone(), surface);
            println!("{name} {surface:?}: share of the shadows' effect {errors:?}");
            assert!(errors[1] < 0.6 * errors[0] && errors[2] < 0.8 * errors[1], "{name}: {errors:?}");
            assert!(errors[2] < 0.08, "{name}: {errors:?}");
        }
    }
}
