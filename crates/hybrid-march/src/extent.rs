//! Which part of a view ray a march has to visit at all.

use scene::{Aabb, DRay, Interval, Light};

/// The part of `span` that occluders inside `bounds` may shadow: what lies outside is lit without a sample.
///
/// Exact for the sphere around the box, which is what keeps it cheap; the box's own shadow is never larger.
pub fn shadow_extent(bounds: &Aabb, light: &Light, ray: &DRay, span: Interval) -> Interval {
    let nothing = Interval::new(span.start, span.start);
    if bounds.is_empty() {
        return nothing;
    }
    let center = bounds.center().as_dvec3();
    // a little larger than the box, so that rounding cannot lose a triangle on its surface
    let radius = 0.5 * f64::from(bounds.diagonal()) * 1.0001 + 1e-12;
    let position = match light {
        Light::Point(light) => light.position.as_dvec3(),
        Light::Spot(light) => light.position.as_dvec3(),
        Light::Directional(light) => {
            // a half-infinite cylinder, capped at the sphere's near side
            let axis = light.direction.as_dvec3();
            let from = ray.origin - center;
            let (w, d) = (from - from.dot(axis) * axis, ray.direction - ray.direction.dot(axis) * axis);
            let inside = roots(d.length_squared(), w.dot(d), w.length_squared() - radius * radius);
            let behind = half_line(from.dot(axis) + radius, ray.direction.dot(axis));
            return inside.map_or(nothing, |inside| span.intersect(inside).intersect(behind));
        }
    };
    let to_center = center - position;
    let distance = to_center.length();
    if distance <= radius {
        return span;
    }
    // the cone around the sphere, capped at the sphere's near side
    let axis = to_center / distance;
    let sin2 = (radius / distance).powi(2);
    let from = ray.origin - position;
    let (a, b) = (from.dot(axis), ray.direction.dot(axis));
    // |w|² − (w·axis)² ≤ tan²·(w·axis)²
    let cos2 = 1.0 - sin2;
    let (qa, qb, qc) =
        (b * b - cos2, a * b - cos2 * from.dot(ray.direction), a * a - cos2 * from.length_squared());
    let behind = half_line(a - (distance - radius), b);
    let behind = span.intersect(behind);
    if behind.is_empty() {
        return nothing;
    }
    // within the half-space only one nappe is left, and its part of a line is one piece
    let inside = |x: f64| qa * x * x + 2.0 * qb * x + qc >= 0.0;
    let mut cuts = vec![behind.start];
    if let Some(pair) = roots(qa, qb, qc) {
        cuts.extend([pair.start, pair.end].into_iter().filter(|&x| x > behind.start && x < behind.end));
    }
    cuts.push(behind.end);
    let mut extent = nothing;
    for pair in cuts.windows(2) {
        let middle = if pair[1].is_finite() {
            0.5 * (pair[0] + pair[1])
        } else {
            2.0 * pair[0].abs() + distance + 1.0
        };
        if inside(middle) {
            extent = Interval::new(if extent.is_empty() { pair[0] } else { extent.start }, pair[1]);
        }
    }
    extent
}

/// The x with offset + slope·x ≥ 0.
fn half_line(offset: f64, slope: f64) -> Interval {
    let (all, x) = (Interval::new(f64::NEG_INFINITY, f64::INFINITY), -offset / slope);
    if slope > 0.0 {
        Interval::new(x, f64::INFINITY)
    } else if slope < 0.0 {
        Interval::new(f64::NEG_INFINITY, x)
    } else if offset >= 0.0 {
        all
    } else {
        Interval::new(0.0, 0.0)
    }
}

/// The roots of a x² + 2 b x + c in order; for a = b = 0 everything if c ≤ 0. `None` without roots.
fn roots(a: f64, b: f64, c: f64) -> Option<Interval> {
    if a == 0.0 && b == 0.0 {
        return (c <= 0.0).then_some(Interval::new(f64::NEG_INFINITY, f64::INFINITY));
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (x, y) = (q / a, c / q);
    Some(Interval::new(x.min(y), x.max(y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};
    use scene::{DirectionalLight, PointLight};

    /// Samples a ray and checks that every point whose way to the light meets the box lies in the extent.
    fn check(light: &Light, bounds: &Aabb) -> (usize, usize) {
        let (mut shadowed, mut outside) = (0, 0);
        for i in 0..200 {
            let t = f64::from(i);
            let origin = DVec3::new(6.0 * (0.7 * t).sin(), 4.0 * (1.1 * t).cos(), 6.0 * (1.9 * t).cos());
            let target = DVec3::new(3.0 * (2.3 * t).cos(), -2.0, 3.0 * (0.3 * t).sin());
            let ray = DRay { origin, direction: (target - origin).normalize() };
            let extent = shadow_extent(bounds, light, &ray, Interval::new(0.0, f64::INFINITY));
            for k in 0..200 {
                let x = 0.1 * f64::from(k);
                let point = ray.at(x);
                let (direction, far) = match light {
                    Light::Point(light) => {
                        let to = light.position.as_dvec3() - point;
                        (to.normalize(), to.length())
                    }
                    Light::Directional(light) => (-light.direction.as_dvec3(), f64::INFINITY),
                    Light::Spot(_) => unreachable!("no spot light in this test"),
                };
                let blocked = bounds.clip(&DRay { origin: point, direction });
                if !blocked.intersect(Interval::new(0.0, far)).is_empty() {
                    shadowed += 1;
                    assert!(extent.start <= x && x <= extent.end, "ray {i} at {x}: {extent:?}");
                } else if x < extent.start || x > extent.end {
                    outside += 1;
                }
            }
        }
        (shadowed, outside)
    }

    #[test]
    fn no_shadow_lies_outside() {
        let bounds = Aabb { min: Vec3::new(-1.0, -0.5, -1.0), max: Vec3::new(1.0, 0.5, 0.7) };
        let lights = [
            Light::Point(PointLight::new(Vec3::new(0.0, 5.0, 0.0), Vec3::ONE).unwrap()),
            Light::Point(PointLight::new(Vec3::new(4.0, 0.0, -2.0), Vec3::ONE).unwrap()),
            Light::Directional(DirectionalLight::new(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap()),
        ];
        for light in &lights {
            let (shadowed, outside) = check(light, &bounds);
            assert!(shadowed > 500 && outside > 10_000, "{shadowed} {outside}");
        }
        // inside the occluder's sphere nothing can be excluded
        let inside = Light::Point(PointLight::new(Vec3::ZERO, Vec3::ONE).unwrap());
        let ray = DRay { origin: DVec3::new(9.0, 0.0, 0.0), direction: DVec3::Y };
        let span = Interval::new(0.0, 5.0);
        assert_eq!(shadow_extent(&bounds, &inside, &ray, span), span);
        assert!(shadow_extent(&Aabb::EMPTY, &inside, &ray, span).is_empty());
    }
}
