//! The brute-force march answers to the exact reference: its error falls with the number of steps, at the rate that
//! missed shadow boundaries dictate.
//!
//! A march that finds each boundary to within a step errs by O(1/N) a pixel. Where thin occluders fall between the
//! steps the rate shows only once the steps are finer than they are, which 256 are for all scenes here.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use airlight_tests::picture::{Pixels, rel_rmse, shadow_err};
use airlight_tests::view::View;
use glam::Vec3;
use scene::{Aabb, Density, DirectionalLight, Light, Medium, RgbMedium, Scene, SpotLight};

/// Side of the pictures.
const SIDE: u32 = 48;

/// Least order of convergence between 16 and 256 steps; 1 in theory.
const ORDER: f64 = 0.7;

/// Order of convergence between errors at 16 and at 256 steps.
fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).ln() / 16.0_f64.ln()
}

fn check(name: &str, view: &View) {
    let (exact, unshadowed) = (view.exact(), view.unshadowed());
    let marched: Vec<Pixels> = [16, 64, 256].iter().map(|&samples| view.marched(samples)).collect();
    let figure = |error: &dyn Fn(&Pixels) -> f64| marched.iter().map(error).collect::<Vec<f64>>();
    let shadows = rel_rmse(&unshadowed, &exact);
    assert!(shadows > 0.01, "{name}: shadows change {shadows:.1e}: nothing is tested");
    for (metric, errors) in [
        ("rel_rmse", figure(&|a| rel_rmse(a, &exact))),
        ("shadow_err", figure(&|a| shadow_err(a, &exact, &unshadowed))),
    ] {
        let order = order(errors[0], errors[2]);
        println!("{name}: {metric} {:.2e} {:.2e} {:.2e}, order {order:.2}", errors[0], errors[1], errors[2]);
        assert!(errors[0] > errors[1] && errors[1] > errors[2], "{name}: {metric} does not fall: {errors:?}");
        assert!(order > ORDER, "{name}: {metric} {errors:?} falls with order {order:.2} only");
    }
    // closed forms, but for a spot, whose intensity changes along the ray
    let floor = rel_rmse(&view.marched_unshadowed(256), &unshadowed);
    let spot = view.lights.iter().any(|light| matches!(light, Light::Spot(_)));
    let bar = if spot { 0.02 } else { 2e-6 };
    assert!(floor < bar, "{name}: even without shadows the march is off by {floor:.1e}");
}

fn with_light(name: &str, light: Light) -> View {
    View { lights: vec![light], ..View::procedural(name, SIDE) }
}

#[test]
fn sphere() {
    check("sphere", &View::procedural("sphere", SIDE));
}

#[test]
fn spring() {
    check("spring", &View::procedural("spring", SIDE));
}

#[test]
fn hall() {
    check("hall", &View::procedural("hall", SIDE));
}

#[test]
fn slats() {
    check("slats", &View::procedural("slats", SIDE));
}

#[test]
fn fence() {
    check("fence", &View::procedural("fence", SIDE));
}

#[test]
fn canopy() {
    check("canopy", &View::procedural("canopy", SIDE));
}

#[test]
fn lampshade() {
    check("lampshade", &View::procedural("lampshade", SIDE));
}

#[test]
fn spot_light() {
    let position = Vec3::new(-0.4, 2.6, -2.0);
    let direction = Vec3::new(0.2, 0.9, 1.0) - position;
    let spot = SpotLight::new(position, direction, 0.35, 0.5, Vec3::new(20.0, 18.0, 15.0)).unwrap();
    check("slats, spot", &with_light("slats", Light::Spot(spot)));
}

#[test]
fn directional_light() {
    let sun = DirectionalLight::new(Vec3::new(0.2, -0.6, 1.0), Vec3::splat(3.0)).unwrap();
    check("slats, sun", &with_light("slats", Light::Directional(sun)));
}

#[test]
fn extinction_below_scattering() {
    // a host may state the two by themselves; the vacuum limit has none beside some scattering
    let mut view = View::procedural("slats", SIDE);
    for sigma_t in [0.01, 0.0] {
        view.medium.coefficients = RgbMedium::with_extinction([0.1; 3], [sigma_t; 3]).unwrap();
        check("slats, little extinction", &view);
    }
}

#[test]
fn point_light_inside_a_bounded_medium() {
    let mut view = View::procedural("slats", SIDE);
    view.medium.bounds = Some(Aabb { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 2.5, 2.0) });
    check("slats, bounded", &view);
}

#[test]
fn sun_into_a_bounded_medium() {
    let sun = DirectionalLight::new(Vec3::new(0.2, -0.6, 1.0), Vec3::splat(3.0)).unwrap();
    let mut view = with_light("slats", Light::Directional(sun));
    view.medium.bounds = Some(Aabb { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 2.5, 2.0) });
    check("slats, sun, bounded", &view);
}

/// No reference integrates a medium that varies; what is left is that a finer march changes less.
#[test]
fn a_varying_medium() {
    let bounds = Some(Aabb { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 4.0, 3.0) });
    let base = View::procedural("slats", SIDE).medium;
    let height = Medium { density: Some(Density::height(0.4, 0.5).unwrap()), ..base };
    let bounded = Medium { bounds, ..height.clone() };
    let glowing = Medium { emission: [0.02, 0.01, 0.0], ..bounded.clone() };
    // without bounds most of a ray's steps lie where there is nothing to see, and the march settles late
    for (name, medium, fall) in [
        ("height", height, 1.0),
        ("height, bounded", bounded, 2.0),
        ("height, bounded, glowing", glowing, 2.0),
    ] {
        let view = View { medium, ..View::procedural("slats", SIDE) };
        let marched: Vec<Pixels> = [16, 64, 256, 1024].iter().map(|&n| view.marched(n)).collect();
        let changes: Vec<f64> = marched.windows(2).map(|pair| rel_rmse(&pair[0], &pair[1])).collect();
        println!("{name}: changes {changes:?}");
        assert!(changes.windows(2).all(|pair| pair[0] > fall * pair[1]), "{name}: {changes:?}");
    }
}

/// The march through a medium that may vary, held against the exact picture of one that does not.
#[test]
fn a_varying_medium_of_density_one() {
    let mut view = View::procedural("slats", SIDE);
    view.medium.bounds = Some(Aabb { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 4.0, 3.0) });
    let exact = view.exact();
    view.medium.density = Some(Density::height(1000.0, 1.0).unwrap());
    let errors: Vec<f64> = [16, 64, 256].iter().map(|&n| rel_rmse(&view.marched(n), &exact)).collect();
    println!("density one: {errors:?}");
    assert!(errors[0] > 2.0 * errors[1] && errors[1] > 2.0 * errors[2], "{errors:?}");
    assert!(errors[2] < 0.02, "{errors:?}");
}

#[test]
fn without_triangles_shadows_change_nothing() {
    let view = View::procedural("empty", SIDE);
    assert_eq!(view.exact(), view.unshadowed());
    assert_eq!(view.marched(16), view.marched_unshadowed(16));
    let error = rel_rmse(&view.marched(1), &view.exact());
    assert!(error < 1e-5, "a march with nothing to march is the interval form in f32: {error:.1e}");
}

/// Meshes that are not in the repository, where AIRLIGHT_SCENES names their folder.
#[test]
fn downloaded_scenes() {
    let Some(folder) = std::env::var_os("AIRLIGHT_SCENES").map(std::path::PathBuf::from) else {
        println!("skipped: AIRLIGHT_SCENES is not set");
        return;
    };
    for name in ["bunny_70k.glb", "sponza_dabrovic_66k.glb"] {
        let path = folder.join(name);
        if !path.is_file() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let scene = scene::import::load_gltf(&path).unwrap();
        check(name, &framed(&scene, 24));
    }
}

/// A file's meshes seen from outside, in fog, with a light beside and above them.
fn framed(scene: &Scene, side: u32) -> View {
    let bounds = scene.bounds();
    let size = bounds.diagonal();
    let light = bounds.center() + size * Vec3::new(0.1, 0.6, -0.4);
    View {
        materials: scene.materials.clone(),
        bvh: scene::Bvh::build(scene).unwrap(),
        camera: scene::Camera::framing(&bounds, 0.8),
        medium: Medium::homogeneous([1.0 / size; 3], [0.0; 3]).unwrap(),
        lights: vec![Light::Point(scene::PointLight::new(light, Vec3::splat(size * size)).unwrap())],
        size: (side, side),
    }
}
