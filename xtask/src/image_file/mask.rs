//! Masks: which pixels of a comparison count.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, ImageReader};

use super::checked_size;
use crate::failure::{Failure, Outcome};
use crate::output_file::read_input;

/// A choice of pixels, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Mask {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width` × `height` entries, x fastest; `true` counts.
    pub counted: Vec<bool>,
}

/// Reads a PNG mask: a pixel counts unless it is black. Alpha is ignored.
pub(crate) fn read_mask(path: &Path) -> Outcome<Mask> {
    decode(&read_input(path)?).map_err(|reason| Failure::input(format_args!("{}: {reason}", path.display())))
}

fn decode(bytes: &[u8]) -> Result<Mask, String> {
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let unreadable = |error| format!("not a readable .png mask: {error}");
    let (width, height) = reader().into_dimensions().map_err(unreadable)?;
    let (width, height) = checked_size(width.into(), height.into())?;
    // 16 bits keep the faintest grey from rounding to black; the reader's default limit bounds what it allocates
    let picture = reader().decode().map_err(unreadable)?.into_rgb16();
    let counted = picture.pixels().map(|pixel| pixel.0 != [0; 3]).collect();
    Ok(Mask { width, height, counted })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anything_but_black_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        let picture = image::RgbaImage::from_raw(3, 1, vec![0, 0, 0, 255, 0, 1, 0, 0, 255, 255, 255, 255]);
        picture.unwrap().save(&path).unwrap();
        let mask = read_mask(&path).unwrap();
        assert_eq!(mask, Mask { width: 3, height: 1, counted: vec![false, true, true] });
    }

    #[test]
    fn damaged_masks_are_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        image::GrayImage::new(16, 16).save(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        // the last 12 bytes only say that the file ends
        for length in 0..whole.len() - 12 {
            assert!(decode(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
        std::fs::write(&path, "text").unwrap();
        let failure = read_mask(&path).unwrap_err();
        assert!(failure.code() == 2 && failure.to_string().contains("mask.png"), "{failure}");
    }
}
