//! Sets of cameras that look at one scene: scattered as people are, or turned from each other by a fixed share.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use scene::{Aabb, Bvh, Camera, DRay};

use crate::view_rays::ViewRays;

/// Everyone keeps so far from what is ahead; units: m, and less in a scene smaller than ten metres.
const CLEAR: f64 = 1.0;

/// Steps between viewers, as shares of the scene's longest side.
const STEP: [f64; 2] = [0.02, 0.15];

/// The longest of them: people gather in one place, however large the scene; units: m.
const LONGEST_STEP: f64 = 25.0;

/// Places tried for a viewer before one of those taken is taken twice.
const TRIES: usize = 200;

/// The real root above 1 of x⁵ = x + 1: its powers spread points evenly over four dimensions (Roberts 2018).
const ROOT: f64 = 1.167_303_978_261_418_7;

/// A camera, and where its rays end.
#[derive(Debug, Clone)]
pub(crate) struct Viewer {
    pub(crate) camera: Camera,
    pub(crate) rays: ViewRays,
}

impl Viewer {
    /// A viewer of a picture of `size` (width, height).
    pub(crate) fn new(camera: Camera, bvh: &Bvh, size: (u32, u32)) -> Self {
        let rays = ViewRays::trace(&camera, bvh, size);
        Self { camera, rays }
    }
}

/// `count` cameras that stand where one can walk from those given, which come first.
///
/// Each walks from one that is there: level, at most as far as it is free to go, inside the scene's box. So none is inside of what is
/// closed. Headings are spread evenly, with the pitch of the first camera and a metre free ahead. The same cameras on every
/// run, and those of fewer viewers are among those of more.
pub(crate) fn scattered(seeds: &[Camera], bvh: &Bvh, count: usize) -> Vec<Camera> {
    let Some(first) = seeds.first() else { return Vec::new() };
    let mut cameras: Vec<Camera> = seeds.iter().take(count).cloned().collect();
    let bounds = bvh.bounds().union(&Aabb::around(seeds.iter().map(|camera| camera.position)));
    let longest = f64::from((bounds.max - bounds.min).max_element());
    let clear = CLEAR.min(0.1 * longest);
    let mut tried = 0;
    while cameras.len() < count {
        let found = (0..TRIES).find_map(|_| {
            tried += 1;
            let [from, way, step, heading] = spread(tried);
            let from = &cameras[(from * cameras.len() as f64) as usize % cameras.len()];
            let step = longest * (STEP[0] + (STEP[1] - STEP[0]) * step);
            let origin = from.position.as_dvec3();
            let eye = origin + walk(bvh, origin, level(way), step.min(LONGEST_STEP), clear)? * level(way);
            let forward = ahead(first, heading);
            let free =
                bounds.contains(eye) && !bvh.occluded(&DRay { origin: eye, direction: forward }, 0.0, clear);
            if free { looking(eye, forward, first.fov_y) } else { None }
        });
        // a scene without room for more: another heading in the same place
        let heading = spread(tried)[3];
        let next = found.or_else(|| looking(first.position.as_dvec3(), ahead(first, heading), first.fov_y));
        cameras.push(next.unwrap_or_else(|| first.clone()));
    }
    cameras
}

/// The point of index `i` of a sequence that fills the unit cube evenly.
fn spread(i: usize) -> [f64; 4] {
    [1, 2, 3, 4].map(|power| (i as f64 / ROOT.powi(power)).fract())
}

/// The level direction after a share of a full turn.
fn level(share: f64) -> DVec3 {
    DVec3::new((TAU * share).cos(), 0.0, (TAU * share).sin())
}

/// The direction of a camera's pitch in another heading.
fn ahead(camera: &Camera, heading: f64) -> DVec3 {
    let rise = f64::from(camera.forward.y.clamp(-0.5, 0.5));
    (1.0 - rise * rise).sqrt() * level(heading) + rise * DVec3::Y
}

/// How far one can walk of `step`; `None` for a way that is hardly one.
fn walk(bvh: &Bvh, origin: DVec3, direction: DVec3, step: f64, clear: f64) -> Option<f64> {
    let hit = bvh.closest_hit(&DRay { origin, direction }, step + clear);
    let free = hit.map_or(step, |hit| step.min(hit.distance - clear));
    (free > 0.5 * clear).then_some(free)
}

fn looking(eye: DVec3, forward: DVec3, fov_y: f32) -> Option<Camera> {
    Camera::look_at(eye.as_vec3(), (eye + forward).as_vec3(), Vec3::Y, fov_y).ok()
}

/// `count` times the same camera, each turned about its up axis from the one before, so that neighbours share `overlap` of the angle
/// that a picture of `size` spans from left to right.
pub(crate) fn turned(camera: &Camera, size: (u32, u32), overlap: f64, count: usize) -> Vec<Camera> {
    let half = (0.5 * f64::from(camera.fov_y)).tan() * f64::from(size.0) / f64::from(size.1);
    let turn = (1.0 - overlap) * 2.0 * half.atan();
    let (right, forward) = (camera.right.as_dvec3(), camera.forward.as_dvec3());
    (0..count)
        .map(|i| {
            let (sin, cos) = (turn * i as f64).sin_cos();
            Camera {
                right: (cos * right - sin * forward).as_vec3(),
                forward: (cos * forward + sin * right).as_vec3(),
                ..camera.clone()
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::procedural;

    #[test]
    fn viewers_stand_in_the_open() {
        let scene = procedural::generate("hall").unwrap();
        let bvh = Bvh::build(&scene).unwrap();
        let cameras = scattered(&scene.cameras, &bvh, 40);
        assert_eq!(cameras.len(), 40);
        assert_eq!(scattered(&scene.cameras, &bvh, 7), cameras[..7]);
        assert_eq!(cameras[0], scene.cameras[0]);
        for (i, camera) in cameras.iter().enumerate() {
            assert!((camera.position.y - cameras[0].position.y).abs() < 1e-4);
            assert!(bvh.bounds().contains(camera.position.as_dvec3()));
            let ray = DRay { origin: camera.position.as_dvec3(), direction: camera.forward.as_dvec3() };
            assert!(i == 0 || !bvh.occluded(&ray, 0.0, 0.99), "{i}");
        }
        let apart = |i: usize| cameras[..i].iter().all(|other| other.position != cameras[i].position);
        assert!((1..40).all(apart), "no place is taken twice");
    }

    #[test]
    fn a_scene_without_room_still_has_viewers() {
        let scene = procedural::generate("empty").unwrap();
        let bvh = Bvh::build(&scene).unwrap();
        assert_eq!(scattered(&scene.cameras, &bvh, 5).len(), 5);
        assert!(scattered(&[], &bvh, 5).is_empty());
    }

    #[test]
    fn neighbours_share_what_they_are_to() {
        let camera = Camera::look_at(Vec3::ZERO, Vec3::new(1.0, -0.3, 2.0), Vec3::Y, 0.8).unwrap();
        let size = (200, 100);
        let wide = 2.0 * (0.4_f64.tan() * 2.0).atan();
        for overlap in [0.1, 0.5, 1.0] {
            let cameras = turned(&camera, size, overlap, 3);
            for pair in cameras.windows(2) {
                let angle = f64::from(pair[0].forward.dot(pair[1].forward)).min(1.0).acos();
                assert!((angle - (1.0 - overlap) * wide).abs() < 1e-3, "{overlap}: {angle}");
                assert!(pair[1].right.cross(pair[1].forward).dot(pair[1].up) > 0.999);
            }
        }
    }
}
