//! Which lights a point needs shadow rays for, and which point asks for it in the grid.
//!
//! `f32` throughout, so that CPU and GPU trace the same rays.

use glam::Vec3;
use scene::{Aabb, Density, Light, Medium};

use crate::Frame;

/// The lights that shine on a point, one bit a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Needs {
    /// Those that something may shadow.
    pub(crate) rays: u32,
    /// Those that nothing can: lit without a ray.
    pub(crate) free: u32,
}

/// Answers by the lights' cones, the medium's extent and the casters' box.
#[derive(Debug)]
pub(crate) struct Scout<'a> {
    lights: &'a [Light],
    /// Cosines of the spots' outer half-angles, 0 for other lights.
    cosines: Vec<f32>,
    extent: Aabb,
    casters: Option<Aabb>,
}

/// Where there is any medium, in all of space if nothing bounds it; units: m.
fn extent(medium: &Medium) -> Aabb {
    let mut extent = Aabb { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };
    let grid = match &medium.density {
        Some(Density::Grid(grid)) => Some(grid.bounds),
        _ => None,
    };
    for bounds in [medium.bounds, grid].into_iter().flatten() {
        extent = Aabb { min: extent.min.max(bounds.min), max: extent.max.min(bounds.max) };
    }
    extent
}

/// Whether a point lies in a box or on its surface.
pub(crate) fn inside(bounds: &Aabb, point: Vec3) -> bool {
    point.cmpge(bounds.min).all() && point.cmple(bounds.max).all()
}

/// Where the way from a point to a light enters a box; `None` if it misses. The point must lie outside.
pub(crate) fn entry(bounds: &Aabb, point: Vec3, light: &Light) -> Option<Vec3> {
    let (direction, mut far) = match light {
        Light::Point(light) => (light.position - point, 1.0),
        Light::Spot(light) => (light.position - point, 1.0),
        Light::Directional(light) => (-light.direction, f32::INFINITY),
    };
    let mut near = 0.0_f32;
    for axis in 0..3 {
        let (o, d) = (point[axis], direction[axis]);
        if d == 0.0 {
            if o < bounds.min[axis] || o > bounds.max[axis] {
                return None;
            }
        } else {
            let (a, b) = ((bounds.min[axis] - o) / d, (bounds.max[axis] - o) / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    (near <= far).then(|| point + near * direction)
}

/// The point that asks in a point's place for a light's shadow in a grid over `bounds`: where its way enters, since
/// nothing outside blocks it.
pub(crate) fn stand_in(bounds: &Aabb, point: Vec3, light: &Light) -> Vec3 {
    if inside(bounds, point) {
        return point;
    }
    // a way that only just touches the box may miss the larger one by rounding
    entry(bounds, point, light).unwrap_or(point)
}

impl<'a> Scout<'a> {
    pub(crate) fn new(frame: &Frame<'a>) -> Self {
        let cosine = |light: &Light| match light {
            Light::Spot(spot) => f64::from(spot.outer).cos() as f32,
            _ => 0.0,
        };
        Self {
            lights: frame.lights,
            cosines: frame.lights.iter().map(cosine).collect(),
            extent: extent(frame.medium),
            casters: frame.casters(),
        }
    }

    /// Whether a light's cone holds the point.
    fn shines(&self, point: Vec3, light: usize) -> bool {
        let Light::Spot(spot) = &self.lights[light] else { return true };
        let from = point - spot.position;
        spot.direction.dot(from) > self.cosines[light] * from.length()
    }

    /// Whether something may be between the point and a light.
    pub(crate) fn may_be_shadowed(&self, point: Vec3, light: usize) -> bool {
        self.casters.is_some_and(|casters| {
            inside(&casters, point) || entry(&casters, point, &self.lights[light]).is_some()
        })
    }

    /// The lights that shine on a point.
    pub(crate) fn needs(&self, point: Vec3) -> Needs {
        let mut needs = Needs::default();
        if !inside(&self.extent, point) {
            return needs;
        }
        for light in 0..self.lights.len() {
            if !self.shines(point, light) {
                continue;
            }
            if self.may_be_shadowed(point, light) {
                needs.rays |= 1 << light;
            } else {
                needs.free |= 1 << light;
            }
        }
        needs
    }
}

/// The indices of the bits that are set, lowest first.
pub(crate) fn bits(mut word: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 32).then_some(bit as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Occluders;
    use scene::{AirlightModel, DirectionalLight, PointLight, SpotLight, Unoccluded};

    fn lights() -> Vec<Light> {
        vec![
            Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::ONE).unwrap()),
            Light::Spot(
                SpotLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::NEG_Y, 0.1, 45_f32.to_radians(), Vec3::ONE)
                    .unwrap(),
            ),
            Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap()),
        ]
    }

    #[test]
    fn needs_by_hand() {
        let bounds = Aabb { min: Vec3::new(-1.0, 1.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
        let (lights, mut medium) = (lights(), Medium::homogeneous([0.1; 3], [0.0; 3]).unwrap());
        medium.bounds = Some(Aabb { min: Vec3::splat(-10.0), max: Vec3::splat(10.0) });
        let occluders = Some(Occluders { visibility: &Unoccluded, bounds });
        let frame =
            Frame { views: &[], medium: &medium, lights: &lights, model: AirlightModel::Sun, occluders };
        let scout = Scout::new(&frame);
        let needs = |x: f32, y: f32| {
            let needs = scout.needs(Vec3::new(x, y, 0.0));
            (needs.rays, needs.free)
        };
        assert_eq!(needs(0.0, 0.0), (0b111, 0));
        assert_eq!(needs(0.0, 1.5), (0b111, 0));
        // above the box; beside it, where only the sun's way misses; outside of the cone; outside of the medium
        assert_eq!(needs(0.0, 3.0), (0, 0b111));
        assert_eq!(needs(1.5, 0.0), (0b011, 0b100));
        assert_eq!(needs(5.0, 0.0), (0, 0b101));
        assert_eq!(needs(11.0, 0.0), (0, 0));
        let bare = Frame { occluders: None, ..frame };
        assert_eq!(Scout::new(&bare).needs(Vec3::ZERO), Needs { rays: 0, free: 0b111 });
        assert_eq!(entry(&bounds, Vec3::ZERO, &lights[2]), Some(Vec3::Y));
        assert_eq!(stand_in(&bounds, Vec3::ZERO, &lights[0]), Vec3::Y);
        assert_eq!(stand_in(&bounds, Vec3::splat(1.0), &lights[0]), Vec3::splat(1.0));
    }

    #[test]
    fn bits_in_order() {
        assert_eq!(bits(0x8000_0005).collect::<Vec<_>>(), [0, 2, 31]);
        assert_eq!(bits(0).count(), 0);
    }
}
