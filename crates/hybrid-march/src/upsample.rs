//! Airlight at a fraction of the resolution, and its way back to every pixel.
//!
//! (Wyman and Ramsey 2008, section 3.3): single scattering is smooth across a picture except where surfaces end, so
//! it is computed for blocks of pixels and spread over them by a bilateral filter that looks at depth.
//!
//! A block of `scale` × `scale` pixels has one view ray, through its centre, and two ends on it: that of its nearest
//! and that of its farthest pixel, so that a block which holds the edge of a surface knows the airlight before it and
//! the airlight before what lies behind. The far one is left out where both are as good as one.
//!
//! Each pixel then takes the 3 × 3 blocks around its own, each with the layer whose depth is closer to the pixel's,
//! and weights them by two factors:
//!
//! - *place*: the tent max(0, 1 − |dx|)·max(0, 1 − |dy|), with the distance from the pixel to the block's centre in
//!   blocks. It is bilinear interpolation, which keeps a linear ramp exactly, and a scale of 1 as it is. Gaussians,
//!   the paper's choice, err more: by 4 % at a standard deviation of half a block, by 20 % at 0.7 and by 45 % at 1
//!   (slats and sphere, a quarter and half of the resolution).
//! - *depth*: 1/(1 + (r/0.05)²)² with r = 1 − min(z, z′)/max(z, z′), the difference of the two depths as a share of
//!   the larger. An infinite depth needs no case of its own, and the weight is never 0, so neither is the sum.
//!
//! Depth here is planar: z = end/t, where t is the length of the pixel's vector (tₓ, t_y, 1) in the camera's axes,
//! tₓ = (2 pₓ/width − 1) tan(fov/2) width/height and t_y = (1 − 2 p_y/height) tan(fov/2). One surface that faces the
//! camera then has one depth, whichever of its rays is asked.
//!
//! Next to a light in view airlight grows like 1/h, the distance of the ray from it, and no kernel over blocks follows
//! that: there the low resolution shows.
//!
//! A thread of a GPU takes one block: it reads the 9 blocks with both their layers once, then writes its pixels.

use glam::{DVec2, DVec3, Vec3};
use scene::{Camera, DRay};
use thiserror::Error;

/// Depths that differ by less than this share are one: the block has a near layer only.
const SAME_DEPTH: f64 = 0.02;

/// Share of a depth at which the depth weight has fallen to a quarter.
const DEPTH_TOLERANCE: f64 = 0.05;

/// Difference of depths, in units of [`DEPTH_TOLERANCE`], and ratio of a block's two depths from which on there is an edge
/// and no slope.
const EDGE: f64 = 2.0;
const LAYERS_APART: f64 = 1.25;

/// Pixels beside which an edge counts, up to two away.
const AROUND: [(i32, i32); 12] =
    [(1, 0), (-1, 0), (0, 1), (0, -1), (2, 0), (-2, 0), (0, 2), (0, -2), (1, 1), (-1, 1), (1, -1), (-1, -1)];

/// Largest scale: wider blocks than this have nothing to do with their pixels any more.
const MAX_SCALE: u32 = 64;

/// A picture of airlight whose pixels are blocks of another's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LowResolution {
    size: (u32, u32),
    scale: u32,
}

/// What [`LowResolution`] cannot work with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum LowResolutionError {
    /// The scale is out of range.
    #[error("the scattering scale must be from 1 to {MAX_SCALE}, got {0}")]
    Scale(u32),
    /// An array does not have a value for each of its picture's pixels.
    #[error("{array} must have {expected} values, got {got}")]
    Length {
        /// Which array.
        array: &'static str,
        /// Pixels, or blocks.
        expected: usize,
        /// Values.
        got: usize,
    },
}

/// A block as its neighbours see it.
#[derive(Clone, Copy)]
struct Block {
    /// Centre; units: pixels.
    center: DVec2,
    /// Planar depths of the two layers; units: m.
    depths: [f64; 2],
    /// Radiance of the two layers.
    layers: [DVec3; 2],
}

impl LowResolution {
    /// Blocks of `scale` × `scale` pixels of a picture of `size` (width, height); those at the right and the bottom
    /// may be cut off.
    ///
    /// # Errors
    /// [`LowResolutionError::Scale`] unless `scale` is from 1 to 64.
    pub fn new(size: (u32, u32), scale: u32) -> Result<Self, LowResolutionError> {
        if (1..=MAX_SCALE).contains(&scale) {
            Ok(Self { size, scale })
        } else {
            Err(LowResolutionError::Scale(scale))
        }
    }

    /// Width and height in blocks.
    pub fn low_size(&self) -> (u32, u32) {
        (self.size.0.div_ceil(self.scale), self.size.1.div_ceil(self.scale))
    }

    /// The view ray through the centre of the block in column `x` and row `y`; of a cut-off block, where its centre
    /// would be if it were whole.
    pub fn low_ray(&self, camera: &Camera, x: u32, y: u32) -> DRay {
        camera.ray(self.center(x, y), self.size)
    }

    /// Where the blocks' rays end, from where the pixels' rays do: the near and the far layer.
    ///
    /// `full_ends` holds each pixel's ray end in m, row-major, infinite where it meets nothing. A block's ends lie on
    /// its own ray at the planar depths of its nearest and its farthest pixel. The far end is 0, and that layer needs
    /// no airlight, where both depths are within 2 %.
    ///
    /// # Errors
    /// [`LowResolutionError::Length`] if there is not one end for each pixel.
    pub fn ends(&self, camera: &Camera, full_ends: &[f32]) -> Result<[Vec<f32>; 2], LowResolutionError> {
        check("full_ends", full_ends.len(), self.size)?;
        let (columns, rows) = self.low_size();
        let (mut near, mut far) = (Vec::new(), Vec::new());
        for (x, y) in grid((columns, rows)) {
            let (mut nearest, mut farthest) = (f64::INFINITY, 0.0_f64);
            for (px, py) in self.pixels(x, y) {
                let depth = self.depth(camera, full_ends, px, py);
                (nearest, farthest) = (nearest.min(depth), farthest.max(depth));
            }
            let stretch = self.stretch(camera, self.center(x, y));
            let one = farthest <= nearest * (1.0 + SAME_DEPTH);
            near.push((nearest * stretch) as f32);
            far.push(if one { 0.0 } else { (farthest * stretch) as f32 });
        }
        Ok([near, far])
    }

    /// The radiance of every pixel, from that of the blocks.
    ///
    /// `full_ends` are the pixels' ray ends and `low_ends` what [`LowResolution::ends`] made of them, in m; `layers`
    /// are the radiances that rays to the two low ends see, one a block. The far layer is not read where its end is 0.
    ///
    /// # Errors
    /// [`LowResolutionError::Length`] if an array does not have one value for each pixel or block.
    pub fn upsample(
        &self,
        camera: &Camera,
        full_ends: &[f32],
        low_ends: [&[f32]; 2],
        layers: [&[Vec3]; 2],
    ) -> Result<Vec<Vec3>, LowResolutionError> {
        check("full_ends", full_ends.len(), self.size)?;
        for layer in 0..2 {
            check("low_ends", low_ends[layer].len(), self.low_size())?;
            check("layers", layers[layer].len(), self.low_size())?;
        }
        let mut picture = vec![Vec3::ZERO; full_ends.len()];
        for (x, y) in grid(self.low_size()) {
            let around = self.around(camera, low_ends, layers, x, y);
            for (px, py) in self.pixels(x, y) {
                let depth = self.depth(camera, full_ends, px, py);
                let value = self.blend(around.iter().flatten(), pixel_center(px, py), depth);
                picture[px as usize + self.size.0 as usize * py as usize] = value.as_vec3();
            }
        }
        Ok(picture)
    }

    /// Which pixels lie beside a depth edge, where the airlight of either side may change within a block: they are best
    /// computed by themselves. One a pixel, row-major.
    ///
    /// # Errors
    /// As [`LowResolution::upsample`].
    pub fn edges(
        &self,
        camera: &Camera,
        full_ends: &[f32],
        low_ends: [&[f32]; 2],
    ) -> Result<Vec<bool>, LowResolutionError> {
        check("full_ends", full_ends.len(), self.size)?;
        check("low_ends", low_ends[0].len(), self.low_size())?;
        check("low_ends", low_ends[1].len(), self.low_size())?;
        let black = vec![Vec3::ZERO; low_ends[0].len()];
        let mut edges = vec![false; full_ends.len()];
        for (x, y) in grid(self.low_size()) {
            let around = self.around(camera, low_ends, [&black, &black], x, y);
            for (px, py) in self.pixels(x, y) {
                let depth = self.depth(camera, full_ends, px, py);
                let pixel = pixel_center(px, py);
                edges[px as usize + self.size.0 as usize * py as usize] = self.beside_edge(full_ends, px, py)
                    && around.iter().flatten().any(|block| {
                        let [near, far] = block.depths;
                        let apart = difference(depth, near).min(difference(depth, far));
                        self.place(pixel, block) > 0.0
                            && (apart > EDGE * DEPTH_TOLERANCE || far > LAYERS_APART * near)
                    });
            }
        }
        Ok(edges)
    }

    /// Whether the rays around a pixel, up to two pixels away, end at other distances.
    fn beside_edge(&self, full_ends: &[f32], x: u32, y: u32) -> bool {
        let end = |x: u32, y: u32| f64::from(full_ends[x as usize + self.size.0 as usize * y as usize]);
        AROUND.iter().any(|&(dx, dy)| {
            let (Some(ax), Some(ay)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
                return false;
            };
            let inside = ax < self.size.0 && ay < self.size.1;
            inside && difference(end(x, y), end(ax, ay)) > EDGE * DEPTH_TOLERANCE
        })
    }

    /// The weight of a block by its place.
    fn place(&self, pixel: DVec2, block: &Block) -> f64 {
        let away = ((pixel - block.center) / f64::from(self.scale)).abs();
        (1.0 - away.x).max(0.0) * (1.0 - away.y).max(0.0)
    }

    /// The 3 × 3 blocks around one, without those outside the picture.
    fn around(
        &self,
        camera: &Camera,
        low_ends: [&[f32]; 2],
        layers: [&[Vec3]; 2],
        x: u32,
        y: u32,
    ) -> [Option<Block>; 9] {
        let (columns, rows) = self.low_size();
        std::array::from_fn(|i| {
            let (dx, dy) = (i as i64 % 3 - 1, i as i64 / 3 - 1);
            let x = u32::try_from(i64::from(x) + dx).ok().filter(|&x| x < columns)?;
            let y = u32::try_from(i64::from(y) + dy).ok().filter(|&y| y < rows)?;
            let (at, center) = (x as usize + columns as usize * y as usize, self.center(x, y));
            let stretch = self.stretch(camera, center);
            // without a far layer, the near one stands for both
            let far = usize::from(low_ends[1][at] > 0.0);
            Some(Block {
                center,
                depths: [0, far].map(|layer| f64::from(low_ends[layer][at]) / stretch),
                layers: [0, far].map(|layer| layers[layer][at].as_dvec3()),
            })
        })
    }

    /// The weighted mean of blocks for a pixel with its centre at `pixel` and a surface at `depth`.
    fn blend<'b>(&self, blocks: impl Iterator<Item = &'b Block>, pixel: DVec2, depth: f64) -> DVec3 {
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for block in blocks {
            let place = self.place(pixel, block);
            if place == 0.0 {
                continue;
            }
            let [near, far] = block.depths.map(|layer| difference(depth, layer));
            let (layer, apart) = if far < near { (1, far) } else { (0, near) };
            let weight = place * (1.0 + (apart / DEPTH_TOLERANCE).powi(2)).powi(-2);
            sum += weight * block.layers[layer];
            weights += weight;
        }
        // the pixel's own block is less than one block away, so it always counts
        sum / weights
    }

    /// A block's centre as if it were whole; units: pixels.
    fn center(&self, x: u32, y: u32) -> DVec2 {
        (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * f64::from(self.scale)
    }

    /// The pixels of a block.
    fn pixels(&self, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (scale, (width, height)) = (self.scale, self.size);
        let rows = y * scale..((y + 1) * scale).min(height);
        rows.flat_map(move |py| (x * scale..((x + 1) * scale).min(width)).map(move |px| (px, py)))
    }

    /// Planar depth of a pixel's surface; units: m.
    fn depth(&self, camera: &Camera, full_ends: &[f32], x: u32, y: u32) -> f64 {
        let end = full_ends[x as usize + self.size.0 as usize * y as usize];
        f64::from(end) / self.stretch(camera, pixel_center(x, y))
    }

    /// Distance along the ray through an image position for each metre of planar depth.
    fn stretch(&self, camera: &Camera, pixel: DVec2) -> f64 {
        let half = (0.5 * f64::from(camera.fov_y)).tan();
        let size = DVec2::new(f64::from(self.size.0), f64::from(self.size.1));
        let tangent = (2.0 * pixel / size - 1.0) * half * DVec2::new(size.x / size.y, 1.0);
        (1.0 + tangent.length_squared()).sqrt()
    }
}

/// The difference of two depths as a share of the larger: 0 for equal ones, two infinite ones included, up to 1.
fn difference(a: f64, b: f64) -> f64 {
    let (less, more) = (a.min(b), a.max(b));
    if less < more { 1.0 - less / more } else { 0.0 }
}

fn pixel_center(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// All positions of a picture, row by row.
fn grid((columns, rows): (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

fn check(array: &'static str, got: usize, (width, height): (u32, u32)) -> Result<(), LowResolutionError> {
    let expected = width as usize * height as usize;
    if got == expected { Ok(()) } else { Err(LowResolutionError::Length { array, expected, got }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.2).unwrap()
    }

    /// The distances at which rays through image positions of a picture of `size` meet what lies at a planar depth.
    fn end_at(depth: f64, camera: &Camera, pixel: DVec2, size: (u32, u32)) -> f32 {
        (depth / camera.ray(pixel, size).direction.dot(camera.forward.as_dvec3())) as f32
    }

    fn ends_at(depth: impl Fn(u32, u32) -> f64, camera: &Camera, size: (u32, u32)) -> Vec<f32> {
        grid(size).map(|(x, y)| end_at(depth(x, y), camera, pixel_center(x, y), size)).collect()
    }

    /// Upsamples what `radiance` sees at each block's two ends.
    fn run(low: &LowResolution, full: &[f32], radiance: impl Fn(u32, u32, f32) -> Vec3) -> Vec<Vec3> {
        let camera = camera();
        let [near, far] = low.ends(&camera, full).unwrap();
        let layer = |ends: &[f32]| -> Vec<Vec3> {
            // what is left out must not be read
            let of = |((x, y), &end): ((u32, u32), &f32)| {
                if end > 0.0 { radiance(x, y, end) } else { Vec3::NAN }
            };
            grid(low.low_size()).zip(ends).map(of).collect()
        };
        let layers = [layer(&near), layer(&far)];
        low.upsample(&camera, full, [&near, &far], [&layers[0], &layers[1]]).unwrap()
    }

    #[test]
    fn blocks_cover_the_picture() {
        let low = LowResolution::new((10, 7), 4).unwrap();
        assert_eq!(low.low_size(), (3, 2));
        let mut seen = vec![0; 70];
        for (x, y) in grid(low.low_size()) {
            for (px, py) in low.pixels(x, y) {
                seen[(px + 10 * py) as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&count| count == 1));
        // the last block is cut off, and its ray goes where its centre would be
        let ray = low.low_ray(&camera(), 2, 1);
        assert_eq!(ray, camera().ray(DVec2::new(10.0, 6.0), (10, 7)));
    }

    #[test]
    fn ends_lie_on_the_blocks_own_ray() {
        let (camera, size) = (camera(), (10, 7));
        let low = LowResolution::new(size, 4).unwrap();
        // a wall that faces the camera is one depth however far off the axis
        let [near, far] = low.ends(&camera, &ends_at(|_, _| 3.0, &camera, size)).unwrap();
        for ((x, y), &end) in grid(low.low_size()).zip(&near) {
            let exact = end_at(3.0, &camera, low.center(x, y), size);
            assert!((end / exact - 1.0).abs() < 1e-6, "block {x}, {y}: {end}, not {exact}");
        }
        assert!(far.iter().all(|&end| end == 0.0));
        // two depths in the middle block, and a sky in the last
        let depth = |x: u32, _| [3.0, 5.0, f64::INFINITY][(x as usize / 3).min(2)];
        let [near, far] = low.ends(&camera, &ends_at(depth, &camera, size)).unwrap();
        assert!((far[0] / near[0] - 5.0 / 3.0).abs() < 1e-6);
        assert!(near[1].is_finite() && far[1].is_infinite());
        assert!(near[2].is_infinite() && far[2] == 0.0);
    }

    #[test]
    fn a_constant_stays_constant() {
        let colour = Vec3::new(0.3, 2.0, 7.0);
        for (size, scale) in [((17, 9), 4), ((8, 8), 2), ((1, 1), 4), ((5, 3), 64), ((6, 4), 1)] {
            let low = LowResolution::new(size, scale).unwrap();
            let depth = |x: u32, y: u32| [0.5, 4.0, f64::INFINITY, 90.0][(x * 7 + y * 5) as usize % 4];
            let full = ends_at(depth, &camera(), size);
            for pixel in run(&low, &full, |_, _, _| colour) {
                assert!((pixel / colour - 1.0).abs().max_element() < 1e-6, "{pixel}");
            }
        }
    }

    #[test]
    fn a_ramp_stays_a_ramp() {
        let size = (32, 24);
        for scale in [2, 4] {
            let low = LowResolution::new(size, scale).unwrap();
            let full = ends_at(|_, _| 6.0, &camera(), size);
            let ramp = |at: DVec2| (1.0 + at.x + 2.0 * at.y) as f32;
            let got = run(&low, &full, |x, y, _| Vec3::splat(ramp(low.center(x, y))));
            let mut inside = 0;
            for ((x, y), pixel) in grid(size).zip(got) {
                let border = scale / 2;
                if x >= border && y >= border && x < size.0 - border && y < size.1 - border {
                    let exact = ramp(pixel_center(x, y));
                    assert!((pixel.x / exact - 1.0).abs() < 1e-5, "{x}, {y}: {pixel} {exact}");
                    inside += 1;
                }
            }
            assert!(inside > 500);
        }
    }

    #[test]
    fn nothing_bleeds_over_an_edge() {
        let size = (24, 18);
        // an edge through the middle of blocks and a thin post; a fence, of which every block has its part
        let edge: fn(u32, u32) -> bool = |x, y| x < 10 + y / 6 || x == 17;
        let fence: fn(u32, u32) -> bool = |x, _| x % 2 == 0;
        for (near, behind) in [(edge, 8.0), (edge, f64::INFINITY), (fence, 8.0), (fence, f64::INFINITY)] {
            for scale in [2, 4] {
                let low = LowResolution::new(size, scale).unwrap();
                let full = ends_at(|x, y| if near(x, y) { 2.0 } else { behind }, &camera(), size);
                let got = run(&low, &full, |_, _, end| Vec3::splat(if end > 5.0 { 100.0 } else { 1.0 }));
                for ((x, y), pixel) in grid(size).zip(got) {
                    let exact = if near(x, y) { 1.0 } else { 100.0 };
                    assert!((pixel.x / exact - 1.0).abs() < 0.01, "{scale}, {x}, {y}: {pixel}");
                }
            }
        }
    }

    #[test]
    fn scale_1_is_the_picture_itself() {
        let size = (7, 5);
        let low = LowResolution::new(size, 1).unwrap();
        let full = ends_at(|x, y| f64::from(1 + x * y), &camera(), size);
        let value = |x: u32, y: u32| Vec3::new(x as f32, y as f32, (x * y) as f32);
        let got = run(&low, &full, |x, y, _| value(x, y));
        assert!(grid(size).zip(got).all(|((x, y), pixel)| pixel == value(x, y)));
        assert!(low.low_ray(&camera(), 3, 2) == camera().pixel_ray(3, 2, size));
    }

    #[test]
    fn edges_are_found_on_both_sides_and_nowhere_else() {
        let (camera, size) = (camera(), (24, 18));
        let low = LowResolution::new(size, 4).unwrap();
        // an edge between blocks, and one through the middle of blocks
        for edge in [8, 10] {
            let full = ends_at(|x, _| if x < edge { 2.0 } else { 9.0 }, &camera, size);
            let [near, far] = low.ends(&camera, &full).unwrap();
            let edges = low.edges(&camera, &full, [&near, &far]).unwrap();
            for ((x, y), found) in grid(size).zip(edges) {
                let away = if x < edge { edge - 1 - x } else { x - edge };
                assert!(found || away >= 2, "{x}, {y}, edge at {edge}");
                assert!(!found || away < 6, "{x}, {y}, edge at {edge}");
            }
        }
    }

    #[test]
    fn strange_ends_are_no_strange_pixels() {
        let low = LowResolution::new((6, 5), 2).unwrap();
        let strange = [0.0, f32::INFINITY, f32::MIN_POSITIVE, f32::MAX, f32::NAN, 1.0, -1.0];
        let full: Vec<f32> = (0..30).map(|i| strange[i * 5 % 7]).collect();
        let camera = camera();
        let [near, far] = low.ends(&camera, &full).unwrap();
        let layer = vec![Vec3::ONE; 9];
        let got = low.upsample(&camera, &full, [&near, &far], [&layer, &layer]).unwrap();
        assert!(got.iter().all(|pixel| (*pixel - 1.0).abs().max_element() < 1e-6), "{got:?}");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert_eq!(LowResolution::new((4, 4), 0), Err(LowResolutionError::Scale(0)));
        assert!(LowResolution::new((4, 4), 65).is_err());
        let low = LowResolution::new((4, 4), 2).unwrap();
        let refusal = low.ends(&camera(), &[1.0; 15]).unwrap_err();
        assert_eq!(refusal.to_string(), "full_ends must have 16 values, got 15");
        let (ends, layer) = (&[1.0; 4][..], &[Vec3::ONE; 4][..]);
        assert!(low.upsample(&camera(), &[1.0; 16], [ends, ends], [layer, &layer[1..]]).is_err());
        let nothing = LowResolution::new((0, 0), 2).unwrap();
        assert_eq!(nothing.ends(&camera(), &[]), Ok([vec![], vec![]]));
    }
}
