//! Airlight of every pixel from that of few: view rays are traced where the picture changes.
//!
//! Airlight is smooth over a picture but for depth edges, the borders of shafts and the glow around a light. So a coarse
//! lattice of rays is traced first, and its spacing halved again and again. A pixel halfway between pixels that are known
//! is predicted from them, with an estimate of the error:
//!
//! - where its own depth and those around it lie on one plane, within 2 %, the prediction is a cubic through the next pixels
//!   in line, and the estimate how far it is from the straight line; the straight line where the next pixels lie on another
//!   plane, and where all values around are as good as equal. The inverse depth is linear across the picture of a plane, so
//!   the test knows slopes from edges;
//! - beside a depth edge, a pixel as deep as one of those around it, or between them, has a mean of their airlight that
//!   leans to those of its own depth, and half of their spread as estimate: airlight grows along a ray, so that one
//!   that ends between two others has a value between theirs;
//! - everything else is traced.
//!
//! What is traced beside that follows from a budget. The target error is a share of what shadows take away in the picture,
//! known as root mean square from the lattice; that many squares of estimates, each for as many pixels as it stands for, may add
//! up. A histogram of the estimates of each level says up to which of them its share of the budget reaches; where that leaves
//! most of its pixels, all of them are traced. No ray is traced twice, and no sample is random.
//!
//! Estimates see what four rays around a pixel see. What slips through between rays that agree they do not: shafts thinner
//! than the lattice. The budget is smaller than the target for that, the more so for small targets and small pictures, and
//! pictures stay below the target unless most of their shafts are that thin.

use glam::DVec3;
use thiserror::Error;

mod budget;
mod prediction;

use budget::Budget;
use prediction::Known;

pub use budget::AdaptiveLevel;

/// Largest distance of the first rays; units: pixels.
const MOST_SPACING: u32 = 16;

/// Errors are so many times as large, over a picture, as their estimates: in pictures from this side on, and for this target.
/// Measured on 29 set-ups: what nearly all of them are below.
const ERROR_PER_ESTIMATE: f64 = 5.2;
const USUAL_SIDE: f64 = 1024.0;
const USUAL_TARGET: f64 = 0.002;
const GROWTH_WITH_TARGET: f64 = 0.3;

/// The largest estimate that is accepted, in units of the target error: in pictures from the usual side on, less in smaller
/// ones, of which more lies beside borders.
const MOST_ESTIMATE: f64 = 4.0;

/// Four known values that differ by so many times the root of the budget, over the stride they leave, are as good as equal.
const EQUAL: f64 = 1.6;

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

    /// Mean square that estimated errors may have over a picture of `size` (width, height), in units of the square of the
    /// target error.
    pub fn budget(&self, (width, height): (u32, u32)) -> f64 {
        let (target, side) = (f64::from(self.target_error), f64::from(width.min(height)));
        let growth = (USUAL_TARGET / target).powf(GROWTH_WITH_TARGET) * (USUAL_SIDE / side).sqrt();
        (ERROR_PER_ESTIMATE * growth).powi(-2)
    }

    /// The largest estimated error that is accepted in a picture of `size` (width, height), whatever the budget; in units of the
    /// target error.
    pub fn most_estimate(&self, (width, height): (u32, u32)) -> f64 {
        MOST_ESTIMATE * (f64::from(width.min(height)) / USUAL_SIDE).min(1.0)
    }

    /// The levels of a picture of `size` (width, height), the coarsest first.
    pub fn levels(&self, size: (u32, u32)) -> impl Iterator<Item = AdaptiveLevel> + use<> {
        let strides = std::iter::successors(Some(self.spacing), |stride| Some(stride / 2));
        strides.take_while(|&stride| stride > 1).map(move |stride| AdaptiveLevel::new(stride, size))
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
        size: (u32, u32),
        ends: &[f32],
        mut airlight: impl FnMut(&[(u32, u32)]) -> Vec<DVec3>,
        mut unshadowed: impl FnMut(&[(u32, u32)]) -> Vec<DVec3>,
    ) -> Result<(Vec<DVec3>, u64), AdaptiveError> {
        let whole = [Tile { size, ends }];
        let mut found =
            self.tiles(size, &whole, |_, pixels| airlight(pixels), |_, pixels| unshadowed(pixels))?;
        Ok((std::mem::take(&mut found.pictures[0]), found.traced))
    }

    /// The same of tiles of a picture of size `whole`: what sampling would err by and trace, from parts of it. The budget is that
    /// of the whole picture, for as many pixels as the tiles have, and they share it. The functions are told which tile it is.
    ///
    /// # Errors
    /// [`AdaptiveError`] for settings without meaning, and if there is not one end for each pixel of a tile.
    pub fn tiles(
        &self,
        whole: (u32, u32),
        tiles: &[Tile<'_>],
        mut airlight: impl FnMut(usize, &[(u32, u32)]) -> Vec<DVec3>,
        mut unshadowed: impl FnMut(usize, &[(u32, u32)]) -> Vec<DVec3>,
    ) -> Result<Tiles, AdaptiveError> {
        self.check()?;
        for Tile { size, ends } in tiles {
            let expected = size.0 as usize * size.1 as usize;
            if ends.len() != expected {
                return Err(AdaptiveError::Ends { expected, got: ends.len() });
            }
        }
        let lattices: Vec<_> = tiles.iter().map(|tile| self.lattice(tile.size)).collect();
        let mut known: Vec<Known> = tiles.iter().map(|tile| Known::new(tile.size, tile.ends)).collect();
        let (mut lit, mut open) = (Vec::new(), Vec::new());
        for (index, lattice) in lattices.iter().enumerate() {
            let found = airlight(index, lattice);
            known[index].set(lattice, &found);
            lit.extend(found);
            open.extend(unshadowed(index, lattice));
        }
        let mut traced = lit.len() as u64;
        let pixels: usize = tiles.iter().map(|tile| tile.ends.len()).sum();
        let unit = f64::from(self.target_error) * shadows(&lit, &open);
        let mean = self.budget(whole);
        let mut budget = Budget::new(unit, mean * pixels as f64, self.most_estimate(whole));
        for level in self.levels(whole) {
            // groups are counted from the corner of a picture
            let level = if tiles.len() > 1 { AdaptiveLevel { survey: 1, ..level } } else { level };
            let equal = EQUAL * mean.sqrt() * unit / f64::from(level.stride / 2);
            let predictions: Vec<_> = known.iter().map(|tile| tile.predict(level.stride, equal)).collect();
            let tolerance = budget.tolerance(&level, predictions.iter().flatten());
            for (index, (tile, predictions)) in known.iter_mut().zip(&predictions).enumerate() {
                let wanted = tile.take(predictions, tolerance);
                tile.set(&wanted, &airlight(index, &wanted));
                traced += wanted.len() as u64;
            }
        }
        Ok(Tiles { pictures: known.into_iter().map(|tile| tile.values).collect(), traced })
    }

    /// The first pixels of a picture that are traced.
    fn lattice(&self, (width, height): (u32, u32)) -> Vec<(u32, u32)> {
        let rows = (0..height).step_by(self.spacing as usize);
        rows.flat_map(|y| (0..width).step_by(self.spacing as usize).map(move |x| (x, y))).collect()
    }
}

/// A part of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Tile<'a> {
    /// Width and height; units: pixels.
    pub size: (u32, u32),
    /// Where the pixels' rays end, row-major; infinite where they meet nothing; units: m.
    pub ends: &'a [f32],
}

/// Tiles whose airlight is known from few rays.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Tiles {
    /// The radiance of each tile's pixels, row-major; units: W/(m²·sr).
    pub pictures: Vec<Vec<DVec3>>,
    /// How many rays were traced, in all of them.
    pub traced: u64,
}

/// Root mean square of what shadows take away from rays, in W/(m²·sr).
fn shadows(lit: &[DVec3], unshadowed: &[DVec3]) -> f64 {
    let taken: f64 = lit.iter().zip(unshadowed).map(|(lit, all)| (*all - *lit).length_squared()).sum();
    let all: f64 = unshadowed.iter().map(|value| value.length_squared()).sum();
    (taken.max(LEAST_SHADOWS * LEAST_SHADOWS * all) / lit.len().max(1) as f64).sqrt()
}
