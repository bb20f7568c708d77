//! A ray takes steps where shadows may be, and nowhere else.
#![expect(clippy::unwrap_used, reason = "test code")]

use glam::{DVec3, Vec3};
use hybrid_march::{Adjacency, BruteForce, Hybrid, Marched, Occluders, ShadowVolume};
use scene::{Aabb, AirlightModel, DRay, Interval, Light, LightId, Medium, PointLight, Visibility};

/// A square of 2 m at y = 2, below a lamp at (0, 4, 0).
struct Square;

impl Visibility for Square {
    fn visibility(&self, point: Vec3, _light: LightId) -> f32 {
        let through = point * 2.0 / (4.0 - point.y);
        if point.y < 2.0 && through.x.abs() < 1.0 && through.z.abs() < 1.0 { 0.0 } else { 1.0 }
    }
}

/// A ray along +X at a height of 0 m, beside the lamp by so much.
fn marched(z: f64, occluders: Option<Occluders<'_>>) -> (Marched, Marched) {
    let corner = |x, z| Vec3::new(x, 2.0, z);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Adjacency::new([[a, b, c], [a, c, d]]).unwrap();
    let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(10.0)).unwrap())];
    let medium = Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap();
    let ray = DRay { origin: DVec3::new(-9.0, 0.0, z), direction: DVec3::X };
    let faces = ShadowVolume::new(&mesh, &lights[0]).faces(&ray, Interval::new(0.0, 20.0));
    let (samples, model) = (40, AirlightModel::Sun);
    let hybrid = Hybrid::new(&medium, &lights, occluders, samples, 0, model).unwrap();
    let march = BruteForce { medium: &medium, lights: &lights, occluders, samples, model };
    (hybrid.airlight(&ray, 20.0, &[faces]), march.airlight(&ray, 20.0))
}

fn square() -> Occluders<'static> {
    let bounds = Aabb { min: Vec3::new(-1.0, 2.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
    Occluders { visibility: &Square, bounds }
}

#[test]
fn a_ray_outside_every_shadow_volume_takes_no_step() {
    let (outside, _) = marched(2.5, Some(square()));
    // it is asked at its ends and in its middle alone, and gets the light of the whole ray
    assert_eq!((outside.samples, outside.rays), (0, 3));
    let (open, _) = marched(2.5, None);
    assert!((outside.airlight - open.airlight).abs().max_element() < 1e-6 * open.airlight.x);
    let (inside, _) = marched(0.0, Some(square()));
    assert_eq!(inside.samples, 40);
    assert!(inside.airlight.x < 0.9 * marched(0.0, None).0.airlight.x);
}

#[test]
fn without_an_occluder_nothing_is_asked() {
    for z in [0.0, 2.5] {
        let (hybrid, march) = marched(z, None);
        assert_eq!((hybrid.samples, hybrid.rays), (0, 0));
        assert_eq!((march.samples, march.rays), (0, 0));
    }
}

#[test]
fn a_march_takes_no_step_where_the_casters_shadow_nothing() {
    // the ray is above the lamp's shadow: no step of any
    let (_, beside) = marched(30.0, Some(square()));
    assert_eq!(beside.samples, 0);
    assert_eq!(marched(0.0, Some(square())).1.samples, 40);
}
