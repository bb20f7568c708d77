//! What the benchmarks run on: the reference cases of the airlight integral, and fixed rays through generated scenes.
#![expect(
    clippy::missing_panics_doc,
    clippy::unwrap_used,
    reason = "a benchmark whose input is broken must stop"
)]

use glam::{DVec2, Vec3};
use media_math::{Foot, HomogeneousMedium, PhaseFunction, Real};
use scene::{Bvh, Camera, DRay, Light, Medium, procedural};
use serde::Deserialize;

/// The same cases as the tests': hard ones and ordinary ones, a category each.
const CASES: &str = include_str!("../../tests/data/airlight_public.json");

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    category: String,
    phase: PhaseCase,
    f32: Block,
}

#[derive(Deserialize)]
struct PhaseCase {
    g: Option<f64>,
}

/// Inputs that are exact in f32, so that both precisions evaluate the same problem.
#[derive(Deserialize)]
struct Block {
    kappa_s: f64,
    kappa_t: f64,
    intensity: f64,
    x_foot: f64,
    h: f64,
    x0: f64,
    x1: f64,
    g: Option<f64>,
}

/// One evaluation of the airlight integral.
#[derive(Debug, Clone)]
pub struct Problem<T> {
    /// What is hard about it.
    pub category: String,
    /// σ_s and σ_t.
    pub medium: HomogeneousMedium<T>,
    /// Phase function.
    pub phase: PhaseFunction<T>,
    /// W/sr.
    pub intensity: T,
    /// The light.
    pub foot: Foot<T>,
    /// Near end in m.
    pub x0: T,
    /// Far end in m.
    pub x1: T,
}

impl<T: Real> Problem<T> {
    /// Whether the default form takes it for a short interval, which needs no logarithm and no angle.
    pub fn is_short(&self) -> bool {
        let wide = |v: T| v.widen();
        let (x0, x1, h) = (wide(self.x0), wide(self.x1), wide(self.foot.h));
        let (a0, a1) = (x0 - wide(self.foot.x_foot), x1 - wide(self.foot.x_foot));
        let r = |a: f64| if a < 0.0 { h * h / (a.hypot(h) - a) } else { a.hypot(h) + a };
        let (r0, r1) = (r(a0), r(a1));
        let dr = (x1 - x0) * (r0 + r1) / (a0.hypot(h) + a1.hypot(h));
        let q = dr / (h * h + r0 * r1);
        wide(self.medium.sigma_t()) * dr <= 1.0 && q * r0 <= 0.5 && q * h <= 1.0
    }
}

/// All cases whose result is not trivially 0.
pub fn problems<T: Real>() -> Vec<Problem<T>> {
    let file: File = serde_json::from_str(CASES).unwrap();
    let problem = |case: &Case| {
        let block = &case.f32;
        let g = block.g.or(case.phase.g).unwrap_or(0.0);
        Problem {
            category: case.category.clone(),
            medium: HomogeneousMedium::with_extinction(T::lit(block.kappa_s), T::lit(block.kappa_t)).unwrap(),
            phase: PhaseFunction::henyey_greenstein(T::lit(g)).unwrap(),
            intensity: T::lit(block.intensity),
            foot: Foot { x_foot: T::lit(block.x_foot), h: T::lit(block.h) },
            x0: T::lit(block.x0),
            x1: T::lit(block.x1),
        }
    };
    file.cases.iter().filter(|case| case.f32.x1 > case.f32.x0).map(problem).collect()
}

/// Those of [`problems`] with an isotropic phase function, which is all that tables and closed forms take.
pub fn isotropic_problems<T: Real>() -> Vec<Problem<T>> {
    let mut problems = problems::<T>();
    problems.retain(|problem| problem.phase.is_isotropic());
    problems
}

/// A generated scene, ready to be asked.
#[derive(Debug)]
pub struct Stage {
    /// Its triangles.
    pub scene: scene::Scene,
    /// The hierarchy over them.
    pub bvh: Bvh,
    /// Where it is seen from.
    pub camera: Camera,
    /// What it is filled with.
    pub medium: Medium,
    /// What lights it.
    pub lights: Vec<Light>,
}

impl Stage {
    /// The generated scene called `name`.
    pub fn new(name: &str) -> Self {
        let scene = procedural::generate(name).unwrap();
        Self {
            bvh: Bvh::build(&scene).unwrap(),
            camera: scene.cameras[0].clone(),
            medium: scene.medium.clone().unwrap(),
            lights: scene.lights.clone(),
            scene,
        }
    }

    /// Where its first light is.
    pub fn lamp(&self) -> Vec3 {
        match &self.lights[0] {
            Light::Point(light) => light.position,
            Light::Spot(light) => light.position,
            Light::Directional(light) => -1e3 * light.direction,
        }
    }

    /// `count` view rays through random places of the picture, the same in every run.
    pub fn rays(&self, count: usize) -> Vec<DRay> {
        let mut random = Random::default();
        (0..count).map(|_| self.camera.ray(DVec2::new(random.next(), random.next()), (1, 1))).collect()
    }

    /// A point on each of `count` random view rays, before the surface that it meets; the same in every run.
    pub fn points(&self, count: usize) -> Vec<Vec3> {
        let mut random = Random::default();
        let reach = f64::from(self.scene.bounds().diagonal());
        let rays = self.rays(count);
        rays.iter()
            .map(|ray| {
                let end = self.bvh.closest_hit(ray, reach).map_or(reach, |hit| hit.distance);
                ray.at(end * random.next()).as_vec3()
            })
            .collect()
    }
}

/// Numbers in [0, 1) from a linear congruential generator (Knuth's MMIX constants).
#[derive(Debug, Default)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
