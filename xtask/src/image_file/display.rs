//! Pictures for looking at: 8-bit sRGB and PNG.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::Image;
use crate::failure::{Failure, Outcome};

/// 8-bit sRGB, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Image8 {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width` × `height` pixels, x fastest.
    pub pixels: Vec<[u8; 3]>,
}

/// Shown for a pixel with a NaN in it; no other pixel of a fog picture has this colour.
const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// 8-bit sRGB(clamp(`scale` · L)). Infinity is white; a pixel that is not a number is magenta, so that it shows.
pub(crate) fn to_srgb8(image: &Image, scale: f32) -> Image8 {
    let shown = |pixel: &[f32; 3]| {
        if pixel.iter().any(|value| value.is_nan()) {
            return NOT_A_NUMBER;
        }
        pixel.map(|value| quantise(srgb_from_linear((value * scale).clamp(0.0, 1.0))))
    };
    Image8 { width: image.width, height: image.height, pixels: image.pixels.iter().map(shown).collect() }
}

/// sRGB's transfer function (IEC 61966-2-1) on [0, 1].
pub(super) fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// [0, 1] to the nearest of 256 steps; the cast saturates.
pub(super) fn quantise(value: f32) -> u8 {
    (255.0 * value).round() as u8
}

/// A PNG file in memory.
pub(crate) fn encode_png(image: &Image8) -> Outcome<Vec<u8>> {
    let mut file = Cursor::new(Vec::new());
    PngEncoder::new(&mut file)
        .write_image(image.pixels.as_flattened(), image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|error| Failure::program(format_args!("PNG encoding: {error}")))?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_function_meets_its_ends_and_its_joint() {
        assert_eq!(quantise(srgb_from_linear(0.0)), 0);
        assert_eq!(quantise(srgb_from_linear(1.0)), 255);
        // mid grey: 0.2140 linear is one half in sRGB
        assert!((srgb_from_linear(0.214_041_14) - 0.5).abs() < 1e-6);
        assert!((srgb_from_linear(0.003_130_7) - srgb_from_linear(0.003_130_9)).abs() < 1e-5);
    }

    #[test]
    fn what_is_not_a_number_shows() {
        let pixels = vec![[0.5, f32::NAN, 0.5], [f32::INFINITY, f32::NEG_INFINITY, 0.0]];
        let shown = to_srgb8(&Image { width: 2, height: 1, pixels }, 1.0);
        assert_eq!(shown.pixels, [NOT_A_NUMBER, [255, 0, 0]]);
        // zero stays black under any scale, though 0 · ∞ is not a number
        let black = Image { width: 1, height: 1, pixels: vec![[0.0; 3]] };
        assert_eq!(to_srgb8(&black, f32::INFINITY).pixels, [[0; 3]]);
    }

    #[test]
    fn png_holds_the_pixels() {
        let shown = Image8 { width: 2, height: 1, pixels: vec![[1, 2, 3], [250, 0, 7]] };
        let read = image::load_from_memory(&encode_png(&shown).unwrap()).unwrap().into_rgb8();
        assert_eq!((read.width(), read.height()), (2, 1));
        assert_eq!(read.into_raw(), [1, 2, 3, 250, 0, 7]);
    }
}
