//! Pictures in front of spot lights.

use super::buffers::Buffers;
use super::error::{ImportError, one_line, place};
use super::uri;
use crate::{LightTexture, TextureFilter};
use gltf::Document;
use image::{ImageFormat, ImageReader, Limits};
use serde::Deserialize;
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// What the numbers of a picture mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorSpace {
    /// Numbers follow the sRGB curve and are made linear.
    #[default]
    Srgb,
    /// Numbers are linear factors already.
    Linear,
}

/// Largest side of a picture; units: texels.
const LARGEST: u32 = 8192;
/// Most memory that decoding may take, so that a small file cannot ask for more; units: bytes.
const MOST_MEMORY: u64 = 512 << 20;

/// Decodes a PNG, JPEG or EXR file; EXR is linear whatever `color_space` says. Alpha is ignored.
pub(super) fn decode(
    bytes: &[u8],
    filter: TextureFilter,
    color_space: ColorSpace,
) -> Result<LightTexture, ImportError> {
    let bad = |error: &dyn std::fmt::Display| ImportError::Image(one_line(error));
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(ImportError::Read)?;
    let format = reader.format();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::OpenExr)) {
        return Err(bad(&"it is neither PNG nor JPEG nor EXR"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST);
    limits.max_image_height = Some(LARGEST);
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| bad(&error))?.into_rgb32f();
    let (width, height) = image.dimensions();
    let mut texels: Vec<[f32; 3]> = image.pixels().map(|pixel| pixel.0).collect();
    if color_space == ColorSpace::Srgb && format != Some(ImageFormat::OpenExr) {
        texels.as_flattened_mut().iter_mut().for_each(|value| *value = linear_from_srgb(*value));
    }
    LightTexture::new(width, height, texels, filter).map_err(|error| bad(&error))
}

/// The sRGB curve of IEC 61966-2-1.
fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// A node's `extras.light_texture`.
#[derive(Debug, Deserialize)]
pub(super) struct Reference {
    image: usize,
    #[serde(default, with = "Filter")]
    filter: TextureFilter,
    #[serde(default)]
    color_space: ColorSpace,
}

#[derive(Deserialize)]
#[serde(remote = "TextureFilter", rename_all = "lowercase")]
enum Filter {
    Nearest,
    Linear,
}

/// The light textures of a document; those that lights share are decoded once.
#[derive(Debug)]
pub(super) struct Textures<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    base: Option<&'a Path>,
    decoded: Vec<((usize, TextureFilter, ColorSpace), Arc<LightTexture>)>,
}

impl<'a> Textures<'a> {
    /// None decoded yet; `base` is the folder of relative URIs.
    pub(super) fn new(document: &'a Document, buffers: &'a Buffers<'a>, base: Option<&'a Path>) -> Self {
        Self { document, buffers, base, decoded: Vec::new() }
    }

    /// The texture that the node called `node` refers to.
    pub(super) fn get(
        &mut self,
        &Reference { image: index, filter, color_space }: &Reference,
        node: &str,
    ) -> Result<Arc<LightTexture>, ImportError> {
        let key = (index, filter, color_space);
        if let Some((_, texture)) = self.decoded.iter().find(|(known, _)| *known == key) {
            return Ok(Arc::clone(texture));
        }
        // `Image::source` of the crate panics without a MIME type, which nothing is done with here
        let images = &self.document.as_json().images;
        let image = images.get(index).ok_or_else(|| {
            let reason = format!("there is no image {index}, the file has {}", images.len());
            ImportError::at(format!("{node} extras.light_texture.image"), reason)
        })?;
        let place = place("image", index, image.name.as_deref());
        let view = image.buffer_view.and_then(|view| self.document.views().nth(view.value()));
        let bytes = match (view, &image.uri) {
            (Some(view), _) => Cow::Borrowed(self.buffers.view(&view)?),
            (None, Some(uri)) => Cow::Owned(uri::read(uri, &place, self.base, MOST_MEMORY)?),
            (None, None) => return Err(ImportError::at(place, "has neither a bufferView nor a uri")),
        };
        let texture = decode(&bytes, filter, color_space).map_err(|error| ImportError::at(place, error))?;
        let texture = Arc::new(texture);
        self.decoded.push((key, Arc::clone(&texture)));
        Ok(texture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, Luma, Rgb, Rgb32FImage, RgbImage, Rgba, RgbaImage};

    fn encode(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn the_curve_by_hand() {
        assert_eq!(linear_from_srgb(0.0), 0.0);
        assert_eq!(linear_from_srgb(1.0), 1.0);
        // 188/255 is the code value next to half the light
        assert!((linear_from_srgb(188.0 / 255.0) - 0.502_886_5).abs() < 1e-6);
        assert!((linear_from_srgb(0.040_45) - 0.040_45 / 12.92).abs() < 1e-9);
    }

    #[test]
    fn kinds_of_picture() {
        let linear = |bytes: &[u8]| decode(bytes, TextureFilter::Nearest, ColorSpace::Linear).unwrap();
        let rgb = RgbImage::from_fn(2, 1, |x, _| if x == 0 { Rgb([255, 0, 51]) } else { Rgb([0, 102, 0]) });
        let png = linear(&encode(rgb.into(), ImageFormat::Png));
        assert_eq!((png.width, png.height), (2, 1));
        assert_eq!(png.texels, [[1.0, 0.0, 0.2], [0.0, 0.4, 0.0]]);
        let grey = linear(&encode(GrayImage::from_pixel(1, 1, Luma([51])).into(), ImageFormat::Png));
        // grey takes a way through floating point
        assert!(grey.texels[0].iter().all(|channel| (channel - 0.2).abs() < 1e-7), "{:?}", grey.texels);
        let clear =
            linear(&encode(RgbaImage::from_pixel(1, 1, Rgba([255, 51, 0, 0])).into(), ImageFormat::Png));
        assert_eq!(clear.texels, [[1.0, 0.2, 0.0]]);
        let jpeg = linear(&encode(RgbImage::from_pixel(8, 8, Rgb([255; 3])).into(), ImageFormat::Jpeg));
        assert_eq!(jpeg.texels, vec![[1.0; 3]; 64]);
    }

    #[test]
    fn exr_is_linear_and_may_be_brighter_than_one() {
        let exr = |value: f32| {
            encode(Rgb32FImage::from_pixel(1, 1, Rgb([value, 0.5, 0.0])).into(), ImageFormat::OpenExr)
        };
        let texture = decode(&exr(7.5), TextureFilter::Linear, ColorSpace::Srgb).unwrap();
        assert_eq!(texture.texels, [[7.5, 0.5, 0.0]]);
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            let error = decode(&exr(bad), TextureFilter::Linear, ColorSpace::Srgb).unwrap_err();
            assert!(error.to_string().contains("at least 0"), "{error}");
        }
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let refused =
            |bytes: &[u8]| decode(bytes, TextureFilter::Linear, ColorSpace::Srgb).unwrap_err().to_string();
        assert!(refused(b"").contains("neither PNG"));
        assert!(refused(b"GIF89a\x01\0\x01\0\0\0\0;").contains("neither PNG"));
        let png = encode(RgbImage::new(4, 4).into(), ImageFormat::Png);
        assert!(refused(&png[..png.len() / 2]).starts_with("not usable as a light texture"));
        // a header that speaks of 2^31 texels a side
        let mut large = png;
        large[16..24].copy_from_slice(&[0x7f, 255, 255, 255, 0x7f, 255, 255, 255]);
        assert!(refused(&large).starts_with("not usable as a light texture"));
    }
}
