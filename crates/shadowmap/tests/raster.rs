//! The rasteriser against rays cast through the texel centres.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod common;

use common::Random;
use glam::{DVec3, Vec3};
use scene::{Aabb, Bvh, DirectionalLight, Light, PointLight, Scene, SpotLight, procedural};
use shadowmap::{DepthMap, ProjectionKind};

/// Lights of every kind that see much of the scene, some of them within it.
fn lights(bounds: &Aabb, random: &mut Random) -> Vec<Light> {
    let (center, arm) = (bounds.center(), 0.5 * (bounds.max - bounds.min));
    let place = |random: &mut Random, reach: f64| center + arm * random.vector(reach).as_vec3();
    let one = Vec3::ONE;
    let mut lights = Vec::new();
    for _ in 0..2 {
        lights.push(Light::Point(PointLight::new(place(random, 0.7), one).unwrap()));
        let (from, to) = (place(random, 1.5), place(random, 0.3));
        lights.push(Light::Spot(SpotLight::new(from, to - from, 0.2, 0.9, one).unwrap()));
        lights.push(Light::Directional(DirectionalLight::new(random.direction().as_vec3(), one).unwrap()));
    }
    lights
}

fn compare(name: &str, scene: &Scene, light: &Light, side: u32) -> (usize, usize, f64) {
    let bvh = Bvh::build(scene).unwrap();
    let map = DepthMap::of_light(light, scene, side).unwrap();
    let (mut texels, mut differing, mut worst) = (0, 0, 0.0_f64);
    for (index, face) in map.projection().faces().iter().enumerate() {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let ray = map.projection().texel_ray(index, x, y, map.size());
            let cosine = ray.direction.dot(face.forward);
            let cast =
                bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance * cosine);
            let drawn = f64::from(map.depth(index, x, y));
            texels += 1;
            let error = if cast == drawn { 0.0 } else { (cast - drawn).abs() / cast.min(drawn) };
            if error < 1e-5 {
                worst = worst.max(error);
            } else {
                differing += 1;
            }
        }
    }
    println!(
        "{name}, {:?}: {differing} of {texels} texels differ, others by {worst:e}",
        map.projection().kind()
    );
    (texels, differing, worst)
}

#[test]
fn texels_are_what_rays_through_their_centres_hit() {
    let mut random = Random::new(7);
    let (mut texels, mut differing) = (0, 0);
    let mut kinds = Vec::new();
    for name in ["sphere-plane", "hall", "slats", "canopy", "fence", "lampshade"] {
        let scene = procedural::generate(name).unwrap();
        let mut lights = lights(&scene.bounds(), &mut random);
        lights.extend(scene.lights.iter().cloned());
        for light in &lights {
            let (all, wrong, worst) = compare(name, &scene, light, 48);
            assert!(worst < 1e-6, "{worst:e}");
            texels += all;
            differing += wrong;
            kinds.push(std::mem::discriminant(light));
        }
    }
    // a centre on an edge, to rounding, may go either way
    println!("{differing} of {texels} differ");
    assert!(differing * 20_000 <= texels, "{differing} of {texels}");
}

#[test]
fn a_scene_without_triangles_needs_no_map() {
    let empty = procedural::generate("empty").unwrap();
    let maps = shadowmap::draw_maps(&empty.lights, &empty, 64).unwrap();
    assert!(maps.iter().all(Option::is_none) && maps.len() == empty.lights.len());
    let sphere = procedural::generate("sphere").unwrap();
    let maps = shadowmap::draw_maps(&sphere.lights, &sphere, 16).unwrap();
    assert!(maps.iter().all(|map| map.as_ref().unwrap().projection().kind() == ProjectionKind::Cube));
    assert!(shadowmap::draw_maps(&sphere.lights, &sphere, 0).is_err());
}

/// A light a tenth of a millimetre in front of a wall sees the wall.
#[test]
fn a_light_on_a_wall() {
    let p = |x: f32, y: f32| Vec3::new(x, y, -1e-4);
    let wall = [[p(-9.0, -9.0), p(9.0, -9.0), p(0.0, 9.0)]];
    let projection = shadowmap::Projection::cube(DVec3::ZERO).unwrap();
    let map = DepthMap::draw(projection, (16, 16), &wall).unwrap();
    assert!(map.face(5).iter().all(|&depth| depth == 1e-4));
    assert!(map.face(4).iter().all(|depth| depth.is_infinite()));
    // beside it: the wall falls away from the light at the slope of the texel's ray
    let slope = 15.0 / 16.0;
    let depth = map.projection().faces()[0].project_depth(&map, slope);
    assert!((depth / (1e-4 / slope) - 1.0).abs() < 1e-5, "{depth}");
}

trait Beside {
    fn project_depth(&self, map: &DepthMap, slope: f64) -> f64;
}

impl Beside for shadowmap::Face {
    /// Depth of the texel of this face whose ray goes by `slope` towards −Z per metre.
    fn project_depth(&self, map: &DepthMap, slope: f64) -> f64 {
        let at = map.locate(self.origin + self.forward - slope * DVec3::Z).unwrap();
        f64::from(map.depth(at.face, at.u as u32, at.v as u32))
    }
}
