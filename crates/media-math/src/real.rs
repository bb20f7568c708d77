//! The floating-point types that the crate computes in.

use core::fmt::Debug;
use num_traits::{Float, FloatConst};

/// `f32` or `f64`, with the constants whose best value depends on the precision.
///
/// The node counts and radii are those of the accuracy study behind
/// [`airlight`](crate::airlight): fewer lose accuracy, more gain none, because the
/// rounding of the exponent σ_t·(x₀ + d₀) is then the largest error.
pub trait Real: Float + FloatConst + Debug + Default + Send + Sync + 'static {
    /// One, as a constant.
    const UNIT: Self;
    /// Gauss-Legendre nodes of the short form.
    const SHORT_NODES: usize;
    /// Gauss-Legendre nodes in each panel of the composite form.
    const PANEL_NODES: usize;
    /// Optical depth past the near end after which the composite form stops: e^(−cut) is below the rounding.
    const PANEL_CUT: f64;
    /// |z| below which e^z E₁(z) is summed as a power series.
    const SERIES_RADIUS: f64;
    /// Terms of that power series.
    const SERIES_TERMS: usize;
    /// Smallest distance of the light from the ray's line, as a share of the longest length involved.
    ///
    /// Its square must stay a normal number. Only rays that pass through the light itself are touched.
    const MIN_RELATIVE_H: f64;
    /// Distance past which the end of an interval counts as infinite, as a multiple of the light's distance.
    const FAR: f64;
    /// R past which the composite form stops, as a multiple of R₀ + h.
    const PANEL_FAR: f64;
    /// Whether the outer evaluation of e^z E₁(z) uses the sum of real poles, which holds 5·10⁻⁶.
    const USE_POLES: bool;

    /// Converts a constant, rounding to nearest.
    fn lit(value: f64) -> Self;
    /// Converts to `f64`, exactly.
    fn widen(self) -> f64;
}

impl Real for f32 {
    const UNIT: Self = 1.0;
    const SHORT_NODES: usize = 4;
    const PANEL_NODES: usize = 8;
    const PANEL_CUT: f64 = 18.0;
    const SERIES_RADIUS: f64 = 1.0;
    const SERIES_TERMS: usize = 12;
    const MIN_RELATIVE_H: f64 = 1e-15;
    const FAR: f64 = 1e12;
    const PANEL_FAR: f64 = 1e9;
    const USE_POLES: bool = true;

    #[inline(always)]
    fn lit(value: f64) -> Self {
        value as Self
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const UNIT: Self = 1.0;
    const SHORT_NODES: usize = 12;
    const PANEL_NODES: usize = 20;
    const PANEL_CUT: Self = 40.0;
    const SERIES_RADIUS: Self = 3.0;
    const SERIES_TERMS: usize = 34;
    const MIN_RELATIVE_H: Self = 1e-120;
    const FAR: Self = 1e100;
    const PANEL_FAR: Self = 1e17;
    const USE_POLES: bool = false;

    #[inline(always)]
    fn lit(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        self
    }
}
