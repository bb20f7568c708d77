//! Where the light of a spot changes its formula along a view ray: the cone, its inner edge, the texels.

use glam::DVec3;
use scene::{DRay, Interval, SpotLight, TextureFilter};

/// Sorts into `cuts` the distances within `span` at which the spot's intensity or its slope jumps.
pub(crate) fn intensity_cuts(light: &SpotLight, ray: &DRay, span: Interval, cuts: &mut Vec<f64>) {
    cuts.clear();
    light.cone_crossings(ray, f64::from(light.inner), cuts);
    // falloff is clamped to 1 inside `inner`, or earlier where the two cones nearly touch
    let (cos_inner, cos_outer) = (f64::from(light.inner).cos(), f64::from(light.outer).cos());
    if cos_inner - cos_outer < 0.001 {
        light.cone_crossings(ray, (cos_outer + 0.001).min(1.0).acos(), cuts);
    }
    if let Some(texture) = &light.texture {
        let z = light.direction.as_dvec3();
        let right = light.right.as_dvec3();
        let down = -right.cross(z);
        let k = f64::from(light.outer).tan();
        let shift = match texture.filter {
            TextureFilter::Nearest => 0.0,
            TextureFilter::Linear => 0.5,
        };
        let mut planes = |axis: DVec3, count: u32| {
            // ½ + ½ (w·axis)/((w·z) k) = (i + shift)/count is a plane through the light
            for i in 0..=count {
                let s = 2.0 * (f64::from(i) + shift) / f64::from(count) - 1.0;
                let normal = axis - s * k * z;
                let x = (light.position.as_dvec3() - ray.origin).dot(normal) / ray.direction.dot(normal);
                if x > span.start && x < span.end {
                    cuts.push(x);
                }
            }
        };
        planes(right, texture.width);
        planes(down, texture.height);
    }
    cuts.retain(|&x| x > span.start && x < span.end);
    cuts.sort_unstable_by(f64::total_cmp);
}
