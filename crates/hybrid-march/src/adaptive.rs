//! Airlight of every pixel from that of few: view rays are traced where the picture changes.
//!
//! Airlight is smooth over a picture but for depth edges, the borders of shafts and the glow around a light. So a coarse
//! lattice of rays is traced first, and its spacing halved again and again. A pixel halfway between pixels that are known
//! is interpolated if what is left out would be small, and traced if not:
//!
//! - its own depth and those of the pixels around it lie on one plane, within 2 %: 1/z is linear across the picture of a
//!   plane, so the test knows slopes from edges;
//! - the estimated error is at most the tolerance. Where the next pixels in line lie on the same plane, the prediction
//!   is a cubic, and the estimate how far it is from the straight line, or an eighth of the spread of what lies around it if
//!   that is more; else the prediction is the straight line, and the estimate half of that spread.
//!
//! The tolerance comes from the lattice itself: what shadows take away there, as root mean square, is the unit in which
//! `shadow_err` counts, and the target error is a share of it. No ray is traced twice, and no sample is random.
//!
//! Errors stay below the target as long as shafts are wider than the lattice; what slips through between four rays
//! that agree is not seen. Small pictures and small targets get a smaller tolerance for that.

use glam::DVec3;
use scene::Camera;
use thiserror::Error;

/// Largest distance of the first rays; units: pixels.
const MOST_SPACING: u32 = 16;

/// Inverse depths that differ by less than this share are on one plane.
const SAME_PLANE: f64 = 0.02;

/// The same for the next pixels in line, which are three times as far away.
const SAME_PLANE_FAR: f64 = 3.0 * SAME_PLANE;

/// Share of the values' spread that the estimated error of a cubic is at least.
const SPREAD_OF_CUBIC: f64 = 0.125;

/// The tolerance is so many times the target, since errors are mostly far below their estimate: in pictures from this side
/// on, and down to this target. The smaller a picture, the more of it lies beside borders; the smaller a target, the more counts
/// what slips through.
const TOLERANCE_PER_TARGET: f64 = 1.5;
const USUAL_SIDE: f64 = 1024.0;
const USUAL_TARGET: f64 = 0.01;

/// Share of the unshadowed airlight that shadows count as at least: below are the roundings of 32-bit floats.
const LEAST_SHADOWS: f64 = 1e-3;

/// Sampling that stops at a target error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// What interpolation may err by, as a share of what shadows take away in the picture: ‖a − b‖₂/‖u − b‖₂.
    pub target_error: f32,
    /// Distance of the first rays: 2, 4, 8 or 16; units: pixels.
    pub spacing: u32,
}

impl Default for Adaptive {
    /// 1 %, from every eighth pixel on.
    fn default() -> Self {
        Self { target_error: 0.01, spacing: 8 }
    }
}

/// What [`Adaptive`] cannot work with.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum AdaptiveError {
    /// The target is no share.
    #[error("the target error must be a finite number above 0, got {0}")]
    Target(f32),
    /// The lattice cannot be halved down to the pixels.
    #[error("the spacing of the first rays must be 2, 4, 8 or 16 pixels, got {0}")]
    Spacing(u32),
    /// There is not one end for each pixel.
    #[error("there must be {expected} ends of view rays, got {got}")]
    Ends {
        /// Pixels.
        expected: usize,
        /// Ends.
        got: usize,
    },
}

impl Adaptive {
    /// Down to a target error, with as many first rays as a picture of that size (width, height) needs to see its shafts: they
    /// are as much thinner, in pixels, as the picture is smaller.
    pub fn new(target_error: f32, (width, height): (u32, u32)) -> Self {
        let spacing = match (target_error, width.min(height)) {
            (0.02.., 700..) => 16,
            (0.005.., 350..) => 8,
            (_, 200..) => 4,
            _ => 2,
        };
        Self { target_error, spacing }
    }

    /// Fails for settings without meaning.
    ///
    /// # Errors
    /// [`AdaptiveError`] names the setting.
    pub fn check(&self) -> Result<(), AdaptiveError> {
        let Self { target_error, spacing } = *self;
        if !(target_error.is_finite() && target_error > 0.0) {
            return Err(AdaptiveError::Target(target_error));
        }
        if !(2..=MOST_SPACING).contains(&spacing) || !spacing.is_power_of_two() {
            return Err(AdaptiveError::Spacing(spacing));
        }
        Ok(())
    }

    /// The error that interpolation of a pixel of a picture of `size` (width, height) may be estimated to have, as a share of
    /// what shadows take away.
    pub fn tolerance(&self, (width, height): (u32, u32)) -> f64 {
        let (target, side) = (f64::from(self.target_error), f64::from(width.min(height)));
        let share = (target / USUAL_TARGET).min(1.0) * (side / USUAL_SIDE).min(1.0);
        TOLERANCE_PER_TARGET * target * share.sqrt()
    }

    /// The airlight of a picture of `size` (width, height), and how many rays of it were traced.
    ///
    /// `ends` says where the pixels' rays end in m, row-major, infinite where they meet nothing. `airlight` is asked for the
    /// radiance of pixels by their column and row, in their order; `unshadowed` for that of the same rays if nothing cast a shadow,
    /// once, for the lattice.
    ///
    /// # Errors
    /// [`AdaptiveError`] for settings without meaning, and if there is not one end for each pixel.
    pub fn picture(
        &self,
        camera: &Camera,
        size: (u32, u32),
        ends: &[f32],
        mut airlight: impl FnMut(&[(u32, u32)]) -> Vec<DVec3>,
        unshadowed: impl FnOnce(&[(u32, u32)]) -> Vec<DVec3>,
    ) -> Result<(Vec<DVec3>, u64), AdaptiveError> {
        self.check()?;
        let expected = size.0 as usize * size.1 as usize;
        if ends.len() != expected {
            return Err(AdaptiveError::Ends { expected, got: ends.len() });
        }
        let lattice: Vec<(u32, u32)> = (0..size.1)
            .step_by(self.spacing as usize)
            .flat_map(|y| (0..size.0).step_by(self.spacing as usize).map(move |x| (x, y)))
            .collect();
        let mut picture =
            Known { size, values: vec![DVec3::ZERO; expected], planes: planes(camera, size, ends) };
        let lit = airlight(&lattice);
        let tolerance = self.tolerance(size) * shadows(&lit, &unshadowed(&lattice));
        picture.set(&lattice, &lit);
        let mut traced = lattice.len() as u64;
        let mut stride = self.spacing;
        while stride > 1 {
            let wanted = picture.interpolate(stride, tolerance);
            picture.set(&wanted, &airlight(&wanted));
            traced += wanted.len() as u64;
            stride /= 2;
        }
        Ok((picture.values, traced))
    }
}

/// Root mean square of what shadows take away from rays, in W/(m²·sr).
fn shadows(lit: &[DVec3], unshadowed: &[DVec3]) -> f64 {
    let taken: f64 = lit.iter().zip(unshadowed).map(|(lit, all)| (*all - *lit).length_squared()).sum();
    let all: f64 = unshadowed.iter().map(|value| value.length_squared()).sum();
    (taken.max(LEAST_SHADOWS * LEAST_SHADOWS * all) / lit.len().max(1) as f64).sqrt()
}

/// 1/z of every pixel, with planar depths z; units: 1/m.
fn planes(camera: &Camera, size: (u32, u32), ends: &[f32]) -> Vec<f64> {
    let forward = camera.forward.as_dvec3();
    let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let of = |((x, y), &end): ((u32, u32), &f32)| {
        1.0 / (f64::from(end) * camera.pixel_ray(x, y, size).direction.dot(forward)).max(1e-30)
    };
    pixels.zip(ends).map(of).collect()
}

/// Where pixels that are interpolated look: to pixels at half the stride on both sides, and in the same lines to those at one
/// and a half. The first and the last of four lie opposite of each other.
const ALONG_ROW: &[(i64, i64)] = &[(-1, 0), (1, 0)];
const ALONG_COLUMN: &[(i64, i64)] = &[(0, -1), (0, 1)];
const DIAGONALS: &[(i64, i64)] = &[(-1, -1), (1, -1), (-1, 1), (1, 1)];

/// A picture, part of which is known.
struct Known {
    size: (u32, u32),
    values: Vec<DVec3>,
    planes: Vec<f64>,
}

impl Known {
    fn set(&mut self, pixels: &[(u32, u32)], values: &[DVec3]) {
        for (&(x, y), &value) in pixels.iter().zip(values) {
            self.values[y as usize * self.size.0 as usize + x as usize] = value;
        }
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let inside = (0..i64::from(self.size.0)).contains(&x) && (0..i64::from(self.size.1)).contains(&y);
        inside.then(|| y as usize * self.size.0 as usize + x as usize)
    }

    /// Interpolates the pixels halfway between those at `stride`, and returns those that are to be traced.
    fn interpolate(&mut self, stride: u32, tolerance: f64) -> Vec<(u32, u32)> {
        let half = stride / 2;
        let mut wanted = Vec::new();
        for y in (0..self.size.1).step_by(stride as usize) {
            for x in (0..self.size.0).step_by(stride as usize) {
                for (dx, dy, around) in
                    [(half, 0, ALONG_ROW), (0, half, ALONG_COLUMN), (half, half, DIAGONALS)]
                {
                    let (x, y) = (x + dx, y + dy);
                    let Some(index) = self.index(x.into(), y.into()) else { continue };
                    match self.predict(x, y, half, around, tolerance) {
                        Some(value) => self.values[index] = value,
                        None => wanted.push((x, y)),
                    }
                }
            }
        }
        wanted
    }

    /// The airlight of a pixel from those around it, if the estimated error is below the tolerance.
    fn predict(&self, x: u32, y: u32, half: u32, around: &[(i64, i64)], tolerance: f64) -> Option<DVec3> {
        let at = |(dx, dy): (i64, i64), times: i64| {
            let reach = times * i64::from(half);
            self.index(i64::from(x) + reach * dx, i64::from(y) + reach * dy)
        };
        let near: Vec<usize> = around.iter().map(|&way| at(way, 1)).collect::<Option<_>>()?;
        let own = self.planes[self.index(x.into(), y.into())?];
        let count = near.len() as f64;
        let mean_of = |pixels: &[usize]| pixels.iter().map(|&i| self.planes[i]).sum::<f64>() / count;
        let plane = mean_of(&near);
        let mut flat = (own - plane).abs() <= SAME_PLANE * own.max(plane);
        if let [a, b, c, d] = near[..] {
            let twist = self.planes[a] + self.planes[d] - self.planes[b] - self.planes[c];
            flat &= twist.abs() <= 2.0 * SAME_PLANE * own;
        }
        if !flat {
            return None;
        }
        let value = |&index: &usize| self.values[index];
        let sum: DVec3 = near.iter().map(value).sum();
        let least = near.iter().map(value).fold(DVec3::INFINITY, DVec3::min);
        let most = near.iter().map(value).fold(DVec3::NEG_INFINITY, DVec3::max);
        let (line, spread) = (sum / count, (most - least).length());
        let far: Option<Vec<usize>> = around.iter().map(|&way| at(way, 3)).collect();
        let far = far.filter(|far| (own - mean_of(far)).abs() <= SAME_PLANE_FAR * own);
        let (prediction, estimate) = match far {
            Some(far) => {
                let cubic = (9.0 * sum - far.iter().map(value).sum::<DVec3>()) / (8.0 * count);
                (cubic.max(DVec3::ZERO), (cubic - line).length().max(SPREAD_OF_CUBIC * spread))
            }
            None => (line, 0.5 * spread),
        };
        (estimate <= tolerance).then_some(prediction)
    }
}
