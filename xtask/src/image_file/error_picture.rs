//! Error maps: where two pictures differ.
//!
//! Every map uses the same scale, so that two maps can be compared by eye: |a − b| averaged over the channels and
//! divided by the mean of b, logarithmic from 10⁻⁴ (dark) to 1 (light). The average of a map before colouring is the
//! `nmae` of the comparison.

use super::Image;
use super::display::{Image8, quantise, srgb_from_linear};
use crate::failure::{Failure, Outcome};

/// Relative errors at the dark and at the light end of every error map, as decadic exponents.
const SCALE: [f64; 2] = [-4.0, 0.0];

/// The same for a legend.
pub(crate) const ERROR_SCALE_ENDS: [&str; 2] = ["10⁻⁴", "1"];

/// Shown where a value is not finite; the colour scale has no cyan.
const NOT_FINITE: [u8; 3] = [0, 255, 255];

/// Colours |a − b| / mean(b) on the scale of [`ERROR_SCALE_ENDS`]. Cyan marks values that are not finite.
pub(crate) fn error_picture(a: &Image, b: &Image) -> Outcome<Image8> {
    if !a.same_size(b) {
        return Err(Failure::program("error map of two pictures that differ in size"));
    }
    let finite = b.pixels.iter().flatten().filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + f64::from(*value), count + 1.0));
    let mean = sum / f64::max(count, 1.0);
    let colour = |(a, b): (&[f32; 3], &[f32; 3])| {
        if a.iter().chain(b).any(|value| !value.is_finite()) {
            return NOT_FINITE;
        }
        let error = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).sum::<f64>() / 3.0;
        scale_colour(position(error, mean))
    };
    let pixels = a.pixels.iter().zip(&b.pixels).map(colour).collect();
    Ok(Image8 { width: a.width, height: a.height, pixels })
}

/// Place of `error` / `mean` on the scale, 0 to 1. No error is 0 whatever the mean; some error of nothing is 1.
fn position(error: f64, mean: f64) -> f32 {
    if error == 0.0 {
        return 0.0;
    }
    if mean <= 0.0 {
        return 1.0;
    }
    let [low, high] = SCALE;
    (((error / mean).log10() - low) / (high - low)).clamp(0.0, 1.0) as f32
}

/// Colour at `t` in [0, 1]: from near black through violet, red and orange to pale yellow.
///
/// Lightness rises evenly, in Oklab (Ottosson 2020), so that the map reads the same in grey and to colour-blind eyes.
/// The hue turns with it; chroma is what sRGB has room for at that lightness and hue, up to a limit.
pub(crate) fn scale_colour(t: f32) -> [u8; 3] {
    let t = t.clamp(0.0, 1.0);
    let lightness = 0.12 + 0.85 * t;
    let hue = (290.0 + 180.0 * t).to_radians();
    let colour = |chroma: f32| oklab_to_linear_srgb([lightness, chroma * hue.cos(), chroma * hue.sin()]);
    let shown = (0..=20)
        .map(|step| colour(0.2 - 0.01 * step as f32))
        .find(|colour| colour.iter().all(|value| (0.0..=1.0).contains(value)))
        .unwrap_or([t; 3]);
    shown.map(|value| quantise(srgb_from_linear(value)))
}

/// Ottosson's matrices, <https://bottosson.github.io/posts/oklab/>.
fn oklab_to_linear_srgb([l, a, b]: [f32; 3]) -> [f32; 3] {
    let long = (l + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let medium = (l - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let short = (l - 0.0894841775 * a - 1.2914855480 * b).powi(3);
    [
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_runs_over_four_decades() {
        assert_eq!(position(0.0, 0.0), 0.0);
        assert_eq!(position(1e-9, 1.0), 0.0);
        assert!((position(2e-2, 2.0) - 0.5).abs() < 1e-6);
        assert_eq!(position(7.0, 1.0), 1.0);
        assert_eq!(position(1.0, 0.0), 1.0);
    }

    #[test]
    fn lightness_rises_all_the_way() {
        let luminance = |t: f32| {
            let [r, g, b] = scale_colour(t).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let steps: Vec<f32> = (0..=32).map(|i| luminance(i as f32 / 32.0)).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert!(steps[0] < 16.0 && steps[32] > 220.0, "{steps:?}");
    }

    #[test]
    fn equal_pictures_are_dark_and_gaps_are_marked() {
        let b = Image { width: 3, height: 1, pixels: vec![[1.0; 3], [1.0; 3], [f32::NAN, 1.0, 1.0]] };
        let a = Image { pixels: vec![[1.0; 3], [2.0; 3], [1.0; 3]], ..b.clone() };
        let map = error_picture(&a, &b).unwrap();
        assert_eq!(map.pixels, [scale_colour(0.0), scale_colour(1.0), NOT_FINITE]);
    }
}
