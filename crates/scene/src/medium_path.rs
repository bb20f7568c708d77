//! How much medium lies on a way: the eye's, and the light's.

use glam::DVec3;
use media_math::phi;

use crate::{DRay, Density, DensityGrid, Interval, Light, Medium};

/// Steps per cell side when a way through a density grid is summed.
const STEPS_PER_CELL: f64 = 4.0;

impl Medium {
    /// ∫ density along `ray` over `span`, inside the bounds; units: m. Optical depth is this times σ_t.
    ///
    /// Closed form but for a density grid, which is summed by midpoints, four to a cell. Infinite where an infinite
    /// span never leaves the medium.
    pub fn optical_path(&self, ray: &DRay, span: Interval) -> f64 {
        let span = match &self.bounds {
            Some(bounds) => span.intersect(bounds.clip(ray)),
            None => span,
        };
        if span.is_empty() {
            return 0.0;
        }
        match &self.density {
            None => span.length(),
            Some(Density::Height { y0, scale }) => height_path(f64::from(*y0), f64::from(*scale), ray, span),
            Some(Density::Grid(grid)) => grid_path(grid, ray, span),
        }
    }

    /// ∫ density on the way from `point` to `light`; units: m.
    ///
    /// A directional light reaches every point of an unbounded medium unattenuated: 0. A density grid is bounded by
    /// its box, as the medium is by its bounds.
    pub fn light_path(&self, point: DVec3, light: &Light) -> f64 {
        let position = match light {
            Light::Point(light) => light.position,
            Light::Spot(light) => light.position,
            Light::Directional(light) => {
                if self.bounds.is_none() && !matches!(self.density, Some(Density::Grid(_))) {
                    return 0.0;
                }
                let ray = DRay { origin: point, direction: -light.direction.as_dvec3().normalize() };
                return self.optical_path(&ray, Interval::new(0.0, f64::INFINITY));
            }
        };
        let to = position.as_dvec3() - point;
        let ray = DRay { origin: point, direction: to.normalize_or(DVec3::Y) };
        self.optical_path(&ray, Interval::new(0.0, to.length()))
    }
}

/// ∫ e^(−max(y − y0, 0)/scale) dx.
fn height_path(y0: f64, scale: f64, ray: &DRay, span: Interval) -> f64 {
    let slope = ray.direction.y;
    let height = |x: f64| ray.origin.y + x * slope - y0;
    // where the ray passes through y0, if it does inside the span
    let crossing = -height(0.0) / slope;
    let cut = if crossing > span.start && crossing < span.end { crossing } else { span.end };
    [Interval::new(span.start, cut), Interval::new(cut, span.end)]
        .into_iter()
        .filter(|piece| !piece.is_empty())
        .map(|piece| {
            let inside =
                if piece.end.is_finite() { 0.5 * (piece.start + piece.end) } else { piece.start + 1.0 };
            if height(inside) <= 0.0 {
                return piece.length();
            }
            let at = |x: f64| (-height(x).max(0.0) / scale).exp();
            if piece.end.is_infinite() {
                return if slope > 0.0 { at(piece.start) * scale / slope } else { f64::INFINITY };
            }
            // from the lower end, where the density is larger: from the upper one a long way down is 0 times infinity
            let densest = at(if slope < 0.0 { piece.end } else { piece.start });
            densest * piece.length() * phi(piece.length() * slope.abs() / scale)
        })
        .sum()
}

fn grid_path(grid: &DensityGrid, ray: &DRay, span: Interval) -> f64 {
    let span = span.intersect(grid.bounds.clip(ray));
    if span.is_empty() {
        return 0.0;
    }
    let steps = (STEPS_PER_CELL * span.length() / grid.cell()).ceil().clamp(1.0, 65536.0);
    let step = span.length() / steps;
    (0..steps as u32).map(|i| grid.at(ray.at(span.start + step * (f64::from(i) + 0.5)))).sum::<f64>() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, DirectionalLight, PointLight};
    use glam::Vec3;

    fn medium() -> Medium {
        Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap()
    }

    #[test]
    fn bounded_lengths_by_hand() {
        let bounded = Medium { bounds: Some(Aabb { min: Vec3::ZERO, max: Vec3::ONE }), ..medium() };
        let sun = Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap());
        assert_eq!(bounded.light_path(DVec3::splat(0.25), &sun), 0.75);
        assert_eq!(medium().light_path(DVec3::splat(0.25), &sun), 0.0);
        let lamp = |y: f32| Light::Point(PointLight::new(Vec3::new(0.5, y, 0.5), Vec3::ONE).unwrap());
        assert_eq!(bounded.light_path(DVec3::splat(0.5), &lamp(3.5)), 0.5);
        assert_eq!(bounded.light_path(DVec3::splat(0.5), &lamp(0.75)), 0.25);
        assert_eq!(medium().light_path(DVec3::splat(0.5), &lamp(3.5)), 3.0);
        assert_eq!(medium().light_path(DVec3::splat(0.5), &lamp(0.5)), 0.0);
    }

    #[test]
    fn height_fog_equals_a_sum() {
        let fog = Medium { density: Some(Density::height(1.0, 0.7).unwrap()), ..medium() };
        for (direction, origin_y) in [([0.6, 0.8, 0.0], 0.0), ([0.6, -0.8, 0.0], 4.0), ([1.0, 0.0, 0.0], 2.0)]
        {
            let ray = DRay { origin: DVec3::new(0.0, origin_y, 0.0), direction: direction.into() };
            let density = fog.density.as_ref().unwrap();
            let sum: f64 =
                (0..100_000).map(|i| density.at(ray.at(1e-4 * (f64::from(i) + 0.5) * 0.6)) * 6e-5).sum();
            let got = fog.optical_path(&ray, Interval::new(0.0, 6.0));
            assert!((got / sum - 1.0).abs() < 1e-6, "{got} {sum}");
        }
        let up = DRay { origin: DVec3::ZERO, direction: DVec3::Y };
        assert!((fog.optical_path(&up, Interval::new(0.0, f64::INFINITY)) - 1.7).abs() < 1e-7);
    }

    #[test]
    fn a_constant_grid_is_a_bounded_medium() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0) };
        let grid = DensityGrid::new([4, 2, 2], bounds, vec![3.0; 16]).unwrap();
        let fog = Medium { density: Some(Density::Grid(grid)), ..medium() };
        let ray = DRay { origin: DVec3::new(-1.0, 0.5, 0.5), direction: DVec3::X };
        assert!((fog.optical_path(&ray, Interval::new(0.0, f64::INFINITY)) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_way_down_into_low_fog_is_the_way_up_out_of_it() {
        let density = Some(Density::height(0.0, 0.003).unwrap());
        let fog = Medium { density, ..Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap() };
        let length = 6.0;
        // a thousand scale heights up, and slanting
        let direction = DVec3::new(0.6, -0.8, 0.0);
        let down = DRay { origin: DVec3::new(0.0, 4.8, 0.0), direction };
        let up = DRay { origin: down.at(length), direction: -direction };
        let [down, up] = [down, up].map(|ray| fog.optical_path(&ray, Interval::new(0.0, length)));
        assert!((up - f64::from(0.003_f32) / 0.8).abs() < 1e-12, "{up}");
        assert!((down / up - 1.0).abs() < 1e-9, "{down} {up}");
    }
}
