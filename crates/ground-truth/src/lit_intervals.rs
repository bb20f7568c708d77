//! The exact lit pieces of a view ray: the shadows of all triangles, united and removed.

use glam::DVec3;
use scene::{Bvh, DRay, Interval, Light, LightId, LitIntervals};

use crate::ray_plane::RayPlane;
use crate::shadow_interval::shadow_of;

/// Exact shadows of a scene's triangles; no map, no sampling.
#[derive(Debug, Clone, Copy)]
pub struct ExactShadows<'a> {
    bvh: &'a Bvh,
    lights: &'a [Light],
}

impl<'a> ExactShadows<'a> {
    /// Shadows that the triangles of `bvh` cast in the light of `lights`.
    pub fn new(bvh: &'a Bvh, lights: &'a [Light]) -> Self {
        Self { bvh, lights }
    }
}

impl ExactShadows<'_> {
    /// How many triangles are looked at for the shadows of `light` on `ray` within `span`: what the query costs.
    pub fn candidates(&self, ray: &DRay, span: Interval, light: LightId) -> usize {
        let plane = RayPlane::new(ray, &self.lights[light.0]);
        let mut count = 0;
        if !span.is_empty() {
            self.bvh.for_each_in(&plane.region(span, self.bvh), |_| count += 1);
        }
        count
    }
}

impl LitIntervals for ExactShadows<'_> {
    fn lit_intervals(&self, ray: &DRay, span: Interval, light: LightId, out: &mut Vec<Interval>) {
        out.clear();
        if span.is_empty() {
            return;
        }
        let plane = RayPlane::new(ray, &self.lights[light.0]);
        let mut shadows: Vec<Interval> = Vec::new();
        self.bvh.for_each_in(&plane.region(span, self.bvh), |triangle| {
            let corners: [DVec3; 3] = triangle.corners.map(|corner| corner.as_dvec3());
            let shadow = plane
                .cut(corners)
                .and_then(|ends| shadow_of(&plane.source, ends))
                .map(|shadow| shadow.intersect(span));
            if let Some(shadow) = shadow
                && !shadow.is_empty()
            {
                shadows.push(shadow);
            }
        });
        complement(span, &mut shadows, out);
    }
}

/// Lit pieces shorter than this share of their distance are rounding: the gap between the shadow of the surface that a
/// ray ends on, and the end.
const LEAST_PIECE: f64 = 1e-13;

/// Writes what of `span` no interval covers to `lit`; sorts `shadows`.
fn complement(span: Interval, shadows: &mut [Interval], lit: &mut Vec<Interval>) {
    shadows.sort_unstable_by(|a, b| a.start.total_cmp(&b.start));
    let mut from = span.start;
    let mut keep = |piece: Interval| {
        // measured at the near end, since the far one may be infinite
        if piece.length() > LEAST_PIECE * piece.start.abs() {
            lit.push(piece);
        }
    };
    for shadow in shadows.iter() {
        keep(Interval::new(from, shadow.start));
        from = from.max(shadow.end);
    }
    keep(Interval::new(from, span.end));
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scene::{DirectionalLight, Mesh, PointLight, Scene};

    fn lit(shadows: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let mut shadows: Vec<Interval> = shadows.iter().map(|&(a, b)| Interval::new(a, b)).collect();
        let mut out = Vec::new();
        complement(Interval::new(1.0, 9.0), &mut shadows, &mut out);
        out.iter().map(|i| (i.start, i.end)).collect()
    }

    #[test]
    fn complements_by_hand() {
        assert_eq!(lit(&[]), [(1.0, 9.0)]);
        assert_eq!(lit(&[(1.0, 9.0)]), []);
        assert_eq!(lit(&[(5.0, 6.0), (2.0, 3.0), (2.5, 4.0)]), [(1.0, 2.0), (4.0, 5.0), (6.0, 9.0)]);
        assert_eq!(lit(&[(1.0, 2.0), (2.0, 3.0), (8.0, 9.0)]), [(3.0, 8.0)]);
    }

    #[test]
    fn the_last_piece_may_be_infinite_and_a_rounding_is_none() {
        let mut out = Vec::new();
        let all = Interval::new(0.0, f64::INFINITY);
        complement(all, &mut [], &mut out);
        assert_eq!(out, [all]);
        out.clear();
        complement(Interval::new(0.0, 5.0 + 1e-15), &mut [Interval::new(0.0, 5.0)], &mut out);
        assert!(out.is_empty());
    }

    /// Triangles in the unit cube at random, and whether a point sees the light by a shadow ray.
    fn soup() -> Scene {
        let mut state = 7_u32;
        let mut random = move || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut positions = Vec::new();
        for _ in 0..200 {
            let c = Vec3::new(random(), random(), random());
            positions.extend([0; 3].map(|_| c + 0.25 * (Vec3::new(random(), random(), random()) - 0.5)));
        }
        let triangles = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Scene { meshes: vec![Mesh::new(positions, triangles, 0).unwrap()], ..Scene::default() }
    }

    #[test]
    fn equals_shadow_rays_everywhere_but_at_the_boundaries() {
        let bvh = Bvh::build(&soup()).unwrap();
        let lights = [
            Light::Point(PointLight::new(Vec3::new(0.3, 1.6, 0.8), Vec3::ONE).unwrap()),
            Light::Point(PointLight::new(Vec3::new(0.5, 0.5, 0.5), Vec3::ONE).unwrap()),
            Light::Directional(DirectionalLight::new(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap()),
        ];
        let shadows = ExactShadows::new(&bvh, &lights);
        let mut lit = Vec::new();
        let (mut tested, mut in_light) = (0, 0);
        for i in 0..300 {
            let a = f64::from(i) * 0.61;
            let origin = DVec3::new(0.5 + 1.5 * a.cos(), 0.5 + 0.8 * (1.7 * a).sin(), 0.5 + 1.5 * a.sin());
            let target = DVec3::new(0.5 + 0.4 * (2.3 * a).sin(), 0.5, 0.5 + 0.4 * (3.1 * a).cos());
            let ray = DRay { origin, direction: (target - origin).normalize() };
            for (id, light) in lights.iter().enumerate() {
                let end = if i % 5 == 0 { f64::INFINITY } else { 3.0 };
                shadows.lit_intervals(&ray, Interval::new(0.2, end), LightId(id), &mut lit);
                assert!(lit.windows(2).all(|w| w[0].end < w[1].start) && lit.iter().all(|i| !i.is_empty()));
                for k in 0..40 {
                    let x = 0.2 + 0.07 * (f64::from(k) + 0.5);
                    let near_boundary =
                        lit.iter().any(|i| (x - i.start).abs() < 1e-9 || (x - i.end).abs() < 1e-9);
                    if near_boundary {
                        continue;
                    }
                    let from = ray.at(x);
                    let (direction, far) = match light {
                        Light::Point(light) => {
                            let to = light.position.as_dvec3() - from;
                            (to.normalize(), to.length())
                        }
                        Light::Directional(light) => (-light.direction.as_dvec3().normalize(), f64::INFINITY),
                        Light::Spot(_) => unreachable!("no spot light in this test"),
                    };
                    let by_ray = !bvh.occluded(&DRay { origin: from, direction }, 0.0, far);
                    let by_interval = lit.iter().any(|i| i.start < x && x < i.end);
                    assert_eq!(by_ray, by_interval, "ray {i}, light {id}, x {x}");
                    tested += 1;
                    in_light += usize::from(by_ray);
                }
            }
        }
        assert!(
            tested > 30_000 && in_light > tested / 10 && in_light < tested * 9 / 10,
            "{in_light} of {tested}"
        );
    }
}
