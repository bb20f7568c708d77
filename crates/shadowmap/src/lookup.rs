//! Asking a map about a point: one texel, or a filtered share of several.

use glam::DVec3;

use crate::{Bias, DepthMap, MapPoint, Outside, ProjectionKind, ShadowMapError};

/// Largest kernel of a percentage-closer lookup; units: texels.
pub const MAX_KERNEL: u32 = 32;

/// How lookups of single texels make a visibility.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The texel that the point falls in: 0 or 1.
    #[default]
    Nearest,
    /// Percentage-closer filtering: see [`Filter::pcf`].
    Pcf(Kernel),
}

/// Width of a filter in texels: 1 to [`MAX_KERNEL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kernel(u32);

impl Kernel {
    /// Width; units: texels.
    pub fn width(self) -> u32 {
        self.0
    }
}

impl Filter {
    /// The lit share of a square of `width` × `width` texels around the point.
    ///
    /// Every texel counts by the part of it that the square covers, so that the result is continuous; width 1 is what
    /// hardware does with a linear comparison sampler. All texels are compared with the point's own depth: a receiver
    /// parallel to the map. Over the edge of a cube's face the square goes on in the plane of that face, and each of
    /// its points asks the face that sees it; over the edge of other maps [`DepthMap::outside`] answers.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if the width is 0 or larger than [`MAX_KERNEL`].
    pub fn pcf(width: u32) -> Result<Self, ShadowMapError> {
        if (1..=MAX_KERNEL).contains(&width) {
            return Ok(Self::Pcf(Kernel(width)));
        }
        let valid = "be 1 to 32 texels";
        Err(ShadowMapError::Setting { name: "the kernel's width", value: width as f32, valid })
    }
}

fn share(lit: bool) -> f32 {
    f32::from(u8::from(lit))
}

impl DepthMap {
    /// Visibility of the light from a point in the medium: 1 lit, 0 shadowed.
    ///
    /// What the map does not see is answered by [`DepthMap::outside`]; the light itself sees itself.
    #[inline]
    pub fn visibility(&self, point: DVec3, filter: Filter, bias: Bias) -> f32 {
        self.filtered(point, filter, bias.in_medium())
    }

    /// Visibility of the light from a point on a surface with unit normal `normal`, either side of it: as
    /// [`DepthMap::visibility`] with the slope-scaled part of the bias.
    pub fn surface_visibility(&self, point: DVec3, normal: DVec3, filter: Filter, bias: Bias) -> f32 {
        let Some(at) = self.locate(point) else {
            return share(self.is_outside_lit());
        };
        let slope = self.projection().faces()[at.face].depth_slope(point, normal, self.size());
        self.filtered(point, filter, bias.on_surface(slope))
    }

    fn is_outside_lit(&self) -> bool {
        self.projection().kind() == ProjectionKind::Cube || self.outside() == Outside::Lit
    }

    #[inline]
    fn filtered(&self, point: DVec3, filter: Filter, bias: f64) -> f32 {
        let Some(at) = self.locate(point) else {
            return share(self.is_outside_lit());
        };
        match filter {
            Filter::Nearest => share(self.nearest(at, bias)),
            Filter::Pcf(kernel) => self.closer_share(at, kernel.0, bias),
        }
    }

    /// Whether a point within the map lies before the texel that it falls in.
    #[inline]
    pub(crate) fn nearest(&self, at: MapPoint, bias: f64) -> bool {
        let size = self.size();
        let texel = |x: f64, count: u32| (x as u32).min(count - 1);
        let stored = self.depth(at.face, texel(at.u, size.0), texel(at.v, size.1));
        at.depth <= f64::from(stored) + bias
    }

    fn closer_share(&self, at: MapPoint, width: u32, bias: f64) -> f32 {
        // texels whose centre is nearest to the point come first: their first column and how much of it is covered
        let reach = 0.5 * f64::from(width);
        let (left, top) = ((at.u - reach).floor(), (at.v - reach).floor());
        let (fraction_u, fraction_v) = (at.u - reach - left, at.v - reach - top);
        let weight = |i: u32, fraction: f64| match i {
            0 => 1.0 - fraction,
            i if i == width => fraction,
            _ => 1.0,
        };
        let mut sum = 0.0;
        for j in 0..=width {
            for i in 0..=width {
                let weight = weight(i, fraction_u) * weight(j, fraction_v);
                if weight > 0.0 {
                    let (u, v) = (left + f64::from(i) + 0.5, top + f64::from(j) + 0.5);
                    sum += weight * f64::from(share(self.tap(at, u, v, bias)));
                }
            }
        }
        (sum / f64::from(width * width)) as f32
    }

    /// One comparison of a filter, at texel position (`u`, `v`) of the face, maybe beyond its edge.
    fn tap(&self, at: MapPoint, u: f64, v: f64, bias: f64) -> bool {
        let size = self.size();
        if u >= 0.0 && v >= 0.0 && u < f64::from(size.0) && v < f64::from(size.1) {
            return self.nearest(MapPoint { u, v, ..at }, bias);
        }
        if self.projection().kind() != ProjectionKind::Cube {
            return self.outside() == Outside::Lit;
        }
        let point = self.projection().faces()[at.face].unproject(u, v, at.depth, size);
        self.locate(point).is_none_or(|at| self.nearest(at, bias))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;
    use glam::DVec2;

    /// 4 × 4 texels of 1 m: the left half ends at 1 m, the right half at 9 m.
    fn halves(outside: Outside) -> DepthMap {
        let projection =
            Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::splat(2.0)).unwrap();
        let depths = (0..16).map(|i| if i % 4 < 2 { 1.0 } else { 9.0 }).collect();
        DepthMap::new(projection, (4, 4), depths).unwrap().with_outside(outside)
    }

    fn at(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, -5.0)
    }

    #[test]
    fn nearest_by_hand() {
        let map = halves(Outside::Lit);
        let ask = |p: DVec3| map.visibility(p, Filter::Nearest, Bias::NONE);
        assert_eq!((ask(at(-0.1, 0.0)), ask(at(0.1, 0.0))), (0.0, 1.0));
        assert_eq!((ask(at(-0.1, 0.0) + 4.5 * DVec3::Z), ask(at(0.1, 0.0) - 5.0 * DVec3::Z)), (1.0, 0.0));
        // before the plane of depth 0 everything is lit; beside the map the setting answers
        assert_eq!(ask(DVec3::new(-0.1, 0.0, 3.0)), 1.0);
        assert_eq!((ask(at(2.1, 0.0)), ask(at(-2.1, 0.0))), (1.0, 1.0));
        let dark = halves(Outside::Dark);
        assert_eq!(dark.visibility(at(2.1, 0.0), Filter::Nearest, Bias::NONE), 0.0);
        assert_eq!(dark.visibility(at(2.0, 0.0), Filter::Nearest, Bias::NONE), 1.0, "the edge is inside");
    }

    #[test]
    fn pcf_is_the_covered_share() {
        let map = halves(Outside::Lit);
        let ask = |width, x| map.visibility(at(x, 0.3), Filter::pcf(width).unwrap(), Bias::NONE);
        for (width, x, expected) in [
            (1, 0.0, 0.5),
            (1, 0.25, 0.75),
            (1, 0.5, 1.0),
            (1, -0.5, 0.0),
            (2, 0.5, 0.75),
            (2, -0.9, 0.05),
            (3, 0.0, 0.5),
        ] {
            assert!((ask(width, x) - expected).abs() < 1e-6, "{width} {x}: {}", ask(width, x));
        }
        // half of the square lies beside the map
        let dark = halves(Outside::Dark);
        let share = dark.visibility(at(2.0, 0.0), Filter::pcf(1).unwrap(), Bias::NONE);
        assert!((share - 0.5).abs() < 1e-6);
        assert!(Filter::pcf(0).is_err() && Filter::pcf(33).is_err());
    }

    #[test]
    fn pcf_goes_on_over_the_edge_of_a_cube_face() {
        let projection = Projection::cube(DVec3::ZERO).unwrap();
        let mut depths = vec![9.0; 6 * 16];
        // the whole +Y face is near
        depths[32..48].fill(1.0);
        let map = DepthMap::new(projection, (4, 4), depths).unwrap();
        let near_edge = DVec3::new(5.0, 5.0 - 1e-9, 0.1);
        let share = map.visibility(near_edge, Filter::pcf(2).unwrap(), Bias::NONE);
        assert!((share - 0.5).abs() < 1e-6, "{share}");
        assert_eq!(map.visibility(DVec3::ZERO, Filter::pcf(2).unwrap(), Bias::NONE), 1.0);
    }

    #[test]
    fn surfaces_need_the_slope() {
        // a tilted plane drawn at texel centres shadows itself between them
        let projection = Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        let depths = (0..16).map(|i| 5.0 + 0.5 * (i % 4) as f32).collect();
        let map = DepthMap::new(projection, (4, 4), depths).unwrap();
        // depth grows by 1 m per m of x
        let normal = DVec3::new(1.0, 0.0, 1.0).normalize();
        let on_plane = |x: f64| DVec3::new(x, 0.1, -(5.75 + x));
        let lit = |x: f64, bias| map.surface_visibility(on_plane(x), normal, Filter::Nearest, bias);
        let (none, sloped) = (Bias::NONE, Bias::new(0.0, 0.6, 10.0).unwrap());
        let xs = || (0..40).map(|i| -0.99 + 0.0495 * f64::from(i));
        assert!(xs().any(|x| lit(x, none) == 0.0));
        assert!(xs().all(|x| lit(x, sloped) == 1.0));
        assert_eq!(map.surface_visibility(DVec3::new(5.0, 0.0, -1.0), normal, Filter::Nearest, none), 1.0);
    }
}
