//! A spot light's picture at every size, so that a step of a march sees only the frequencies that it can resolve.
//!
//! (Wyman and Ramsey 2008, section 3.3): coarse steps undersample a fine picture. A blurred picture hides that at the
//! cost of its detail; a chain of ever smaller ones lets each step choose, by how long its own part of the picture is.
//! What is lost is blur across the ray's own line, never brightness.

use glam::DVec3;
use scene::{LightTexture, TextureFilter};

/// Samples that [`LightMips::line`] takes along a segment.
const TAPS: u32 = 4;

/// A light's picture, and smaller copies of it down to a single texel.
///
/// Level 0 is the picture, or a blurred one of its size. Each further level has half the width and height, rounded down
/// and 1 at least, as a GPU's mips have;
/// its texels are the mean of what they cover, by area, so that all levels have the same mean and the coordinates
/// (u, v) mean the same point of each.
#[derive(Debug, Clone, PartialEq)]
pub struct LightMips {
    levels: Vec<Level>,
    /// How level 0 is read.
    filter: TextureFilter,
}

/// One size of a light's picture: linear RGB factors, row 0 at the top, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Width; units: texels.
    pub width: u32,
    /// Height; units: texels.
    pub height: u32,
    /// `width`·`height` texels.
    pub texels: Vec<[f32; 3]>,
}

impl LightMips {
    /// The chain of `texture`, whose level 0 is first blurred by a Gaussian of `blur` texels' standard deviation.
    ///
    /// A `blur` of 0, or one that is no positive number, leaves the picture as it is. The blur takes edge texels to go
    /// on outside, and ends at three deviations or the picture's longer side.
    pub fn new(texture: &LightTexture, blur: f32) -> Self {
        let picture = Level { width: texture.width, height: texture.height, texels: texture.texels.clone() };
        let mut levels = vec![if blur > 0.0 { picture.blurred(f64::from(blur)) } else { picture }];
        while let Some(half) = levels.last().and_then(Level::halved) {
            levels.push(half);
        }
        Self { levels, filter: texture.filter }
    }

    /// All levels, the largest first and one of 1 × 1 texel last: what a GPU uploads.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Colour at (`u`, `v`), clamped to the edge texels outside [0, 1], at a level between two of the chain's.
    ///
    /// Linear between levels and bilinear within them, but for level 0 of a picture with [`TextureFilter::Nearest`].
    /// Levels beyond the chain are its first and last.
    pub fn sample(&self, u: f64, v: f64, level: f64) -> DVec3 {
        let last = self.levels.len() - 1;
        // also 0 for what is no number
        let level = level.max(0.0).min(last as f64);
        let fine = level as usize;
        let at_fine = self.at(fine, u, v);
        let between = level - fine as f64;
        if between > 0.0 { at_fine.lerp(self.at((fine + 1).min(last), u, v), between) } else { at_fine }
    }

    /// Mean colour along the segment between two points of the picture, each clamped to it.
    ///
    /// Four samples share the segment, at the level whose texels are as long as their shares, or at level 0 for
    /// shorter ones: level = log₂ max(n/4, 1) for a segment of n texels.
    pub fn line(&self, (u0, v0): (f64, f64), (u1, v1): (f64, f64)) -> DVec3 {
        // a point on the cone's very edge may be rounded to one far outside, or to none
        let inside = |x: f64| if x > 0.0 { x.min(1.0) } else { 0.0 };
        let (u0, v0, u1, v1) = (inside(u0), inside(v0), inside(u1), inside(v1));
        let (du, dv) = (u1 - u0, v1 - v0);
        let picture = &self.levels[0];
        let texels = (du * f64::from(picture.width)).hypot(dv * f64::from(picture.height));
        let taps = f64::from(TAPS);
        let level = (texels / taps).max(1.0).log2();
        let tap = |i: u32| {
            let t = (f64::from(i) + 0.5) / taps;
            self.sample(u0 + t * du, v0 + t * dv, level)
        };
        (0..TAPS).map(tap).sum::<DVec3>() / taps
    }

    fn at(&self, level: usize, u: f64, v: f64) -> DVec3 {
        let nearest = level == 0 && self.filter == TextureFilter::Nearest;
        let level = &self.levels[level];
        if nearest { level.nearest(u, v) } else { level.bilinear(u, v) }
    }
}

impl Level {
    /// The texel that holds `x` and `y`, in texels, or the nearest one.
    fn texel(&self, x: f64, y: f64) -> DVec3 {
        // saturating: the cast of a negative number is 0
        let (x, y) = ((x as usize).min(self.width as usize - 1), (y as usize).min(self.height as usize - 1));
        DVec3::from_array(self.texels[y * self.width as usize + x].map(f64::from))
    }

    fn nearest(&self, u: f64, v: f64) -> DVec3 {
        self.texel(u * f64::from(self.width), v * f64::from(self.height))
    }

    fn bilinear(&self, u: f64, v: f64) -> DVec3 {
        let (x, y) = (u * f64::from(self.width) - 0.5, v * f64::from(self.height) - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let row = |y: f64| self.texel(x0, y).lerp(self.texel(x0 + 1.0, y), x - x0);
        row(y0).lerp(row(y0 + 1.0), y - y0)
    }

    /// The next smaller level; `None` after a single texel.
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (across, down) = (shares(self.width), shares(self.height));
        let narrow = self.filtered(half(self.width), self.height, |x, y| {
            across[x].iter().map(|&(from, weight)| weight * self.at(from, y)).sum()
        });
        let low = narrow.filtered(narrow.width, half(self.height), |x, y| {
            down[y].iter().map(|&(from, weight)| weight * narrow.at(x, from)).sum()
        });
        Some(low)
    }

    /// A separable Gaussian of standard deviation `sigma` in texels.
    fn blurred(&self, sigma: f64) -> Self {
        let reach = (3.0 * sigma).ceil().min(f64::from(self.width.max(self.height))) as isize;
        let weights: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let taps = || (-reach..=reach).zip(weights.iter().map(|weight| weight / total));
        let moved = |x: usize, by: isize, side: u32| x.saturating_add_signed(by).min(side as usize - 1);
        let across = self.filtered(self.width, self.height, |x, y| {
            taps().map(|(by, weight)| weight * self.at(moved(x, by, self.width), y)).sum()
        });
        across.filtered(self.width, self.height, |x, y| {
            taps().map(|(by, weight)| weight * across.at(x, moved(y, by, self.height))).sum()
        })
    }

    fn at(&self, x: usize, y: usize) -> DVec3 {
        DVec3::from_array(self.texels[y * self.width as usize + x].map(f64::from))
    }

    /// A level of a given size, texel by texel.
    fn filtered(&self, width: u32, height: u32, texel: impl Fn(usize, usize) -> DVec3) -> Self {
        let rows = (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (x, y)));
        let texels = rows.map(|(x, y)| texel(x, y).as_vec3().to_array()).collect();
        Self { width, height, texels }
    }
}

/// A side of the next smaller level.
fn half(side: u32) -> u32 {
    (side / 2).max(1)
}

/// For each of half as many texels, rounded down, the texels of a side that it covers, and by which share of itself.
fn shares(side: u32) -> Vec<Vec<(usize, f64)>> {
    let count = half(side);
    let width = f64::from(side) / f64::from(count);
    let covered = |i: u32| {
        let (start, end) = (f64::from(i) * width, f64::from(i + 1) * width);
        (start as u32..(end.ceil() as u32).min(side))
            .map(|from| {
                let overlap = end.min(f64::from(from) + 1.0) - start.max(f64::from(from));
                (from as usize, overlap / width)
            })
            // what rounding leaves of a neighbour that is not covered is not worth a read
            .filter(|&(_, share)| share > 1e-9)
            .collect()
    };
    (0..count).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32, filter: TextureFilter) -> LightTexture {
        let texels = (0..width * height)
            .map(|i| {
                let t = i as f32;
                [(0.7 * t).sin().abs(), ((i * 7) % 5) as f32, if i % 3 == 0 { 9.0 } else { 0.0 }]
            })
            .collect();
        LightTexture::new(width, height, texels, filter).unwrap()
    }

    fn mean(level: &Level) -> DVec3 {
        let sum: DVec3 = level.texels.iter().map(|t| DVec3::from_array(t.map(f64::from))).sum();
        sum / level.texels.len() as f64
    }

    #[test]
    fn five_texels_become_two_by_area() {
        // texels of 2.5: the middle one is shared
        let colours = [[3.0; 3], [6.0; 3], [8.0; 3], [0.0; 3], [1.0; 3]];
        let picture = LightTexture::new(5, 1, colours.to_vec(), TextureFilter::Linear).unwrap();
        let mips = LightMips::new(&picture, 0.0);
        assert_eq!(mips.levels().len(), 3);
        let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert!(close(mips.levels()[1].texels[0][0], 5.2) && close(mips.levels()[1].texels[1][0], 2.0));
        assert!(close(mips.levels()[2].texels[0][0], 3.6));
    }

    #[test]
    fn every_level_has_the_pictures_mean() {
        for (width, height) in [(1, 1), (8, 8), (7, 5), (13, 1), (1, 6), (33, 17)] {
            let mips = LightMips::new(&texture(width, height, TextureFilter::Linear), 0.0);
            let whole = mean(&mips.levels()[0]);
            let mut side = width.max(height);
            for level in mips.levels() {
                assert!((mean(level) - whole).abs().max_element() < 2e-6 * whole.max_element());
                assert_eq!(level.width.max(level.height), side);
                side = half(side);
            }
            let last = mips.levels().last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
        }
    }

    #[test]
    fn level_0_reads_as_the_texture_does() {
        for filter in [TextureFilter::Nearest, TextureFilter::Linear] {
            let picture = texture(9, 6, filter);
            let mips = LightMips::new(&picture, 0.0);
            for i in 0..200 {
                let t = f64::from(i);
                let (u, v) = (0.5 + 0.8 * (1.3 * t).sin(), 0.5 + 0.8 * (0.9 * t).cos());
                for level in [0.0, -3.0, f64::NAN] {
                    assert_eq!(mips.sample(u, v, level), picture.sample(u, v), "{filter:?} at {u}, {v}");
                }
            }
        }
    }

    #[test]
    fn levels_blend_into_each_other() {
        let mips = LightMips::new(&texture(16, 16, TextureFilter::Nearest), 0.0);
        let (u, v) = (0.31, 0.62);
        let [one, two] = [1.0, 2.0].map(|level| mips.sample(u, v, level));
        assert!((mips.sample(u, v, 1.25) - one.lerp(two, 0.25)).abs().max_element() < 1e-12);
        assert!(one != two);
        // beyond the last level there is only the mean
        for level in [4.0, 40.0, f64::INFINITY] {
            let error = mips.sample(u, v, level) - mean(&mips.levels()[0]);
            assert!(error.abs().max_element() < 1e-5, "{level}: {error}");
        }
    }

    #[test]
    fn a_line_is_the_mean_along_it() {
        // a ramp across: any segment's mean is the ramp at its middle
        let side = 64;
        let texels = (0..side * side).map(|i| [(i % side) as f32; 3]).collect();
        let ramp =
            LightMips::new(&LightTexture::new(side, side, texels, TextureFilter::Linear).unwrap(), 0.0);
        for (from, to) in [(0.3, 0.31), (0.3, 0.5), (0.2, 0.8)] {
            let exact = 0.5 * (from + to) * 64.0 - 0.5;
            let got = ramp.line((from, 0.2), (to, 0.9)).x;
            assert!((got - exact).abs() < 1e-3 * exact, "{from} to {to}: {got}, not {exact}");
        }
        // stripes along the way: a long line must not catch some and miss others
        let texels = (0..side * side).map(|i| [(2 * (i % side % 2)) as f32; 3]).collect();
        let stripes = LightTexture::new(side, side, texels, TextureFilter::Nearest).unwrap();
        let stripes = LightMips::new(&stripes, 0.0);
        for i in 0..50 {
            let from = 0.15 + 0.003 * f64::from(i);
            let got = stripes.line((from, 0.4), (from + 0.5, 0.45)).x;
            assert!((got - 1.0).abs() < 0.02, "from {from}: {got}");
        }
    }

    #[test]
    fn a_line_of_no_numbers_is_a_colour_all_the_same() {
        let mips = LightMips::new(&texture(8, 4, TextureFilter::Linear), 0.0);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(mips.line((bad, 0.5), (0.3, bad)).is_finite());
            assert!(mips.sample(0.5, 0.5, bad).is_finite());
        }
    }

    #[test]
    fn blur_keeps_the_mean_and_widens_a_dot() {
        let side = 31;
        let mut texels = vec![[0.0; 3]; side * side];
        texels[15 * side + 15] = [1.0; 3];
        let dot = LightTexture::new(31, 31, texels, TextureFilter::Linear).unwrap();
        let mips = LightMips::new(&dot, 2.0);
        let blurred = &mips.levels()[0];
        let (mut sum, mut square) = (0.0, 0.0);
        for (i, texel) in blurred.texels.iter().enumerate() {
            let x = (i % side) as f64 - 15.0;
            sum += f64::from(texel[0]);
            square += f64::from(texel[0]) * x * x;
        }
        // three deviations hold 97 % of a Gaussian's second moment
        assert!((sum - 1.0).abs() < 1e-5 && (square / sum / 4.0 - 0.97).abs() < 0.02, "{sum} {square}");
        for nothing in [0.0, -1.0, f32::NAN] {
            assert_eq!(LightMips::new(&dot, nothing).levels()[0].texels, dot.texels);
        }
        assert!(mean(&LightMips::new(&dot, f32::INFINITY).levels()[0]).is_finite());
    }
}
