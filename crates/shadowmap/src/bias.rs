//! Bias: how much behind the stored depth a point may lie and still count as lit.

use crate::ShadowMapError;

/// What is added to stored depths before points are compared with them.
///
/// A point in the medium belongs to no surface: only `constant` applies to it, so that a march and the exact traversal
/// agree. A point on a surface ([`DepthMap::surface_visibility`](crate::DepthMap::surface_visibility)) also gets
/// `slope` times the depth that the surface gains over a texel, at most `most`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bias {
    constant: f32,
    slope: f32,
    most: f32,
}

impl Bias {
    /// Stored depths as they are.
    pub const NONE: Self = Self { constant: 0.0, slope: 0.0, most: 0.0 };

    /// `constant` in m; `slope` in texels; `most` limits their sum for a point on a surface, in m, and may be infinite.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if a value is NaN or negative, or `constant` or `slope` infinite.
    pub fn new(constant: f32, slope: f32, most: f32) -> Result<Self, ShadowMapError> {
        let check = |name, value: f32, ok: bool, valid| {
            if ok { Ok(()) } else { Err(ShadowMapError::Setting { name, value, valid }) }
        };
        let finite = |value: f32| value >= 0.0 && value.is_finite();
        check("the constant bias", constant, finite(constant), "be finite and at least 0 m")?;
        check("the slope bias", slope, finite(slope), "be finite and at least 0 texels")?;
        check("the largest bias", most, most >= constant, "be at least the constant bias")?;
        Ok(Self { constant, slope, most })
    }

    /// Only a constant, in m.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if it is not finite or negative.
    pub fn constant(metres: f32) -> Result<Self, ShadowMapError> {
        Self::new(metres, 0.0, metres)
    }

    /// Bias of a point in the medium; units: m.
    #[inline]
    pub fn in_medium(&self) -> f64 {
        f64::from(self.constant)
    }

    /// Bias of a point on a surface that gains `depth_slope` metres of depth over a texel; units: m.
    #[inline]
    pub fn on_surface(&self, depth_slope: f64) -> f64 {
        // 0 · ∞ where the light grazes a surface and there is no slope bias
        let sloped = if self.slope == 0.0 { 0.0 } else { f64::from(self.slope) * depth_slope };
        (f64::from(self.constant) + sloped).min(f64::from(self.most))
    }
}

impl Default for Bias {
    fn default() -> Self {
        Self::NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_by_hand() {
        let bias = Bias::new(0.5, 2.0, 3.0).unwrap();
        assert_eq!((bias.in_medium(), bias.on_surface(0.25), bias.on_surface(9.0)), (0.5, 1.0, 3.0));
        assert_eq!(Bias::NONE.on_surface(f64::INFINITY), 0.0);
        for (constant, slope, most) in [
            (-1.0, 0.0, 1.0),
            (f32::NAN, 0.0, 1.0),
            (f32::INFINITY, 0.0, f32::INFINITY),
            (0.0, -1.0, 1.0),
            (0.5, 0.0, 0.4),
            (0.0, 0.0, f32::NAN),
        ] {
            assert!(Bias::new(constant, slope, most).is_err());
        }
    }
}
