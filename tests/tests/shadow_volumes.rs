//! Shadow volumes on the CPU answer to the exact shadows: no dark piece of any ray lies outside of what the volume's
//! faces bound, and the march between them errs less than the one that knows no faces.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use airlight_tests::picture::{Pixels, rel_rmse, shadow_err};
use airlight_tests::view::View;
use glam::{DVec3, Vec3};
use ground_truth::{ExactShadows, render_rows};
use hybrid_march::{Adjacency, FaceBounds, Hybrid, Occluders, ShadowVolume, Silhouette};
use scene::{
    AirlightModel, Bvh, BvhVisibility, Camera, DRay, DirectionalLight, Interval, Light, LightId,
    LitIntervals, PointLight, Scene, SpotLight, Visibility, procedural,
};

const ALL: Interval = Interval::new(0.0, f64::INFINITY);

/// Generated scenes, without the largest where the program is checked and slow.
fn scenes() -> Vec<(&'static str, Scene)> {
    let names = procedural::NAMES.iter().map(|&(name, _)| name);
    let small = names.filter(|name| !cfg!(debug_assertions) || !name.ends_with("755k"));
    small.map(|name| (name, procedural::generate(name).unwrap())).collect()
}

/// Meshes that are not in the repository, where AIRLIGHT_SCENES names their folder, under a light beside and above them.
fn downloaded() -> Vec<(String, Scene)> {
    let Some(folder) = std::env::var_os("AIRLIGHT_SCENES") else {
        println!("AIRLIGHT_SCENES is not set");
        return Vec::new();
    };
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "glb"));
    paths.sort();
    let named = paths.iter().map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), path));
    named
        .filter(|(name, _)| !name.contains("bistro"))
        .map(|(name, path)| {
            let mut scene = scene::import::load_gltf(path).unwrap();
            let (middle, size) = (scene.bounds().center(), scene.bounds().diagonal());
            let at = middle + size * Vec3::new(0.1, 0.3, -0.2);
            scene.lights = vec![
                Light::Point(PointLight::new(at, Vec3::ONE).unwrap()),
                Light::Directional(DirectionalLight::new(Vec3::new(0.2, -1.0, 0.4), Vec3::ONE).unwrap()),
            ];
            (name, scene)
        })
        .collect()
}

#[test]
fn volumes_of_generated_scenes_are_closed() {
    for (name, scene) in scenes() {
        let start = std::time::Instant::now();
        let mesh = Adjacency::of_scene(&scene).unwrap();
        let built = start.elapsed();
        for light in &scene.lights {
            let start = std::time::Instant::now();
            let silhouette = Silhouette::of(&mesh, light);
            let found = start.elapsed();
            println!(
                "{name}: {} triangles, {} edges in {built:.1?}, {} on the silhouette in {found:.1?}",
                mesh.triangles().len(),
                mesh.edges().len(),
                silhouette.edges.len(),
            );
            assert!(silhouette.is_closed(&mesh), "{name}");
        }
    }
}

/// Numbers from 0 to 1, the same on every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    /// A ray from a point of a box twice as large as `scene`'s in any direction.
    fn ray(&mut self, middle: DVec3, extent: DVec3) -> DRay {
        let mut cube = || DVec3::new(self.next(), self.next(), self.next()) - 0.5;
        let origin = middle + 2.0 * extent * cube();
        let direction = loop {
            let v = 2.0 * cube();
            if v.length() < 1.0 && v.length() > 0.1 {
                break v.normalize();
            }
        };
        // as a pixel's ray: from a point that f32 holds, as visibility is asked in f32
        DRay { origin: origin.as_vec3().as_dvec3(), direction }
    }
}

/// Shadow rays in `f64`.
struct Occlusion<'a>(&'a Bvh, &'a [Light]);

impl Visibility for Occlusion<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        let point = point.as_dvec3();
        let (to_light, far) = match &self.1[light.0] {
            Light::Point(light) => (light.position.as_dvec3() - point, 1.0),
            Light::Spot(light) => (light.position.as_dvec3() - point, 1.0),
            Light::Directional(light) => (-light.direction.as_dvec3(), f64::INFINITY),
        };
        let ray = DRay { origin: point, direction: to_light.normalize() };
        f32::from(!self.0.occluded(&ray, 0.0, far * to_light.length()))
    }
}

/// What was found of some rays.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    rays: usize,
    /// Rays with a dark piece.
    dark: usize,
    /// Rays with bounds.
    bounded: usize,
    /// Rays of which a dark piece lies outside of the bounds.
    missed: usize,
    /// The same with visibility asked in `f32`: where the last face is a thousand scenes away, a shadow ray from behind it
    /// may slip past an occluder.
    missed_f32: usize,
    /// Lengths of all bounds, and of the true ones; units: m.
    length: f64,
    true_length: f64,
}

impl Tally {
    fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            dark: self.dark + other.dark,
            bounded: self.bounded + other.bounded,
            missed: self.missed + other.missed,
            missed_f32: self.missed_f32 + other.missed_f32,
            length: self.length + other.length,
            true_length: self.true_length + other.true_length,
        }
    }
}

/// One light of a scene, and what answers for its shadows.
struct Lit<'a> {
    bvh: &'a Bvh,
    lights: &'a [Light],
    id: LightId,
    volume: &'a ShadowVolume,
}

impl Lit<'_> {
    /// Holds the bounds on one ray against its dark pieces.
    fn check(&self, ray: &DRay, size: f64) -> Tally {
        let end = self.bvh.closest_hit(ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
        let span = Interval::new(0.0, end);
        let bounds = self.volume.bounds(ray, span, self.id, &Occlusion(self.bvh, self.lights));
        let of_f32 = BvhVisibility::new(self.bvh, self.lights);
        let bounds_f32 = self.volume.bounds(ray, span, self.id, &of_f32);
        let mut lit = Vec::new();
        ExactShadows::new(self.bvh, self.lights).lit_intervals(ray, span, self.id, &mut lit);
        let slack = |x: f64| 1e-6 * x.max(size);
        // the hull of what is dark, of pieces that are more than rounding
        let mut hull: Option<Interval> = None;
        let mut from = 0.0;
        for (start, next) in lit.iter().map(|piece| (piece.start, piece.end)).chain([(end, end)]) {
            if start - from > slack(from) {
                hull = Some(Interval::new(hull.map_or(from, |hull| hull.start), start));
            }
            from = next;
        }
        let misses = |bounds: Option<Interval>| {
            let holds = |hull: Interval, b: Interval| {
                b.start <= hull.start + slack(hull.start) && b.end >= hull.end - slack(hull.end)
            };
            hull.is_some_and(|hull| !bounds.is_some_and(|bounds| holds(hull, bounds)))
        };
        let missed = misses(bounds);
        if missed {
            println!("missed: {ray:?} to {end}: dark {hull:?}, bounds {bounds:?}");
        }
        // lengths up to four sizes of the scene, so that infinite ones count too
        let length = |piece: Option<Interval>| {
            piece.map_or(0.0, |p| p.intersect(Interval::new(0.0, 4.0 * size)).length().max(0.0))
        };
        Tally {
            rays: 1,
            dark: usize::from(hull.is_some()),
            bounded: usize::from(bounds.is_some()),
            missed: usize::from(missed),
            missed_f32: usize::from(misses(bounds_f32)),
            length: length(bounds),
            true_length: length(hull),
        }
    }
}

/// Rays at random through a scene, in the light of each of its lights.
fn check_bounds(name: &str, scene: &Scene, rays: u32) -> usize {
    if scene.triangle_count() == 0 {
        return 0;
    }
    let (bvh, mesh) = (Bvh::build(scene).unwrap(), Adjacency::of_scene(scene).unwrap());
    let middle = scene.bounds().center().as_dvec3();
    // a box of some depth, for the sake of single triangles
    let size = f64::from(scene.bounds().diagonal());
    let extent = (scene.bounds().max - scene.bounds().min).as_dvec3().max(DVec3::splat(0.3 * size));
    let mut missed = 0;
    for id in 0..scene.lights.len() {
        let volume = ShadowVolume::new(&mesh, &scene.lights[id]);
        let lit = Lit { bvh: &bvh, lights: &scene.lights, id: LightId(id), volume: &volume };
        let start = std::time::Instant::now();
        let tallies = render_rows((rays / 100, 100), &|_| (), |x, y| {
            let mut random = Random(u64::from(y) << 32 | u64::from(x));
            random.next();
            lit.check(&random.ray(middle, extent), size)
        });
        let sum = tallies.into_iter().fold(Tally::default(), Tally::plus);
        println!(
            "{name}, light {id}: {} rays in {:.1?}, {} faces, dark {}, bounded {}, missed {} (f32: {}), tightness {:.3}",
            sum.rays,
            start.elapsed(),
            volume.face_count(),
            sum.dark,
            sum.bounded,
            sum.missed,
            sum.missed_f32,
            sum.length / sum.true_length,
        );
        assert!(sum.dark > 0, "{name}: no shadow, nothing is tested");
        assert!(200 * sum.missed_f32 <= sum.rays, "{name}: {} missed in f32", sum.missed_f32);
        missed += sum.missed;
    }
    missed
}

#[test]
fn no_shadow_lies_outside_the_bounds() {
    for (name, scene) in scenes() {
        assert_eq!(check_bounds(name, &scene, 2_000), 0, "{name}");
    }
    for (name, scene) in downloaded() {
        assert_eq!(check_bounds(&name, &scene, 500), 0, "{name}");
    }
}

#[test]
#[ignore = "minutes in a release build"]
fn no_shadow_of_many_lies_outside_the_bounds() {
    let mut missed = Vec::new();
    for (name, scene) in scenes() {
        missed.push((name.to_owned(), check_bounds(name, &scene, 100_000)));
    }
    for (name, scene) in downloaded() {
        missed.push((name.clone(), check_bounds(&name, &scene, 100_000)));
    }
    missed.retain(|&(_, count)| count > 0);
    assert!(missed.is_empty(), "{missed:?}");
}

/// Cameras outside of the shadow, and inside of it.
fn cameras(scene: &Scene, bvh: &Bvh) -> Vec<Camera> {
    let visibility = BvhVisibility::new(bvh, &scene.lights);
    let dark = |eye: Vec3| visibility.visibility(eye, LightId(0)) == 0.0;
    let bounds = scene.bounds();
    let mut random = Random(5);
    let inside = (0..100_000)
        .map(|_| {
            let share = Vec3::new(random.next() as f32, random.next() as f32, random.next() as f32);
            bounds.min + share * (bounds.max - bounds.min)
        })
        .find(|&eye| dark(eye))
        .unwrap();
    let fov = 0.9;
    let around =
        Camera::look_at(inside, bounds.center() + Vec3::new(0.01, 0.02, 0.03), Vec3::Y, fov).unwrap();
    vec![scene.cameras[0].clone(), around]
}

fn check_drawn(name: &str, size: (u32, u32)) {
    let scene = procedural::generate(name).unwrap();
    let (bvh, mesh) = (Bvh::build(&scene).unwrap(), Adjacency::of_scene(&scene).unwrap());
    let volume = ShadowVolume::new(&mesh, &scene.lights[0]);
    for (i, camera) in cameras(&scene, &bvh).iter().enumerate() {
        let start = std::time::Instant::now();
        let by_pixel = FaceBounds::draw(&volume, camera, size, 1);
        let pixels = start.elapsed();
        let by_tile = FaceBounds::draw(&volume, camera, size, 8);
        let exact = render_rows(size, &|_| (), |x, y| volume.faces(&camera.pixel_ray(x, y, size), ALL));
        let near = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-6 * b;
        let (mut differ, mut missed, mut met) = (0, 0, 0);
        for y in 0..size.1 {
            for x in 0..size.0 {
                let exact = exact[(y * size.0 + x) as usize];
                match (by_pixel.at(x, y), exact) {
                    (None, None) => {}
                    (Some(a), Some(b)) if near(a.start, b.start) && near(a.end, b.end) => {}
                    _ => differ += 1,
                }
                let Some(exact) = exact else { continue };
                met += 1;
                let held = by_tile.at(x, y).is_some_and(|tile| {
                    tile.start <= exact.start * (1.0 + 1e-9) && tile.end >= exact.end * (1.0 - 1e-9)
                });
                missed += usize::from(!held);
            }
        }
        let count = (size.0 * size.1) as usize;
        println!(
            "{name}, camera {i}: {met} of {count} pixels meet a face, {differ} differ, {missed} missed; \
             {} faces drawn in {pixels:.1?}",
            volume.face_count()
        );
        assert!(met > count / 50, "{name}, camera {i}: {met} pixels meet a face: nothing is tested");
        assert!(differ * 1000 <= count, "{name}, camera {i}: {differ} pixels of {count} differ");
        assert_eq!(missed, 0, "{name}, camera {i}: by tile");
    }
}

#[test]
fn drawn_faces_are_those_of_the_rays() {
    check_drawn("sphere", (161, 120));
    check_drawn("slats", (161, 120));
    check_drawn("hall", (64, 48));
    check_drawn("knot-188k", (64, 48));
}

/// The airlight of a view by the hybrid, with faces drawn by tile of `scale` pixels.
fn hybrid(view: &View, volumes: &[ShadowVolume], scale: u32, samples: u32, refine: u32) -> Pixels {
    let visibility = BvhVisibility::new(&view.bvh, &view.lights);
    let occluders = Occluders { visibility: &visibility, bounds: view.bvh.bounds() };
    let march = Hybrid::new(&view.medium, &view.lights, Some(occluders), samples, refine, AirlightModel::Sun)
        .unwrap();
    let drawn: Vec<FaceBounds> =
        volumes.iter().map(|volume| FaceBounds::draw(volume, &view.camera, view.size, scale)).collect();
    render_rows(view.size, &|_| (), |x, y| {
        let ray = view.camera.pixel_ray(x, y, view.size);
        let end = view.bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
        let faces: Vec<_> = drawn.iter().map(|drawn| drawn.at(x, y)).collect();
        march.airlight(&ray, end, &faces).airlight.to_array()
    })
}

/// A scene in the light of a lamp, of a spot at its place, and of a sun from there.
fn views(name: &str) -> [(String, View, Vec<ShadowVolume>); 3] {
    let scene = procedural::generate(name).unwrap();
    let mesh = Adjacency::of_scene(&scene).unwrap();
    let middle = scene.bounds().center();
    let Light::Point(lamp) = scene.lights[0] else { unreachable!("{name} has a lamp") };
    let to = middle - lamp.position;
    let lights = [
        ("point", Light::Point(lamp)),
        ("spot", Light::Spot(SpotLight::new(lamp.position, to, 0.8, 1.2, lamp.intensity).unwrap())),
        ("sun", Light::Directional(DirectionalLight::new(to, Vec3::splat(3.0)).unwrap())),
    ];
    lights.map(|(kind, light)| {
        let volume = ShadowVolume::new(&mesh, &light);
        let view = View { lights: vec![light], ..View::of(&scene, 32) };
        (format!("{name}, {kind}"), view, vec![volume])
    })
}

#[test]
fn a_march_between_faces_errs_less() {
    for name in ["sphere", "slats", "spring"] {
        for (name, view, volumes) in views(name) {
            let (exact, unshadowed) = (view.exact(), view.unshadowed());
            let shadows = rel_rmse(&unshadowed, &exact);
            assert!(shadows > 0.01, "{name}: shadows change {shadows:.1e}: nothing is tested");
            let error = |pixels: Pixels| shadow_err(&pixels, &exact, &unshadowed);
            let brute = error(view.marched(400));
            let between = error(hybrid(&view, &volumes, 1, 400, 0));
            let by_tile = error(hybrid(&view, &volumes, 8, 400, 0));
            // the sun stands so low behind the slats that 30 steps miss most of them: unrefined steps then count right on
            // average, and refined ones only what they hit
            let few = if name == "slats, sun" { 400 } else { 30 };
            let plain = error(hybrid(&view, &volumes, 1, few, 0));
            let refined = error(hybrid(&view, &volumes, 1, few, 6));
            println!(
                "{name}: brute force 400 {brute:.2e}, hybrid 400 {between:.2e} (by tile {by_tile:.2e}), \
                 hybrid {few} {plain:.2e}, refined {refined:.2e}"
            );
            assert!(between < brute, "{name}: {between:.2e} is no less than {brute:.2e}");
            // behind a convex body there is no boundary between the faces, and nothing to refine
            assert!(refined < plain.max(1e-5), "{name}: {refined:.2e} is no less than {plain:.2e}");
        }
    }
}
