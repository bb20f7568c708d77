//! Variance shadow maps: two moments of depth, which can be filtered like a picture.
//!
//! After Donnelly and Lauritzen, *Variance Shadow Maps*, 2006; the reduction of light bleeding is that of Lauritzen,
//! *Summed-Area Variance Shadow Maps*, GPU Gems 3, 2007. A lookup is an upper bound of the lit share of the filtered
//! texels, by Chebyshev's inequality; the bound is not tight where occluders overlap, which shows as light bleeding.

use glam::DVec3;

use crate::{DepthMap, MapPoint, Outside, Projection, ProjectionKind, ShadowMapError};

/// Largest radius of a blur; units: texels.
pub const MAX_BLUR: u32 = 64;

/// Smallest variance unless set otherwise: the square of a ten thousandth of `far`.
const LEAST_VARIANCE: f64 = 1e-8;

/// Mean depth and mean squared depth around every texel centre, with depth in units of `far`.
#[derive(Debug, Clone, PartialEq)]
pub struct VarianceMap {
    projection: Projection,
    size: (u32, u32),
    outside: Outside,
    far: f32,
    moments: Vec<[f32; 2]>,
    least_variance: f64,
    bleed: f64,
}

impl VarianceMap {
    /// Moments of a map's texels, not filtered yet; depths beyond `far` metres count as `far`, and so do points.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if `far` is not positive and finite.
    pub fn new(map: &DepthMap, far: f32) -> Result<Self, ShadowMapError> {
        if !(far > 0.0 && far.is_finite()) {
            let valid = "be positive and finite";
            return Err(ShadowMapError::Setting { name: "far", value: far, valid });
        }
        let moments = map.depths().iter().map(|&depth| {
            let depth = depth.min(far) / far;
            [depth, depth * depth]
        });
        Ok(Self {
            projection: map.projection().clone(),
            size: map.size(),
            outside: map.outside(),
            far,
            moments: moments.collect(),
            least_variance: LEAST_VARIANCE,
            bleed: 0.0,
        })
    }

    /// With visibilities below `amount` made 0 and the rest stretched to [0, 1]: less light bleeding, smaller penumbras.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] unless 0 ≤ `amount` < 1.
    pub fn with_bleed_reduction(mut self, amount: f32) -> Result<Self, ShadowMapError> {
        if !(0.0..1.0).contains(&amount) {
            let valid = "lie in [0, 1)";
            return Err(ShadowMapError::Setting { name: "bleed reduction", value: amount, valid });
        }
        self.bleed = f64::from(amount);
        Ok(self)
    }

    /// With a smallest standard deviation of `metres`: hides the rounding of moments, and a surface's own slope.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] unless it is positive and finite.
    pub fn with_least_deviation(mut self, metres: f32) -> Result<Self, ShadowMapError> {
        if !(metres > 0.0 && metres.is_finite()) {
            let valid = "be positive and finite";
            return Err(ShadowMapError::Setting { name: "the least deviation", value: metres, valid });
        }
        self.least_variance = f64::from(metres / self.far).powi(2);
        Ok(self)
    }

    /// Blurred by a square of 2·`radius` + 1 texels a side; beyond a face's edge its outermost texels go on.
    ///
    /// # Errors
    /// [`ShadowMapError::Setting`] if the radius is larger than [`MAX_BLUR`].
    pub fn blurred(mut self, radius: u32) -> Result<Self, ShadowMapError> {
        if radius > MAX_BLUR {
            let valid = "be 0 to 64 texels";
            return Err(ShadowMapError::Setting { name: "the blur's radius", value: radius as f32, valid });
        }
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        for face in self.moments.chunks_exact_mut(width * height) {
            blur_rows(face, width, radius as usize);
            let mut columns = transposed(face, width, height);
            blur_rows(&mut columns, height, radius as usize);
            face.copy_from_slice(&transposed(&columns, height, width));
        }
        Ok(self)
    }

    /// The moments, row-major, face after face: mean and mean square of depth/`far`.
    pub fn moments(&self) -> &[[f32; 2]] {
        &self.moments
    }

    /// Depth of 1; units: m.
    pub fn far(&self) -> f32 {
        self.far
    }

    /// Smallest variance that a lookup counts with, in units of `far` squared.
    pub fn least_variance(&self) -> f32 {
        self.least_variance as f32
    }

    /// Visibility below which a lookup is dark.
    pub fn bleed_reduction(&self) -> f32 {
        self.bleed as f32
    }

    /// Memory; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.moments)
    }

    /// Upper bound of the visibility of the light from a point, in [0, 1]; moments are interpolated bilinearly between
    /// texel centres, within a face.
    pub fn visibility(&self, point: DVec3) -> f32 {
        let Some(at) = self.projection.locate(point, self.size) else {
            let lit = self.projection.kind() == ProjectionKind::Cube || self.outside == Outside::Lit;
            return f32::from(u8::from(lit));
        };
        let [mean, square] = self.sample(at);
        let depth = (at.depth / f64::from(self.far)).min(1.0);
        if depth <= mean {
            return 1.0;
        }
        let variance = (square - mean * mean).max(self.least_variance);
        let bound = variance / (variance + (depth - mean).powi(2));
        ((bound - self.bleed) / (1.0 - self.bleed)).max(0.0) as f32
    }

    fn sample(&self, at: MapPoint) -> [f64; 2] {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let face = &self.moments[at.face * width * height..(at.face + 1) * width * height];
        let split = |x: f64, count: usize| {
            let x = (x - 0.5).clamp(0.0, count as f64 - 1.0);
            (x as usize, (x as usize + 1).min(count - 1), x.fract())
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (split(at.u, width), split(at.v, height));
        [0, 1].map(|moment| {
            let read = |x: usize, y: usize| f64::from(face[y * width + x][moment]);
            let row = |y: usize| read(x0, y) + fx * (read(x1, y) - read(x0, y));
            row(y0) + fy * (row(y1) - row(y0))
        })
    }
}

fn transposed(values: &[[f32; 2]], width: usize, height: usize) -> Vec<[f32; 2]> {
    (0..width * height).map(|i| values[(i % height) * width + i / height]).collect()
}

/// Box blur along rows; sums run in `f64`, so that no rounding builds up along a row.
fn blur_rows(values: &mut [[f32; 2]], width: usize, radius: usize) {
    let (r, last) = (radius as isize, width as isize - 1);
    let mut blurred = vec![[0.0_f32; 2]; width];
    for row in values.chunks_exact_mut(width) {
        let at = |x: isize| row[x.clamp(0, last) as usize].map(f64::from);
        let mut sum = (-r..=r).map(at).fold([0.0, 0.0], |s, m| [s[0] + m[0], s[1] + m[1]]);
        for (x, out) in blurred.iter_mut().enumerate() {
            *out = sum.map(|s| (s / (2 * radius + 1) as f64) as f32);
            let (enter, leave) = (at(x as isize + r + 1), at(x as isize - r));
            sum = [sum[0] + enter[0] - leave[0], sum[1] + enter[1] - leave[1]];
        }
        row.copy_from_slice(&blurred);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn map(size: (u32, u32), depths: Vec<f32>) -> DepthMap {
        let projection = Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        DepthMap::new(projection, size, depths).unwrap()
    }

    #[test]
    fn chebyshev_by_hand() {
        // half the texels at 2 m, half at 6 m: mean 4 m, variance 4 m²
        let depths = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 2.0 } else { 6.0 }).collect();
        let moments = VarianceMap::new(&map((8, 8), depths), 10.0).unwrap();
        // in the middle of four texels the checkerboard averages out
        let at = |depth: f64| DVec3::new(0.0, 0.0, -depth);
        assert_eq!(moments.visibility(at(3.9)), 1.0);
        let bound = 4.0 / (4.0 + 4.0);
        assert!((f64::from(moments.visibility(at(6.0))) - bound).abs() < 1e-6);
        let reduced = moments.clone().with_bleed_reduction(0.2).unwrap();
        assert!((f64::from(reduced.visibility(at(6.0))) - (bound - 0.2) / 0.8).abs() < 1e-6);
        assert_eq!(reduced.visibility(at(9.9)), 0.0);
        // infinitely far counts as far
        assert_eq!(moments.visibility(at(1e9)), moments.visibility(at(10.0)));
        let empty = VarianceMap::new(&map((2, 2), vec![f32::INFINITY; 4]), 10.0).unwrap();
        assert_eq!(empty.visibility(at(1e9)), 1.0);
        assert_eq!(empty.visibility(DVec3::new(9.0, 0.0, 0.0)), 1.0);
    }

    #[test]
    fn a_flat_wall_is_sharp() {
        let moments = VarianceMap::new(&map((4, 4), vec![5.0; 16]), 10.0).unwrap();
        let at = |depth: f64| moments.visibility(DVec3::new(0.3, -0.2, -depth));
        assert!(at(4.999) == 1.0 && at(5.1) < 0.02 && at(6.0) < 2e-4, "{} {}", at(5.1), at(6.0));
        let soft = moments.clone().with_least_deviation(0.1).unwrap();
        assert!((f64::from(soft.visibility(DVec3::new(0.0, 0.0, -5.1))) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn blur_keeps_the_mean_and_spreads_a_texel() {
        let mut depths = vec![0.0; 49];
        depths[24] = 9.0;
        let moments = VarianceMap::new(&map((7, 7), depths), 9.0).unwrap().blurred(1).unwrap();
        for (i, &[mean, square]) in moments.moments().iter().enumerate() {
            let near = (2..5).contains(&(i % 7)) && (2..5).contains(&(i / 7));
            let expected = if near { 1.0 / 9.0 } else { 0.0 };
            assert!((mean - expected).abs() < 1e-7 && (square - expected).abs() < 1e-7, "{i}: {mean}");
        }
        // rows and columns are not mixed up
        let wide = VarianceMap::new(&map((3, 2), vec![1.0, 1.0, 1.0, 4.0, 4.0, 4.0]), 4.0).unwrap();
        let blurred = wide.blurred(1).unwrap();
        let means: Vec<f32> = blurred.moments().iter().map(|m| 4.0 * m[0]).collect();
        assert!(means.iter().zip([2.0, 2.0, 2.0, 3.0, 3.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn nonsense_is_refused() {
        let one = || VarianceMap::new(&map((1, 1), vec![1.0]), 2.0).unwrap();
        for far in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(VarianceMap::new(&map((1, 1), vec![1.0]), far).is_err());
            assert!(one().with_least_deviation(far).is_err());
        }
        assert!(one().with_bleed_reduction(1.0).is_err() && one().with_bleed_reduction(f32::NAN).is_err());
        assert!(one().blurred(65).is_err());
    }
}
