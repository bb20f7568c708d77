//! Linear RGB pictures and the files that hold them.
//!
//! `.npy` and `.exr` keep the radiance itself and can be read back; `.png` is for looking at. The extension decides,
//! in either case of letters. Whatever a file holds, reading it ends in a picture or in one line that names the file.

mod display;
mod error_picture;
mod exr;
mod mask;
mod npy;

use std::path::Path;

pub(crate) use display::{Image8, encode_png, to_srgb8};
pub(crate) use error_picture::{ERROR_SCALE_ENDS, error_picture, scale_colour};
pub(crate) use mask::read_mask;

use crate::failure::{Failure, Outcome};
use crate::output_file;

/// More pixels than this are taken for a damaged header. It is also what FLIP's 32-bit sizes can index.
const MAX_PIXELS: u64 = 1 << 28;

/// Linear RGB radiance, W m⁻² sr⁻¹, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width` × `height` pixels, x fastest.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// Whether both pictures have the same width and height.
    pub(crate) fn same_size(&self, other: &Self) -> bool {
        (self.width, self.height) == (other.width, other.height)
    }
}

/// What a file extension stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Npy,
    Exr,
    Png,
}

impl Format {
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "npy" => Some(Self::Npy),
            "exr" => Some(Self::Exr),
            "png" => Some(Self::Png),
            _ => None,
        }
    }
}

/// Reads a linear picture from `.npy` or `.exr`.
///
/// `.npy` holds float32 or float64 of shape (H, W, 3), or (H, W) and (H, W, 1) for grey, in any byte and axis order;
/// float64 is rounded.
pub(crate) fn read(path: &Path) -> Outcome<Image> {
    match Format::of(path) {
        Some(Format::Npy) => npy::decode(&output_file::read_input(path)?),
        Some(Format::Exr) => exr::decode(&output_file::read_input(path)?),
        _ => {
            return Err(Failure::input(format_args!(
                "{}: a picture to read is .npy or .exr",
                path.display()
            )));
        }
    }
    .map_err(|reason| Failure::input(format_args!("{}: {reason}", path.display())))
}

/// Fails unless `path` can be written and has a picture's extension; leaves nothing behind. For calling before long work.
pub(crate) fn check_writable(path: &Path) -> Outcome {
    format_to_write(path)?;
    output_file::check_writable(path)
}

/// The bytes of a picture file, by the extension of `path`.
///
/// `.npy` is little-endian float32, shape (H, W, 3), C order; `.exr` is float32 RGB; `.png` is 8-bit
/// sRGB(clamp(2^`exposure_ev` · L)). The exposure does not touch the other two.
pub(crate) fn encode(path: &Path, image: &Image, exposure_ev: f32) -> Outcome<Vec<u8>> {
    let failed = |error| Failure::program(format_args!("{}: {error}", path.display()));
    match format_to_write(path)? {
        Format::Npy => npy::encode(image).map_err(failed),
        Format::Exr => exr::encode(image).map_err(failed),
        Format::Png => encode_png(&to_srgb8(image, exposure_ev.exp2())),
    }
}

/// Writes a picture by extension.
#[cfg(test)]
pub(crate) fn write(path: &Path, image: &Image, exposure_ev: f32) -> Outcome {
    output_file::write_bytes(path, &encode(path, image, exposure_ev)?)
}

fn format_to_write(path: &Path) -> Outcome<Format> {
    Format::of(path).ok_or_else(|| {
        Failure::input(format_args!("{}: a picture to write is .png, .exr or .npy", path.display()))
    })
}

/// Width and height as stored, once they are known to be a picture's.
fn checked_size(width: u64, height: u64) -> Result<(u32, u32), String> {
    let refused = || format!("{width} x {height} pixels; a picture has 1 to {MAX_PIXELS}");
    let pixels = width.checked_mul(height).ok_or_else(refused)?;
    if pixels == 0 || pixels > MAX_PIXELS {
        return Err(refused());
    }
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(refused()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Image {
        let pixels = (0..6).map(|i| [i as f32, 0.5 * i as f32, 1e-7 * i as f32]).collect();
        Image { width: 3, height: 2, pixels }
    }

    #[test]
    fn linear_pictures_survive_a_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.npy", "a.exr", "A.NPY"] {
            let path = folder.path().join(name);
            check_writable(&path).unwrap();
            write(&path, &sample(), 3.0).unwrap();
            assert_eq!(read(&path).unwrap(), sample(), "{name}");
        }
    }

    #[test]
    fn png_is_exposed_srgb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image =
            Image { width: 2, height: 1, pixels: vec![[0.125, 0.0, 9.0], [f32::INFINITY, -1.0, 0.25]] };
        write(&path, &image, 1.0).unwrap();
        let shown = image::open(&path).unwrap().into_rgb8();
        // sRGB(0.25) = 1.055 · 0.25^(1/2.4) − 0.055 = 0.5371 → 137; sRGB(0.5) = 0.7354 → 188
        assert_eq!(shown.get_pixel(0, 0).0, [137, 0, 255]);
        assert_eq!(shown.get_pixel(1, 0).0, [255, 0, 188]);
    }

    #[test]
    fn unknown_extensions_name_file_and_choice() {
        for path in ["a.tiff", "a", "npy", "a.jpg"].map(Path::new) {
            let failure = check_writable(path).unwrap_err();
            assert_eq!(failure.code(), 2);
            assert!(failure.to_string().contains(".png, .exr or .npy"), "{failure}");
            assert_eq!(read(path).unwrap_err().code(), 2);
        }
        assert!(read(Path::new("a.png")).unwrap_err().to_string().contains("a.png"));
    }

    #[test]
    fn missing_files_and_folders_are_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("folder.npy")).unwrap();
        for name in ["absent.npy", "absent.exr", "folder.npy"] {
            let failure = read(&folder.path().join(name)).unwrap_err();
            assert_eq!(failure.code(), 2);
            assert!(failure.to_string().contains(name), "{failure}");
        }
    }
}
