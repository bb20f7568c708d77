//! Pictures by shadow maps: what a map is worth falls into place as it grows, a march with lookups answers to the
//! traversal of the same map, and nothing is drawn where nothing casts a shadow.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use std::sync::Arc;

use airlight_tests::picture::{Pixels, rel_rmse, shadow_err};
use airlight_tests::view::View;
use glam::Vec3;
use scene::{Aabb, DirectionalLight, Light, LightTexture, SpotLight, TextureFilter};
use shadowmap::MapSurface;

/// Side of the pictures.
const SIDE: u32 = 32;

const SURFACES: [MapSurface; 2] = [MapSurface::Step, MapSurface::Linear];

fn spot() -> SpotLight {
    let position = Vec3::new(-0.4, 2.6, -2.0);
    let direction = Vec3::new(0.2, 0.9, 1.0) - position;
    SpotLight::new(position, direction, 0.35, 0.5, Vec3::new(20.0, 18.0, 15.0)).unwrap()
}

/// A spot through a picture of coarse texels.
fn projector() -> SpotLight {
    let texels = (0..30).map(|i| [0.2 + 0.1 * (i % 7) as f32, 0.5, 1.0 - 0.1 * (i % 5) as f32]).collect();
    let texture = LightTexture::new(6, 5, texels, TextureFilter::Nearest).unwrap();
    SpotLight { texture: Some(Arc::new(texture)), ..spot() }
}

/// Slats in the light of every kind.
fn views() -> Vec<(&'static str, View)> {
    let slats = |light| View { lights: vec![light], ..View::procedural("slats", SIDE) };
    let sun = DirectionalLight::new(Vec3::new(0.2, -0.6, 1.0), Vec3::splat(3.0)).unwrap();
    let mut bounded = slats(Light::Spot(spot()));
    bounded.medium.bounds = Some(Aabb { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 2.5, 2.0) });
    vec![
        ("point", View::procedural("slats", SIDE)),
        ("spot", slats(Light::Spot(spot()))),
        ("textured spot", slats(Light::Spot(projector()))),
        ("spot into a bounded medium", bounded),
        ("sun", slats(Light::Directional(sun))),
    ]
}

#[test]
fn a_growing_map_approaches_exact() {
    for (name, view) in views() {
        let (exact, unshadowed) = (view.exact(), view.unshadowed());
        assert!(rel_rmse(&unshadowed, &exact) > 0.01, "{name}: shadows change nothing");
        for surface in SURFACES {
            let error = |side| shadow_err(&view.exact_shadow_map(side, surface), &exact, &unshadowed);
            let errors = [64, 256, 1024].map(error);
            println!("{name}, {surface:?}: {errors:?}");
            assert!(errors[1] < 0.7 * errors[0] && errors[2] < 0.4 * errors[1], "{name}: {errors:?}");
            assert!(errors[2] < 0.06, "{name}, {surface:?}: {errors:?}");
        }
    }
}

#[test]
fn a_march_with_lookups_approaches_the_traversal() {
    // coarse on purpose: the two must agree about the map, not about the scene
    let side = 48;
    for (name, view) in views() {
        let unshadowed = view.unshadowed();
        for surface in SURFACES {
            let exact = view.exact_shadow_map(side, surface);
            let marched: Vec<Pixels> = [16, 128, 1024]
                .iter()
                .map(|&samples| view.marched_with_maps(samples, side, surface))
                .collect();
            let errors: Vec<f64> = marched.iter().map(|a| shadow_err(a, &exact, &unshadowed)).collect();
            println!("{name}, {surface:?}: {errors:?}");
            assert!(errors[1] < 0.25 * errors[0] && errors[2] < 0.25 * errors[1], "{name}: {errors:?}");
            // the other meaning is no limit of it
            let other = SURFACES.into_iter().find(|other| *other != surface).unwrap();
            let wrong = shadow_err(&marched[2], &view.exact_shadow_map(side, other), &unshadowed);
            assert!(wrong > 5.0 * errors[2], "{name}: {wrong:.1e} from the other meaning, {errors:?}");
        }
    }
}

#[test]
fn no_meaning_of_a_map_cuts_a_cone() {
    // everything stands behind the lamp, so that all of the cone is lit
    let mut view = View::procedural("slats", SIDE);
    let bounds = view.bvh.bounds();
    let above = Vec3::new(0.0, bounds.max.y + 1.0, 0.0);
    let up = SpotLight::new(above, Vec3::Y, 0.3, 0.6, Vec3::ONE).unwrap();
    view.lights = vec![Light::Spot(up)];
    view.camera =
        scene::Camera::look_at(above + Vec3::new(0.0, 1.0, 6.0), above + Vec3::Y, Vec3::Y, 0.8).unwrap();
    let unshadowed = view.unshadowed();
    assert!(unshadowed.as_flattened().iter().any(|value| *value > 0.0));
    for surface in SURFACES {
        for side in [2, 3, 8, 64] {
            let error = rel_rmse(&view.exact_shadow_map(side, surface), &unshadowed);
            assert!(error < 1e-6, "{surface:?}, {side}: {error:.1e}");
        }
    }
}

#[test]
fn without_triangles_no_map_is_drawn() {
    let view = View::procedural("empty", SIDE);
    for surface in SURFACES {
        let maps = view.maps(1 << 14, surface);
        assert_eq!(maps.len(), view.lights.len());
        assert!(maps.iter().all(Option::is_none), "a map without a scene");
        assert_eq!(view.exact_shadow_map(64, surface), view.unshadowed());
        assert_eq!(view.marched_with_maps(16, 64, surface), view.marched_unshadowed(16));
    }
}
