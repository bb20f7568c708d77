//! Where the way of light through a bounded medium changes its formula.

use glam::DVec3;
use scene::{Aabb, DRay, Interval, Light};

/// Sorts into `cuts` the distances within `span` at which the light's way starts to leave through another face.
///
/// Between two of them the length of the way is smooth in x: linear for a directional light.
pub(crate) fn face_cuts(bounds: &Aabb, ray: &DRay, span: Interval, light: &Light, cuts: &mut Vec<f64>) {
    cuts.clear();
    let (position, towards_sun) = match light {
        Light::Point(light) => (Some(light.position.as_dvec3()), DVec3::ZERO),
        Light::Spot(light) => (Some(light.position.as_dvec3()), DVec3::ZERO),
        Light::Directional(light) => (None, -light.direction.as_dvec3()),
    };
    // (w0 + w x)/(l0 + l x) with these numerator and denominator is the share of the way to a face
    let mut faces: Vec<[f64; 4]> = Vec::with_capacity(3);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        let (min, max) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
        match position {
            Some(p) => {
                let p = p[axis];
                if p > max || p < min {
                    let face = if p > max { max } else { min };
                    faces.push([face - o, -d, p - o, -d]);
                }
            }
            None => {
                let to = towards_sun[axis];
                if to != 0.0 {
                    let face = if to > 0.0 { max } else { min };
                    faces.push([face - o, -d, to, 0.0]);
                }
            }
        }
    }
    for (i, a) in faces.iter().enumerate() {
        for b in &faces[i + 1..] {
            // equal shares: the products' x² terms are equal, or absent, so the condition is linear
            let constant = a[0] * b[2] - b[0] * a[2];
            let slope = a[0] * b[3] + a[1] * b[2] - b[0] * a[3] - b[1] * a[2];
            let x = -constant / slope;
            if x > span.start && x < span.end {
                cuts.push(x);
            }
        }
    }
    cuts.sort_unstable_by(f64::total_cmp);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scene::{DirectionalLight, Medium, PointLight};

    const BOUNDS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

    #[test]
    fn the_length_is_smooth_between_cuts() {
        let ray =
            DRay { origin: DVec3::new(0.01, 0.02, 0.1), direction: DVec3::new(1.0, 0.7, 0.9).normalize() };
        let span = Interval::new(0.0, 1.1);
        let medium = Medium { bounds: Some(BOUNDS), ..Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap() };
        for light in [
            Light::Point(PointLight::new(Vec3::new(1.6, 1.3, 1.4), Vec3::ONE).unwrap()),
            Light::Directional(DirectionalLight::new(Vec3::new(-0.9, -1.2, -1.0), Vec3::ONE).unwrap()),
        ] {
            let mut cuts = Vec::new();
            face_cuts(&BOUNDS, &ray, span, &light, &mut cuts);
            let path = |x: f64| medium.light_path(ray.at(x), &light);
            let kink = |x: f64| (path(x - 1e-4) - 2.0 * path(x) + path(x + 1e-4)).abs() > 1e-5;
            for i in 1..1000 {
                let x = 1.1e-3 * f64::from(i);
                let near_cut = cuts.iter().any(|cut| (cut - x).abs() < 2e-4);
                assert!(!kink(x) || near_cut, "{light:?}: kink at {x}, cuts {cuts:?}");
            }
        }
    }
}
