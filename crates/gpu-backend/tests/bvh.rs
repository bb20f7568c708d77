//! Shadow rays on the GPU against those on the CPU.
//!
//! Both work in `f32`, each with its own rounding, and may differ only where rounding decides: for every ray on which they
//! do, no triangle is hit for certain, and one is hit or missed by a hair. What is certain is asked in `f64`.

#![expect(clippy::unwrap_used, reason = "test code")]

mod common;

use std::time::Duration;

use common::{core_gpu, gpu};
use glam::{DVec3, Vec3};
use gpu_backend::{GpuBvh, GpuContext, OcclusionProbe, PrepareError, ShadowRay};
use scene::{Bvh, Mesh, Scene, Triangle, WideBvh};

/// The same numbers in every run, in [0, 1).
struct Random(u64);

impl Random {
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    fn direction(&mut self) -> Vec3 {
        (self.point() - 0.5).try_normalize().unwrap_or(Vec3::X)
    }
}

/// Rays that start in the scene's bounds: to points, to one light, in random directions without end, and with
/// components that are zero.
fn rays(scene: &Scene, count: usize) -> Vec<ShadowRay> {
    let bounds = scene.bounds();
    let (low, size) =
        if bounds.is_empty() { (Vec3::ZERO, Vec3::ONE) } else { (bounds.min, bounds.max - bounds.min) };
    // a flat scene is looked at from outside, too
    let size = size.max(Vec3::splat(0.1 * size.length()));
    let mut random = Random(count as u64);
    let light = low + size * Vec3::new(0.4, 0.7, 0.55);
    let mut ray = |i: usize| {
        let from = low + size * random.point();
        let (mut direction, mut far) = match i % 4 {
            0 => (low + size * random.point() - from, 1.0),
            1 => (light - from, 1.0),
            2 => (random.direction(), 1e30),
            _ => (random.direction(), size.length()),
        };
        if i % 8 >= 6 {
            direction[i % 3] = 0.0;
        }
        if i % 16 == 15 {
            direction[(i + 1) % 3] = 0.0;
            far = 1e30;
        }
        ShadowRay { origin: from.into(), direction: direction.into(), far }
    };
    (0..count).map(&mut ray).collect()
}

/// Whether the segment hits the triangle, in `f64`.
fn hits(corners: &[DVec3; 3], from: DVec3, to: DVec3) -> bool {
    let (e1, e2, direction) = (corners[1] - corners[0], corners[2] - corners[0], to - from);
    let p = direction.cross(e2);
    let (det, from) = (e1.dot(p), from - corners[0]);
    let q = from.cross(e1);
    let (u, v, t) = (from.dot(p) / det, direction.dot(q) / det, e2.dot(q) / det);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < 1.0
}

/// Whether rounding decides about the ray: no triangle is hit however the ray's ends are moved by 10⁻⁵ of its length,
/// and one is hit by some of these rays.
fn grazes(scene: &Scene, triangles: &[Triangle], ray: &ShadowRay) -> bool {
    let [from, direction] = [ray.origin, ray.direction].map(|v| Vec3::from(v).as_dvec3());
    let end = (4.0 * f64::from(scene.bounds().diagonal()) / direction.length()).min(f64::from(ray.far));
    let to = from + end * direction;
    let mut random = Random(7);
    let mut moved = vec![(from, to)];
    for i in 0..96 {
        let by = 1e-5 * (to - from).length() * [0.03, 0.3, 1.0][i % 3];
        let (a, b) = (random.direction().as_dvec3(), random.direction().as_dvec3());
        moved.push((from + by * a, to + by * b));
    }
    let mut by_a_hair = false;
    for triangle in triangles {
        let corners = triangle.corners.map(|corner| corner.as_dvec3());
        let count = moved.iter().filter(|(from, to)| hits(&corners, *from, *to)).count();
        if count == moved.len() {
            return false;
        }
        by_a_hair |= count > 0;
    }
    by_a_hair
}

/// Traces random rays on both sides; returns the share of blocked ones.
#[expect(clippy::print_stdout, reason = "how close it was is worth a line")]
fn compare(gpu: &GpuContext, what: &str, scene: &Scene, count: usize) -> f64 {
    let rays = rays(scene, count);
    let (bvh, wide) = (Bvh::build(scene).unwrap(), WideBvh::build(scene).unwrap());
    let on_gpu = GpuBvh::upload(&gpu.device, &wide).unwrap();
    let traced = OcclusionProbe::new(gpu).unwrap().trace(&on_gpu, &rays).unwrap();
    assert_eq!(traced.blocked.len(), count);
    let (mut blocked, mut differ, mut not_twin) = (0, 0, 0);
    for (ray, &got) in rays.iter().zip(&traced.blocked) {
        let [from, direction] = [ray.origin, ray.direction].map(Vec3::from);
        let expected = bvh.blocked(from, direction, ray.far);
        blocked += usize::from(got);
        not_twin += usize::from(got != wide.blocked(from, direction, ray.far));
        if got != expected {
            differ += 1;
            assert!(
                grazes(scene, bvh.triangles(), ray),
                "{what}: {got} on the GPU, {expected} on the CPU: {ray:?}"
            );
        }
    }
    let share = blocked as f64 / count.max(1) as f64;
    println!(
        "{what}: {differ} of {count} rays differ, {not_twin} from the twin; {:.1} % blocked",
        100.0 * share
    );
    assert!(differ <= count.div_ceil(100_000), "{what}: {differ} of {count} rays differ");
    share
}

fn mesh(corners: Vec<Vec3>) -> Scene {
    let triangles = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Scene { meshes: vec![Mesh::new(corners, triangles, 0).unwrap()], ..Scene::default() }
}

/// The scene with its diagonal made `size` metres long.
fn scaled(scene: &Scene, size: f32) -> Scene {
    let scale = size / scene.bounds().diagonal();
    let smaller = |mesh: &Mesh| {
        let positions = mesh.positions().iter().map(|&p| scale * p).collect();
        Mesh::new(positions, mesh.triangles().to_vec(), mesh.material).unwrap()
    };
    Scene { meshes: scene.meshes.iter().map(smaller).collect(), ..Scene::default() }
}

#[test]
fn what_rounding_decides_is_told_from_what_it_does_not() {
    let scene = mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y]);
    let bvh = Bvh::build(&scene).unwrap();
    let down = |x: f32, y: f32, far: f32| {
        let ray = ShadowRay { origin: [x, y, 1.0], direction: [0.0, 0.0, -1.0], far };
        grazes(&scene, bvh.triangles(), &ray)
    };
    assert!(!down(0.25, 0.25, 2.0) && !down(0.25, -0.25, 2.0) && !down(0.25, 0.25, 0.9));
    assert!(down(0.25, 1e-7, 2.0) && down(0.25, -1e-7, 2.0) && down(0.25, 0.25, 1.0) && down(0.5, 0.5, 1e30));
}

#[test]
fn a_hall() {
    let Some(gpu) = gpu() else { return };
    let hall = scene::procedural::generate("hall").unwrap();
    // more than one dispatch takes
    let share = compare(&gpu, "hall", &hall, 1_100_000);
    assert!((0.2..0.95).contains(&share), "{share}: the test sees only one outcome");
}

#[test]
fn scenes_of_any_size() {
    let Some(gpu) = gpu() else { return };
    let hall = scene::procedural::generate("hall").unwrap();
    for size in [1e-3, 1e5] {
        let share = compare(&gpu, &format!("hall of {size} m"), &scaled(&hall, size), 200_000);
        assert!((0.2..0.95).contains(&share), "{share}: the test sees only one outcome");
    }
}

#[test]
fn sponza_where_it_is_there() {
    let Some(gpu) = gpu() else { return };
    let Some(folder) = std::env::var_os("AIRLIGHT_SCENES") else { return };
    let file = std::path::Path::new(&folder).join("sponza_dabrovic_66k.glb");
    if file.exists() {
        compare(&gpu, "sponza", &scene::import::load_gltf(&file).unwrap(), 1_000_000);
    }
}

#[test]
fn few_triangles() {
    let Some(gpu) = gpu() else { return };
    let one = [Vec3::new(-1.0, 0.2, -1.0), Vec3::new(1.5, 0.1, 0.3), Vec3::new(-0.4, 0.8, 1.0)];
    assert_eq!(compare(&gpu, "no triangle", &Scene::default(), 1000), 0.0);
    assert!(compare(&gpu, "one triangle", &mesh(one.to_vec()), 50_000) > 0.05);
    assert!(compare(&gpu, "1000 times one triangle", &mesh(one.repeat(1000)), 50_000) > 0.05);
    let [a, b, c] = one;
    let flat = [a, a, a, a, b, b, a, b, a.midpoint(b), c, b, c];
    assert_eq!(compare(&gpu, "triangles without area", &mesh(flat.to_vec()), 50_000), 0.0);
    let mixed = [one.as_slice(), &flat].concat();
    assert!(compare(&gpu, "triangles with and without area", &mesh(mixed), 50_000) > 0.05);
}

#[test]
fn nothing_takes_no_time_and_nothing_else_is_no_number() {
    let Some(gpu) = gpu() else { return };
    let probe = OcclusionProbe::new(&gpu).unwrap();
    let bvh = GpuBvh::upload(&gpu.device, &WideBvh::default()).unwrap();
    let nothing = probe.trace(&bvh, &[]).unwrap();
    assert!(nothing.blocked.is_empty() && nothing.gpu_time.is_none());
    let ray = ShadowRay { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], far: f32::INFINITY };
    let traced = probe.trace(&bvh, &[ray]).unwrap();
    assert_eq!(traced.blocked, [false]);
    assert!(traced.wall_time > Duration::ZERO);
    let has_clock = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
    assert!(has_clock || traced.gpu_time.is_none());
}

#[test]
fn directions_without_length_or_end() {
    let Some(gpu) = gpu() else { return };
    let wall = [Vec3::new(-9.0, -9.0, 2.0), Vec3::new(9.0, -9.0, 2.0), Vec3::new(0.0, 20.0, 2.0)];
    let bvh = GpuBvh::upload(&gpu.device, &WideBvh::build(&mesh(wall.to_vec())).unwrap()).unwrap();
    let ray = |z: f32, far: f32| ShadowRay { origin: [0.1, 0.2, 0.0], direction: [0.0, 0.0, z], far };
    let rays =
        [ray(0.0, 1.0), ray(1.0, f32::INFINITY), ray(-1.0, f32::INFINITY), ray(1.0, 1.9), ray(1.0, 2.1)];
    let traced = OcclusionProbe::new(&gpu).unwrap().trace(&bvh, &rays).unwrap();
    assert_eq!(traced.blocked, [false, true, false, false, true]);
}

#[test]
fn more_than_the_device_takes_is_refused() {
    let Some(gpu) = core_gpu() else { return };
    // 48 bytes a triangle, 128 MiB at most
    let strip = (0..2_850_000_u32).flat_map(|i| {
        let corner = Vec3::new((i % 1700) as f32, (i / 1700) as f32, 0.0);
        [corner, corner + 0.5 * Vec3::X, corner + 0.5 * Vec3::Y]
    });
    let wide = WideBvh::build(&mesh(strip.collect())).unwrap();
    let error = GpuBvh::upload(&gpu.device, &wide).unwrap_err();
    assert!(matches!(error, PrepareError::TooLarge { needed: 136_800_000, .. }), "{error}");
}
