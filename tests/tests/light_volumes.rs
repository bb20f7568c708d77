//! The signed sum over a light volume's triangles in f32 answers to the exact traversal of the same map, on every scene
//! and for every kind of light.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use airlight_tests::picture::{Pixels, rel_rmse, shadow_err};
use airlight_tests::view::View;
use glam::{DVec3, Vec3};
use ground_truth::{Reference, Settings};
use lightvolume::{Anchor, LightVolume, LightVolumes, Options, SignedAirlight};
use scene::{
    Camera, DRay, DirectionalLight, Interval, Light, LightId, Medium, PointLight, Scene, SpotLight,
    procedural,
};
use shadowmap::{Bias, ExactShadowMap, MapSurface};

/// Side of the pictures.
const SIDE: u32 = 24;

/// Side of the maps.
const MAP: u32 = 128;

/// Texels from a cube's seam within which a boundary is near to it.
const NEAR_SEAM: f64 = 2.0;

/// What shadows must change of a picture for an error to be worth stating as a share of it.
const CHANGED: f64 = 0.01;

/// By how much the sum may pass below 0, as a share of the unshadowed airlight: terms of f32 are rounded before they cancel.
const BELOW_ZERO: f64 = 2e-5;

/// Errors of many rays as shares of their unshadowed airlight.
#[derive(Debug, Default, Clone, Copy)]
struct Errors {
    squares: f64,
    rays: u32,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.squares += error * error;
        self.rays += 1;
    }

    fn plus(self, other: Self) -> Self {
        Self { squares: self.squares + other.squares, rays: self.rays + other.rays }
    }

    fn root_mean_square(self) -> f64 {
        (self.squares / f64::from(self.rays.max(1))).sqrt()
    }
}

/// What a picture by the signed sum is off.
#[derive(Debug)]
struct Found {
    rel_rmse: f64,
    /// Where shadows change at least [`CHANGED`].
    shadow_err: Option<f64>,
    /// Lowest value as a share of the unshadowed one.
    lowest: f64,
    not_finite: usize,
    /// Of rays with a boundary near a seam of a cube, and of those without.
    seams: [Errors; 2],
}

/// The sum against the traversal of the same map, for a view with one light.
fn measure(view: &View, anchor: Anchor) -> Found {
    let maps = view.maps(MAP, MapSurface::Linear);
    let build = |map| LightVolume::build(map, &Options::default()).unwrap();
    let volumes: Vec<Option<LightVolume>> = maps.iter().map(|map| map.as_ref().map(build)).collect();
    let own = LightVolumes::new(&volumes, &view.lights).unwrap();
    let sum = SignedAirlight::<f32>::new(&view.medium, &own, anchor).unwrap();
    let shadows = ExactShadowMap::new(&maps, &view.lights, MapSurface::Linear, Bias::NONE).unwrap();
    let reference = |shadows_in_medium| {
        let settings = Settings { shadows_in_medium, ..Settings::default() };
        Reference::new(&view.materials, &view.bvh, &view.medium, &view.lights, settings).unwrap()
    };
    let (open, exact) = (reference(false), reference(true).with_shadows(&shadows));
    let [mut got, mut wanted, mut unshadowed]: [Pixels; 3] = Default::default();
    let (mut lowest, mut seams) = (0.0_f64, [Errors::default(); 2]);
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        let ray = view.camera.pixel_ray(x, y, view.size);
        let end = view.bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
        let (value, truth, whole) =
            (sum.airlight(&ray, end), exact.airlight(&ray, end), open.airlight(&ray, end));
        let share = |difference: DVec3| {
            let shares = difference / whole;
            // no light at all: nothing is a share of it
            DVec3::select(whole.cmpgt(DVec3::ZERO), shares, difference)
        };
        let wide = DVec3::from(value.map(f64::from));
        lowest = lowest.min(share(wide).min_element());
        let near = near_seam(&own, &view.lights[0], &ray, end);
        seams[usize::from(!near)].add(share(wide - truth).abs().max_element());
        got.push(value);
        wanted.push(truth.as_vec3().to_array());
        unshadowed.push(whole.as_vec3().to_array());
    }
    let changed = rel_rmse(&unshadowed, &wanted) >= CHANGED;
    Found {
        rel_rmse: rel_rmse(&got, &wanted),
        shadow_err: changed.then(|| shadow_err(&got, &wanted, &unshadowed)),
        lowest,
        not_finite: got.as_flattened().iter().filter(|value| !value.is_finite()).count(),
        seams,
    }
}

/// Whether a ray enters or leaves the light of a point within [`NEAR_SEAM`] texels of where two faces of its cube meet.
fn near_seam(volumes: &LightVolumes<'_>, light: &Light, ray: &DRay, end: f64) -> bool {
    let Light::Point(light) = light else { return false };
    let mut boundaries = Vec::new();
    let span = volumes.boundaries(ray, Interval::new(0.0, end), LightId(0), &mut boundaries);
    let inside =
        boundaries.iter().map(|boundary| boundary.distance).filter(|&x| x > span.start && x < span.end);
    inside.into_iter().any(|x| {
        let mut along = (ray.at(x) - light.position.as_dvec3()).abs().to_array();
        along.sort_by(f64::total_cmp);
        0.5 * f64::from(MAP) * (1.0 - along[1] / along[2]) < NEAR_SEAM
    })
}

/// A point light, a soft spot and a sun for a scene: in the place of its own lamp, or of one above it.
fn lights(scene: &Scene) -> [(&'static str, Light); 3] {
    let bounds = scene.bounds();
    let (middle, size) = (bounds.center(), bounds.diagonal().max(1.0));
    let own = scene.lights.iter().find_map(|light| match light {
        Light::Point(light) => Some(light.position),
        Light::Spot(light) => Some(light.position),
        Light::Directional(_) => None,
    });
    let middle = if middle.is_finite() { middle } else { Vec3::ZERO };
    let position = own.unwrap_or(middle + size * Vec3::new(0.31, 0.43, 0.17));
    // past the middle, so that the cone is not lost in a lone body
    let towards = middle + 0.2 * size * Vec3::new(0.8, 0.6, 0.0) - position;
    let power = Vec3::new(10.0, 8.0, 6.0);
    let sun = DirectionalLight::new(Vec3::new(0.35, -1.0, 0.28), power).unwrap();
    [
        ("point", Light::Point(PointLight::new(position, power).unwrap())),
        ("spot", Light::Spot(SpotLight::new(position, towards, 0.25, 0.5, power).unwrap())),
        ("sun", Light::Directional(sun)),
    ]
}

/// Holds all bars for all lights and both anchors; returns the errors near the seams of the point light's cube, and elsewhere.
fn check(name: &str, scene: &Scene) -> [Errors; 2] {
    let mut view = View::of(scene, SIDE);
    let mut seams = [Errors::default(); 2];
    for (kind, light) in lights(scene) {
        view.lights = vec![light];
        for anchor in [Anchor::Near, Anchor::Far] {
            let found = measure(&view, anchor);
            let Found { rel_rmse, shadow_err, lowest, not_finite, .. } = found;
            println!(
                "{name}, {kind}, {anchor:?}: {rel_rmse:.1e}, {:.1e} of the shadows, {lowest:.1e}",
                shadow_err.unwrap_or(0.0)
            );
            assert_eq!(not_finite, 0, "{name}, {kind}: {found:?}");
            assert!(rel_rmse <= 1e-3, "{name}, {kind}: {found:?}");
            assert!(shadow_err.is_none_or(|error| error <= 2e-3), "{name}, {kind}: {found:?}");
            assert!(lowest >= -BELOW_ZERO, "{name}, {kind}: {found:?}");
            seams = [0, 1].map(|i| seams[i].plus(found.seams[i]));
        }
    }
    seams
}

/// Nothing special happens where two faces of a cube meet.
fn check_seams([near, elsewhere]: [Errors; 2]) {
    let (a, b) = (near.root_mean_square(), elsewhere.root_mean_square());
    println!("seams: {a:.1e} near ({} rays), {b:.1e} elsewhere ({} rays)", near.rays, elsewhere.rays);
    assert!(near.rays > 200, "{} rays near a seam", near.rays);
    assert!(a <= 3.0 * b, "{a:.1e} near a seam, {b:.1e} elsewhere");
}

#[test]
fn the_signed_sum_is_the_traversal_of_the_map() {
    let mut seams = [Errors::default(); 2];
    for (name, _) in procedural::NAMES {
        let scene = procedural::generate(name).unwrap();
        // the largest, and without optimisation all but the small, take more time than they are worth
        if scene.triangle_count() > if cfg!(debug_assertions) { 30_000 } else { 200_000 } {
            continue;
        }
        let found = check(name, &scene);
        seams = [0, 1].map(|i| seams[i].plus(found[i]));
    }
    check_seams(seams);
}

/// Scenes that are not in the repository, seen from inside and from outside, lit from inside and from above.
#[test]
#[ignore = "needs AIRLIGHT_SCENES and minutes"]
fn the_signed_sum_is_the_traversal_on_files() {
    let folder = std::env::var_os("AIRLIGHT_SCENES").unwrap();
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    paths.sort();
    assert!(!paths.is_empty(), "a folder of scenes");
    let mut seams = [Errors::default(); 2];
    for path in paths {
        let mut scene = scene::import::load_gltf(&path).unwrap();
        let bounds = scene.bounds();
        let (middle, size) = (bounds.center(), bounds.max - bounds.min);
        let at = |x: f32, y: f32, z: f32| middle + size * Vec3::new(x, y, z);
        scene.medium = Some(Medium::homogeneous([1.0 / bounds.diagonal(); 3], [0.0; 3]).unwrap());
        let views = [
            ("inside", at(-0.35, -0.1, 0.05), at(0.4, 0.0, 0.0), at(0.1, 0.2, -0.05)),
            ("outside", at(0.6, 0.5, 1.5), middle, at(-0.2, 0.4, -0.8)),
        ];
        for (place, eye, target, lamp) in views {
            scene.cameras = vec![Camera::look_at(eye, target, Vec3::Y, 0.9).unwrap()];
            scene.lights = vec![Light::Point(PointLight::new(lamp, Vec3::ONE).unwrap())];
            let name = format!("{}, {place}", path.file_stem().unwrap().to_string_lossy());
            let found = check(&name, &scene);
            seams = [0, 1].map(|i| seams[i].plus(found[i]));
        }
    }
    check_seams(seams);
}
