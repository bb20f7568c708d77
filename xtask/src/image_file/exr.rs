//! OpenEXR files, through the `image` crate.

use std::io::{self, Cursor};

use image::codecs::openexr::{OpenExrDecoder, OpenExrEncoder};
use image::{ExtendedColorType, ImageDecoder, ImageEncoder};

use super::{Image, checked_size};

/// Most pixels that one byte of a compressed file is believed to hold.
///
/// deflate shrinks at most 1032 times and a half-float pixel has 6 bytes, so 172 is what a constant picture reaches;
/// the decoder allocates by the header alone, and this keeps a damaged one from asking for gigabytes.
const MAX_PIXELS_PER_BYTE: u64 = 1024;

/// Decodes the first RGB layer; the error is the part of a sentence that follows the file's name.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let unreadable = |error| format!("not a readable .exr file: {error}");
    let decoder =
        OpenExrDecoder::with_alpha_preference(Cursor::new(bytes), Some(false)).map_err(unreadable)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = checked_size(width.into(), height.into())?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > bytes.len() as u64 * MAX_PIXELS_PER_BYTE {
        return Err(format!("{width} x {height} pixels cannot be in {} bytes", bytes.len()));
    }
    let mut samples = vec![0; pixels as usize * 3 * size_of::<f32>()];
    decoder.read_image(&mut samples).map_err(unreadable)?;

    // the decoder gives native-endian floats, three a pixel since alpha was declined
    let (samples, _) = samples.as_chunks::<{ size_of::<f32>() }>();
    let (pixels, _) = samples.as_chunks::<3>();
    let pixels = pixels.iter().map(|pixel| pixel.map(f32::from_ne_bytes)).collect();
    Ok(Image { width, height, pixels })
}

/// float32 RGB.
pub(super) fn encode(image: &Image) -> io::Result<Vec<u8>> {
    let samples: Vec<u8> = image.pixels.iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
    let mut file = Cursor::new(Vec::new());
    OpenExrEncoder::new(&mut file)
        .write_image(&samples, image.width, image.height, ExtendedColorType::Rgb32F)
        .map_err(io::Error::other)?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Image {
        let pixels = (0..40).map(|i| [i as f32, 1.0 / (1 + i) as f32, f32::NAN]).collect();
        Image { width: 8, height: 5, pixels }
    }

    #[test]
    fn bits_survive_a_round_trip() {
        let read = decode(&encode(&sample()).unwrap()).unwrap();
        assert_eq!((read.width, read.height), (8, 5));
        let bits = |image: &Image| image.pixels.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&sample()));
    }

    #[test]
    fn no_prefix_of_a_file_reads_or_panics() {
        let whole = encode(&sample()).unwrap();
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
    }

    #[test]
    fn no_changed_byte_panics() {
        let whole = encode(&sample()).unwrap();
        for position in 0..whole.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[position] = value;
                // either reading is right as long as it comes back
                let _ = decode(&bytes);
            }
        }
    }
}
