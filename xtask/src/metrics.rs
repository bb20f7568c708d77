//! How far one picture is from another.
//!
//! With a the picture, b its reference and u the same picture without shadows, over all channel values of all counted
//! pixels:
//!
//! | figure | meaning |
//! |---|---|
//! | `rel_rmse` | ‖a − b‖₂ / ‖b‖₂ |
//! | `nmae` | mean \|a − b\| / mean b |
//! | `p99` | 99th percentile of \|a − b\|, divided by mean b |
//! | `max_abs` | largest \|a − b\| |
//! | `flip` | mean FLIP at 67 pixels per degree, see [`flip`] |
//! | `nan` | values of a, b and u that are not finite |
//! | `shadow_err` | ‖a − b‖₂ / ‖u − b‖₂: 1 is no better than drawing no shadows |
//!
//! Percentiles are nearest-rank. 0/0 is 0; something divided by nothing is infinite, which JSON writes as `null`.
//! A value that is not finite is counted in `nan` and left out of the other figures together with its counterpart in
//! the other picture; where nothing is left, those figures are `null` too, since a zero would read as perfect.

use nv_flip::FlipImageRgb8;
use serde::{Deserialize, Deserializer, Serialize};

use crate::failure::{Failure, Outcome};
use crate::image_file::{Image, to_srgb8};

/// Angular resolution that FLIP assumes of the viewer: its own default, 0.7 m from a 0.7 m wide 4K screen.
const PIXELS_PER_DEGREE: f32 = 67.0;

/// The figures of one comparison. Not finite (in JSON `null`) where the quotient has no value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Metrics {
    /// ‖a − b‖₂ / ‖b‖₂.
    #[serde(deserialize_with = "null_is_infinite")]
    pub rel_rmse: f64,
    /// mean |a − b| / mean b.
    #[serde(deserialize_with = "null_is_infinite")]
    pub nmae: f64,
    /// 99th percentile of |a − b| / mean b.
    #[serde(deserialize_with = "null_is_infinite")]
    pub p99: f64,
    /// Largest |a − b|, in the pictures' unit.
    #[serde(deserialize_with = "null_is_infinite")]
    pub max_abs: f64,
    /// Mean FLIP, 0 to 1.
    #[serde(deserialize_with = "null_is_infinite")]
    pub flip: f64,
    /// How many values are not finite.
    pub nan: u64,
    /// ‖a − b‖₂ / ‖u − b‖₂, where the picture without shadows is known.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    pub shadow_err: Option<f64>,
}

/// Compares `a` with its reference `b`.
///
/// `unshadowed` is the same view with nothing casting a shadow; `mask` says which pixels count, row by row.
///
/// Fails when the sizes differ or the mask counts no pixel.
pub(crate) fn compare(
    a: &Image,
    b: &Image,
    unshadowed: Option<&Image>,
    mask: Option<&[bool]>,
) -> Outcome<Metrics> {
    let same_size = a.same_size(b)
        && unshadowed.is_none_or(|u| u.same_size(b))
        && mask.is_none_or(|mask| mask.len() == b.pixels.len());
    if !same_size {
        return Err(Failure::program("comparison of pictures that differ in size"));
    }
    if mask.is_some_and(|mask| !mask.contains(&true)) {
        return Err(Failure::input("the mask counts no pixel"));
    }
    let counts = |pixel: usize| mask.is_none_or(|mask| mask[pixel]);

    let mut nan = 0;
    let mut pairs = Pairs::default();
    let mut shadows = ShadowShare::default();
    for pixel in (0..b.pixels.len()).filter(|pixel| counts(*pixel)) {
        for channel in 0..3 {
            let [a, b] = [a, b].map(|image| f64::from(image.pixels[pixel][channel]));
            let u = unshadowed.map(|image| f64::from(image.pixels[pixel][channel]));
            nan +=
                [Some(a), Some(b), u].into_iter().flatten().filter(|value| !value.is_finite()).count() as u64;
            if a.is_finite() && b.is_finite() {
                pairs.add(a, b);
                if let Some(u) = u.filter(|u| u.is_finite()) {
                    shadows.add(a, b, u);
                }
            }
        }
    }

    // a mean over nothing is 0/0 = NaN here, which is what the figures are to be then
    let mean = |sum: f64| sum / pairs.errors.len() as f64;
    let (mean_b, mean_error) = (mean(pairs.sum_b), mean(pairs.errors.iter().sum()));
    let compared = |figure: f64| if mean_b.is_nan() { f64::NAN } else { figure };
    Ok(Metrics {
        rel_rmse: compared(ratio(pairs.squared_error.sqrt(), pairs.squared_b.sqrt())),
        nmae: compared(ratio(mean_error, mean_b)),
        p99: compared(ratio(percentile(&mut pairs.errors, 99), mean_b)),
        max_abs: compared(pairs.errors.iter().copied().fold(0.0, f64::max)),
        flip: flip(a, b, &counts, display_scale(&mut pairs.reference)),
        nan,
        shadow_err: unshadowed.map(|_| shadows.share()),
    })
}

/// Sums over the pairs of values that are both finite.
#[derive(Default)]
struct Pairs {
    squared_error: f64,
    squared_b: f64,
    sum_b: f64,
    errors: Vec<f64>,
    reference: Vec<f64>,
}

impl Pairs {
    fn add(&mut self, a: f64, b: f64) {
        let error = (a - b).abs();
        self.squared_error += error * error;
        self.squared_b += b * b;
        self.sum_b += b;
        self.errors.push(error);
        self.reference.push(b);
    }
}

/// Sums over the triples of values that are all finite.
#[derive(Default)]
struct ShadowShare {
    squared_error: f64,
    squared_shadow: f64,
    count: usize,
}

impl ShadowShare {
    fn add(&mut self, a: f64, b: f64, u: f64) {
        self.squared_error += (a - b) * (a - b);
        self.squared_shadow += (u - b) * (u - b);
        self.count += 1;
    }

    fn share(&self) -> f64 {
        if self.count == 0 {
            return f64::NAN;
        }
        ratio(self.squared_error.sqrt(), self.squared_shadow.sqrt())
    }
}

/// x/y with 0/0 = 0.
fn ratio(x: f64, y: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / y }
}

/// Nearest-rank percentile: the smallest value that at least `percent` of 100 values do not exceed. 0 of none.
///
/// Reorders `values`.
fn percentile(values: &mut [f64], percent: usize) -> f64 {
    let rank = (values.len() * percent).div_ceil(100).max(1);
    if rank > values.len() {
        return 0.0;
    }
    *values.select_nth_unstable_by(rank - 1, f64::total_cmp).1
}

/// The scale k that shows the reference well: its 95th percentile, over channel values, lands at kL = 0.8.
///
/// A reference that is black but for a few pixels has its largest value there instead; one that is black all over is
/// not scaled.
fn display_scale(reference: &mut [f64]) -> f32 {
    let p95 = percentile(reference, 95);
    let white = if p95 > 0.0 { p95 } else { reference.iter().copied().fold(0.0, f64::max) };
    if white > 0.0 { (0.8 / white) as f32 } else { 1.0 }
}

/// Mean FLIP over the counted pixels of 8-bit sRGB(clamp(kL)).
///
/// The map is computed over the whole picture, since the metric looks at a pixel's surroundings. A value that is not
/// finite takes its counterpart's place in both pictures (black where both are not), so that it does not spread to
/// its neighbours, and its pixel does not count.
fn flip(a: &Image, b: &Image, counts: &impl Fn(usize) -> bool, scale: f32) -> f64 {
    let mut whole = vec![true; b.pixels.len()];
    let (mut a, mut b) = (a.clone(), b.clone());
    for (whole, (a, b)) in whole.iter_mut().zip(a.pixels.iter_mut().zip(&mut b.pixels)) {
        for (a, b) in a.iter_mut().zip(b) {
            if !(a.is_finite() && b.is_finite()) {
                *whole = false;
                let stand_in = [*b, *a].into_iter().find(|value| value.is_finite()).unwrap_or(0.0);
                (*a, *b) = (stand_in, stand_in);
            }
        }
    }
    let [a, b] = [a, b].map(|image| {
        let shown = to_srgb8(&image, scale);
        FlipImageRgb8::with_data(shown.width, shown.height, shown.pixels.as_flattened())
    });
    let map = nv_flip::flip(b, a, PIXELS_PER_DEGREE).to_vec();
    let counted = map.iter().zip(whole).enumerate().filter(|(pixel, (_, whole))| *whole && counts(*pixel));
    let (sum, count) =
        counted.fold((0.0, 0.0), |(sum, count), (_, (error, _))| (sum + f64::from(*error), count + 1.0));
    // no pixel left: no value, which is not the same as no error
    sum / count
}

/// Reads a `null` back as what it was written for.
fn null_is_infinite<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(source)?.unwrap_or(f64::INFINITY))
}

/// As [`null_is_infinite`], for a figure that may also be absent.
fn present<'de, D: Deserializer<'de>>(source: D) -> Result<Option<f64>, D::Error> {
    null_is_infinite(source).map(Some)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn grey(width: u32, values: &[f32]) -> Image {
        let height = values.len() as u32 / width;
        Image { width, height, pixels: values.iter().map(|value| [*value; 3]).collect() }
    }

    fn close(left: f64, right: f64) -> bool {
        (left - right).abs() <= 1e-12 * right.abs()
    }

    #[test]
    fn figures_by_hand() {
        let b = grey(2, &[3.0, 4.0, 0.0, 1.0]);
        let a = grey(2, &[3.0, 2.0, 0.0, 2.0]);
        let u = grey(2, &[3.0, 4.0, 10.0, 1.0]);
        let found = compare(&a, &b, Some(&u), None).unwrap();
        // errors 0, 2, 0, 1; mean b = 2; each value three times, which drops out of every quotient
        assert!(close(found.rel_rmse, (5.0_f64 / 26.0).sqrt()), "{found:?}");
        assert!(close(found.nmae, 0.75 / 2.0), "{found:?}");
        assert!(close(found.p99, 2.0 / 2.0), "{found:?}");
        assert!(close(found.max_abs, 2.0), "{found:?}");
        assert!(close(found.shadow_err.unwrap(), 5.0_f64.sqrt() / 10.0), "{found:?}");
        assert!(found.flip > 0.01 && found.flip < 1.0, "{found:?}");
        assert_eq!(found.nan, 0);
    }

    #[test]
    fn percentiles_are_nearest_rank() {
        let mut hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(percentile(&mut hundred, 99), 99.0);
        assert_eq!(percentile(&mut hundred, 95), 95.0);
        let mut few = [5.0, 1.0, 3.0];
        assert_eq!(percentile(&mut few, 99), 5.0);
        assert_eq!(percentile(&mut few, 50), 3.0);
        let mut hundred_and_one: Vec<f64> = (1..=101).map(f64::from).collect();
        // ⌈0.99 · 101⌉ = ⌈99.99⌉ = 100
        assert_eq!(percentile(&mut hundred_and_one, 99), 100.0);
        assert_eq!(percentile(&mut [], 99), 0.0);
    }

    #[test]
    fn quotients_of_nothing() {
        let (black, grey) = (grey(2, &[0.0; 4]), grey(2, &[0.5; 4]));
        let same = compare(&black, &black, Some(&black), None).unwrap();
        assert_eq!(same.shadow_err, Some(0.0));
        assert_eq!((same.rel_rmse, same.nmae, same.p99, same.flip), (0.0, 0.0, 0.0, 0.0));
        let other = compare(&grey, &black, Some(&black), None).unwrap();
        assert_eq!((other.rel_rmse, other.shadow_err), (f64::INFINITY, Some(f64::INFINITY)));
        let json = serde_json::to_string(&other).unwrap();
        assert!(json.contains(r#""rel_rmse":null"#) && json.contains(r#""shadow_err":null"#), "{json}");
        assert_eq!(serde_json::from_str::<Metrics>(&json).unwrap(), other);
    }

    #[test]
    fn keys_are_the_contract() {
        let picture = grey(1, &[1.0]);
        let json = serde_json::to_string(&compare(&picture, &picture, None, None).unwrap()).unwrap();
        assert_eq!(json, r#"{"rel_rmse":0.0,"nmae":0.0,"p99":0.0,"max_abs":0.0,"flip":0.0,"nan":0}"#);
        assert_eq!(serde_json::from_str::<Metrics>(&json).unwrap().shadow_err, None);
    }

    #[test]
    fn values_that_are_not_finite_are_counted_and_left_out() {
        let b = grey(2, &[3.0, 4.0, 5.0, 1.0]);
        let mut a = b.clone();
        a.pixels[1] = [4.0, f32::NAN, f32::INFINITY];
        let found = compare(&a, &b, None, None).unwrap();
        assert_eq!(
            found,
            Metrics { rel_rmse: 0.0, nmae: 0.0, p99: 0.0, max_abs: 0.0, flip: 0.0, nan: 2, shadow_err: None }
        );

        a.pixels.fill([f32::NAN; 3]);
        let nothing = compare(&a, &b, Some(&b), None).unwrap();
        assert_eq!(nothing.nan, 12);
        let json = serde_json::to_value(nothing).unwrap();
        for key in ["rel_rmse", "nmae", "p99", "max_abs", "flip", "shadow_err"] {
            assert!(json[key].is_null(), "{key} must not look like a figure: {json}");
        }
    }

    #[test]
    fn mask_leaves_out() {
        let b = grey(2, &[3.0, 4.0, 5.0, 1.0]);
        let mut a = b.clone();
        a.pixels[2] = [f32::NAN; 3];
        a.pixels[3] = [2.0; 3];
        let without = compare(&a, &b, None, Some(&[true, true, false, false])).unwrap();
        assert_eq!((without.nan, without.max_abs), (0, 0.0));
        // 2 against 1, alone
        let alone = compare(&a, &b, None, Some(&[false, false, false, true])).unwrap();
        assert_eq!((alone.rel_rmse, alone.nmae, alone.p99), (1.0, 1.0, 1.0));
        assert_eq!(compare(&a, &b, None, Some(&[false; 4])).unwrap_err().code(), 2);
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (grey(4, &[1.0; 4]), grey(1, &[1.0; 4]));
        assert!(compare(&wide, &tall, None, None).is_err());
        assert!(compare(&wide, &wide, Some(&tall), None).is_err());
        assert!(compare(&wide, &wide, None, Some(&[true; 3])).is_err());
    }

    #[test]
    fn flip_sees_shape_and_ignores_the_unit() {
        let disc = |radius: f32, light: f32| {
            let inside = |i: u32| ((i % 64) as f32 - 32.0).hypot((i / 64) as f32 - 32.0) < radius;
            grey(64, &(0..64 * 64).map(|i| if inside(i) { light } else { 0.1 * light }).collect::<Vec<_>>())
        };
        let flip = |a: &Image, b: &Image| compare(a, b, None, None).unwrap().flip;
        let near = flip(&disc(20.5, 1.0), &disc(20.0, 1.0));
        let far = flip(&disc(28.0, 1.0), &disc(20.0, 1.0));
        assert!(0.0 < near && near < far && far < 1.0, "{near} {far}");
        assert!((flip(&disc(28.0, 1e-3), &disc(20.0, 1e-3)) - far).abs() < 1e-3);
    }

    fn pictures() -> impl Strategy<Value = (Image, Image)> {
        proptest::collection::vec((0.0_f32..10.0, 0.01_f32..10.0), 12).prop_map(|pairs| {
            let (a, b): (Vec<f32>, Vec<f32>) = pairs.into_iter().unzip();
            (grey(4, &a), grey(4, &b))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn identical_pictures_have_no_error((a, _) in pictures()) {
            let found = compare(&a, &a, Some(&a), None).unwrap();
            prop_assert_eq!(found, Metrics {
                rel_rmse: 0.0, nmae: 0.0, p99: 0.0, max_abs: 0.0, flip: 0.0, nan: 0, shadow_err: Some(0.0),
            });
        }

        #[test]
        fn relative_figures_ignore_a_power_of_two((a, b) in pictures(), exponent in -20_i32..20) {
            // powers of two scale without rounding
            let scaled = |image: &Image| {
                let pixels = image.pixels.iter().map(|p| p.map(|v| v * 2.0_f32.powi(exponent))).collect();
                Image { pixels, ..*image }
            };
            let (plain, scaled) = (compare(&a, &b, None, None).unwrap(), compare(&scaled(&a), &scaled(&b), None, None).unwrap());
            prop_assert!(close(plain.rel_rmse, scaled.rel_rmse));
            prop_assert!(close(plain.nmae, scaled.nmae));
            prop_assert!(close(plain.p99, scaled.p99));
            prop_assert!(close(plain.max_abs * 2.0_f64.powi(exponent), scaled.max_abs));
        }

        #[test]
        fn drawing_no_shadows_is_an_error_of_one((u, b) in pictures()) {
            let found = compare(&u, &b, Some(&u), None).unwrap();
            prop_assert!(close(found.shadow_err.unwrap(), 1.0));
        }
    }
}
