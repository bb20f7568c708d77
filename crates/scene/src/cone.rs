//! The part of a view ray inside a spot light's cone.

use crate::{DRay, Interval, SpotLight};

impl SpotLight {
    /// The part of `span` inside the outer cone; empty if the ray misses it.
    pub fn clip(&self, ray: &DRay, span: Interval) -> Interval {
        self.clip_within(ray, span, f64::from(self.outer))
    }

    /// The part of `span` inside the cone of half-angle `angle` (in rad, below π/2) around the light's axis; empty if
    /// the ray misses it.
    pub fn clip_within(&self, ray: &DRay, span: Interval, angle: f64) -> Interval {
        let mut cuts = Vec::with_capacity(5);
        self.cone_crossings(ray, angle, &mut cuts);
        // and the plane through the light: a ray down the axis touches both nappes in one point, which rounding may miss
        let (z, w0) = (self.direction.as_dvec3(), ray.origin - self.position.as_dvec3());
        cuts.push(-w0.dot(z) / ray.direction.dot(z));
        cuts.retain(|&x| x > span.start && x < span.end);
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.insert(0, span.start);
        cuts.push(span.end);
        // the cone is convex: one piece at most is inside
        let cosine = angle.cos();
        let mut inside = Interval::new(span.start, span.start);
        for pair in cuts.windows(2) {
            let middle =
                if pair[1].is_finite() { 0.5 * (pair[0] + pair[1]) } else { 2.0 * pair[0].abs() + 1e9 };
            let w = ray.at(middle) - self.position.as_dvec3();
            if w.dot(z) > cosine * w.length() {
                let start = if inside.is_empty() { pair[0] } else { inside.start };
                inside = Interval::new(start, pair[1]);
            }
        }
        inside
    }

    /// Adds the distances at which the ray crosses the double cone of half-angle `angle` around the light's axis.
    pub fn cone_crossings(&self, ray: &DRay, angle: f64, cuts: &mut Vec<f64>) {
        let z = self.direction.as_dvec3();
        let w0 = ray.origin - self.position.as_dvec3();
        let (a, b, c2) = (w0.dot(z), ray.direction.dot(z), angle.cos().powi(2));
        // (a + b x)² = cos²·|w0 + x ω|²
        let (qa, qb, qc) = (b * b - c2, a * b - c2 * w0.dot(ray.direction), a * a - c2 * w0.length_squared());
        let discriminant = qb * qb - qa * qc;
        if discriminant < 0.0 {
            return;
        }
        let q = -(qb + discriminant.sqrt().copysign(qb));
        cuts.extend([q / qa, qc / q].into_iter().filter(|x| x.is_finite()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    fn spot(outer_degrees: f32) -> SpotLight {
        SpotLight::new(Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y, 0.0, outer_degrees.to_radians(), Vec3::ONE)
            .unwrap()
    }

    fn along_x(y: f64) -> DRay {
        DRay { origin: DVec3::new(-10.0, y, 0.0), direction: DVec3::X }
    }

    #[test]
    fn cone_by_hand() {
        let all = Interval::new(0.0, f64::INFINITY);
        let span = spot(45.0).clip(&along_x(0.0), all);
        assert!((span.start - 8.0).abs() < 1e-5 && (span.end - 12.0).abs() < 1e-5, "{span:?}");
        // above the light there is only the mirrored cone, which is dark
        assert!(spot(45.0).clip(&along_x(4.0), all).is_empty());
        // down the axis: lit from the light on
        let down = DRay { origin: DVec3::new(0.0, 5.0, 0.0), direction: DVec3::NEG_Y };
        let span = spot(30.0).clip(&down, all);
        assert!((span.start - 3.0).abs() < 1e-9 && span.end.is_infinite(), "{span:?}");
        // wide enough to hold a falling ray to infinity
        let out =
            DRay { origin: DVec3::new(0.0, 1.0, 0.0), direction: DVec3::new(0.1, -1.0, 0.0).normalize() };
        assert_eq!(spot(89.0).clip(&out, all), all);
    }
}
