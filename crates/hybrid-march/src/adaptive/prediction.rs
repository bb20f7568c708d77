//! The airlight of a pixel from that of pixels around it, with an estimate of the error.

use glam::DVec3;

/// Inverse depths that differ by less than this share are on one plane.
const SAME_PLANE: f64 = 0.02;

/// The same for the next pixels in line, which are three times as far away.
const SAME_PLANE_FAR: f64 = 3.0 * SAME_PLANE;

/// Beside a depth edge, what a relative difference of inverse depths of this much and more takes away from a value's weight.
const SAME_DEPTH: f64 = 1e-3;

/// Share of the values' spread that an estimated error is at least.
const LEAST_ESTIMATE: f64 = 1.0 / 32.0;

/// Where the pixels around one lie, at half a stride; in the same lines others lie at one and a half. The first and the last
/// of four lie opposite of each other.
const ALONG_ROW: &[(i64, i64)] = &[(-1, 0), (1, 0)];
const ALONG_COLUMN: &[(i64, i64)] = &[(0, -1), (0, 1)];
const DIAGONALS: &[(i64, i64)] = &[(-1, -1), (1, -1), (-1, 1), (1, 1)];

/// What a pixel's airlight is taken for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prediction {
    /// Column and row among the pixels known before.
    pub(super) cell: [u32; 2],
    pixel: (u32, u32),
    value: DVec3,
    /// Infinite where nothing can be said; units: W/(m²·sr).
    pub(super) estimate: f64,
}

/// A picture, part of which is known.
pub(super) struct Known {
    size: (u32, u32),
    pub(super) values: Vec<DVec3>,
    /// Inverse distances of what the pixels see; units: 1/m.
    inverse_depths: Vec<f64>,
}

impl Known {
    pub(super) fn new(size: (u32, u32), ends: &[f32]) -> Self {
        let inverse_depths = ends.iter().map(|&end| 1.0 / f64::from(end)).collect();
        Self { size, values: vec![DVec3::ZERO; ends.len()], inverse_depths }
    }

    pub(super) fn set(&mut self, pixels: &[(u32, u32)], values: &[DVec3]) {
        for (&(x, y), &value) in pixels.iter().zip(values) {
            self.values[y as usize * self.size.0 as usize + x as usize] = value;
        }
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let inside = (0..i64::from(self.size.0)).contains(&x) && (0..i64::from(self.size.1)).contains(&y);
        inside.then(|| y as usize * self.size.0 as usize + x as usize)
    }

    /// Predicts the pixels halfway between those at `stride`. Where four that are known differ by at most `equal`, those
    /// between them are as good as equal; units: W/(m²·sr).
    pub(super) fn predict(&self, stride: u32, equal: f64) -> Vec<Prediction> {
        let half = stride / 2;
        let mut all = Vec::new();
        for y in (0..self.size.1).step_by(stride as usize) {
            for x in (0..self.size.0).step_by(stride as usize) {
                let corners = self.spread(x, y, stride);
                for (dx, dy, around) in
                    [(half, 0, ALONG_ROW), (0, half, ALONG_COLUMN), (half, half, DIAGONALS)]
                {
                    let pixel = (x + dx, y + dy);
                    if self.index(pixel.0.into(), pixel.1.into()).is_some() {
                        let (value, estimate) = self
                            .between(pixel, half, around, corners, equal)
                            .unwrap_or((DVec3::ZERO, f64::INFINITY));
                        all.push(Prediction { cell: [x / stride, y / stride], pixel, value, estimate });
                    }
                }
            }
        }
        all
    }

    /// Takes what is estimated to err by at most `tolerance`, in W/(m²·sr), and returns the pixels that are left.
    pub(super) fn take(&mut self, predictions: &[Prediction], tolerance: f64) -> Vec<(u32, u32)> {
        let mut left = Vec::new();
        for &Prediction { pixel, value, estimate, .. } in predictions {
            if estimate <= tolerance {
                self.set(&[pixel], &[value]);
            } else {
                left.push(pixel);
            }
        }
        left
    }

    /// By how much a pixel and the next ones to its right, below and across differ; `None` at the end of the picture.
    fn spread(&self, x: u32, y: u32, stride: u32) -> Option<f64> {
        let corners = [(0, 0), (stride, 0), (0, stride), (stride, stride)]
            .map(|(dx, dy)| self.index((x + dx).into(), (y + dy).into()).map(|index| self.values[index]));
        let corners: Vec<DVec3> = corners.into_iter().collect::<Option<_>>()?;
        let least = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let most = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        Some((most - least).length())
    }

    /// The airlight of a pixel from those around it, and the estimated error; `None` where they are not all in the picture,
    /// or see nothing at its depth. `corners` is by how much four known ones around it differ.
    fn between(
        &self,
        (x, y): (u32, u32),
        half: u32,
        around: &[(i64, i64)],
        corners: Option<f64>,
        equal: f64,
    ) -> Option<(DVec3, f64)> {
        let at = |(dx, dy): (i64, i64), times: i64| {
            let reach = times * i64::from(half);
            self.index(i64::from(x) + reach * dx, i64::from(y) + reach * dy)
        };
        let near: Vec<usize> = around.iter().map(|&way| at(way, 1)).collect::<Option<_>>()?;
        let own = self.inverse_depths[self.index(x.into(), y.into())?];
        let count = near.len() as f64;
        let depth = |&index: &usize| self.inverse_depths[index];
        let mean_of = |pixels: &[usize]| pixels.iter().map(depth).sum::<f64>() / count;
        let value = |&index: &usize| self.values[index];
        let sum: DVec3 = near.iter().map(value).sum();
        let least = near.iter().map(value).fold(DVec3::INFINITY, DVec3::min);
        let most = near.iter().map(value).fold(DVec3::NEG_INFINITY, DVec3::max);
        let (line, spread) = (sum / count, (most - least).length());

        let plane = mean_of(&near);
        let mut flat = (own - plane).abs() <= SAME_PLANE * own.max(plane);
        if let [a, b, c, d] = near[..] {
            let [a, b, c, d] = [a, b, c, d].map(|index| self.inverse_depths[index]);
            flat &= (a + d - b - c).abs() <= 2.0 * SAME_PLANE * own;
        }
        if !flat {
            let farthest = near.iter().map(depth).fold(f64::INFINITY, f64::min);
            let nearest = near.iter().map(depth).fold(0.0, f64::max);
            if own < (1.0 - SAME_PLANE) * farthest || own > (1.0 + SAME_PLANE) * nearest {
                return None;
            }
            let weight = |index: &usize| 1.0 / ((depth(index) - own).abs() / own.max(1e-30) + SAME_DEPTH);
            let weighted: DVec3 = near.iter().map(|index| weight(index) * value(index)).sum();
            // two of them may agree by chance
            let spread = corners.unwrap_or(spread);
            return Some((weighted / near.iter().map(weight).sum::<f64>(), 0.5 * spread));
        }
        if corners.is_some_and(|corners| corners <= equal) {
            return Some((line, LEAST_ESTIMATE * spread));
        }
        let far: Option<Vec<usize>> = around.iter().map(|&way| at(way, 3)).collect();
        let far = far.filter(|far| (own - mean_of(far)).abs() <= SAME_PLANE_FAR * own);
        Some(match far {
            Some(far) => {
                let cubic = (9.0 * sum - far.iter().map(value).sum::<DVec3>()) / (8.0 * count);
                (cubic.max(DVec3::ZERO), (cubic - line).length().max(LEAST_ESTIMATE * spread))
            }
            None => (line, 0.5 * spread),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Prediction {
        /// One of which nothing but its estimate matters.
        pub(in crate::adaptive) fn of_estimate(estimate: f64) -> Self {
            Self { cell: [0, 0], pixel: (0, 0), value: DVec3::ZERO, estimate }
        }
    }

    const SIZE: (u32, u32) = (17, 17);

    /// What is predicted for a pixel between those at a stride of 4.
    fn predicted(
        value: impl Fn(u32, u32) -> f64,
        end: impl Fn(u32, u32) -> f32,
        pixel: (u32, u32),
    ) -> (f64, f64) {
        let pixels: Vec<(u32, u32)> = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).collect();
        let ends: Vec<f32> = pixels.iter().map(|&(x, y)| end(x, y)).collect();
        let mut known = Known::new(SIZE, &ends);
        let values: Vec<DVec3> = pixels.iter().map(|&(x, y)| DVec3::splat(value(x, y))).collect();
        known.set(&pixels, &values);
        let all = known.predict(4, 1e-6);
        let found = all.iter().find(|prediction| prediction.pixel == pixel).unwrap();
        (found.value.x, found.estimate)
    }

    #[test]
    fn a_curve_is_predicted_and_its_bend_the_estimate() {
        let curve = |x: u32, y: u32| 5.0 + (f64::from(x) - 7.0).powi(2) + f64::from(y);
        for pixel in [(6, 8), (8, 6), (6, 6)] {
            let (value, estimate) = predicted(curve, |_, _| 10.0, pixel);
            assert!((value - curve(pixel.0, pixel.1)).abs() < 1e-9, "{pixel:?}: {value}");
            assert!(estimate > 0.0 && estimate < 10.0, "{pixel:?}: {estimate}");
        }
        // next to the picture's edge by a line
        let (value, estimate) = predicted(curve, |_, _| 10.0, (2, 8));
        assert!(value == 0.5 * (curve(0, 8) + curve(4, 8)) && estimate > 0.0);
    }

    #[test]
    fn what_does_not_change_is_as_good_as_known() {
        let (value, estimate) = predicted(|_, _| 3.0, |_, _| f32::INFINITY, (6, 6));
        assert_eq!((value, estimate), (3.0, 0.0));
    }

    #[test]
    fn beside_a_depth_edge_a_pixel_has_the_airlight_of_its_depth() {
        // a near plane left of column 7, where less is scattered
        let end = |x: u32, _: u32| if x < 7 { 5.0 } else { 20.0 };
        let airlight = |x: u32, _: u32| if x < 7 { 1.0 } else { 4.0 };
        let (value, estimate) = predicted(airlight, end, (6, 8));
        assert!((value - 1.0).abs() < 0.01 && estimate > 1.0, "{value}, {estimate}");
        // nearer than all around it: nothing can be said
        let post = |x: u32, _: u32| if x == 6 { 2.0 } else { 20.0 };
        assert_eq!(predicted(airlight, post, (6, 8)).1, f64::INFINITY);
    }

    #[test]
    fn two_that_agree_by_chance_are_not_believed_beside_a_depth_edge() {
        let end = |x: u32, y: u32| 10.0 + 0.5 * (x + y) as f32 * if x > 6 { 2.0 } else { 1.0 };
        let airlight = |_: u32, y: u32| if y == 8 { 1.0 } else { 2.0 };
        assert!(predicted(airlight, end, (6, 8)).1 > 0.5);
    }
}
