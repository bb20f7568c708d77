//! `compare`: two pictures, one JSON object.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::{Failure, Outcome};
use crate::image_file::{self, Image};
use crate::metrics;

/// Compare two pictures and print the figures as one JSON object.
///
/// Figures: `rel_rmse` = |a-b|/|b|, `nmae` = mean|a-b|/mean b, `p99` (99th percentile of |a-b|/mean b), `max_abs`,
/// `flip`, `nan` (values that are not finite; any makes the exit code 1) and, with --unshadowed, `shadow_err` =
/// |a-b|/|u-b|.
/// A quotient without a value is null.
#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    /// Picture to judge, .npy or .exr
    a: PathBuf,
    /// Reference picture, .npy or .exr
    b: PathBuf,
    /// The reference without shadows, .npy or .exr; adds `shadow_err`
    #[arg(long, value_name = "U")]
    unshadowed: Option<PathBuf>,
    /// PNG of the same size; only pixels that are not black count
    #[arg(long, value_name = "PNG")]
    mask: Option<PathBuf>,
}

/// Prints the figures on stdout. Fails, after printing, when a value is not finite.
pub(crate) fn run(args: &CompareArgs) -> Outcome {
    let a = image_file::read(&args.a)?;
    let b = read_like(&args.b, &args.a, &a)?;
    let unshadowed = args.unshadowed.as_deref().map(|path| read_like(path, &args.b, &b)).transpose()?;
    let mask = args.mask.as_deref().map(|path| read_mask_like(path, &args.b, &b)).transpose()?;

    let figures = metrics::compare(&a, &b, unshadowed.as_ref(), mask.as_deref())?;
    let json = serde_json::to_string(&figures).map_err(Failure::program)?;
    match writeln!(io::stdout(), "{json}") {
        // a reader that has seen enough is no failure
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        written => written.map_err(|error| Failure::program(format_args!("stdout: {error}")))?,
    }
    if figures.nan > 0 {
        let files = [Some(&args.a), Some(&args.b), args.unshadowed.as_ref()].into_iter().flatten();
        let names = files.map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
        return Err(Failure::program(format_args!("{} values are not finite in {names}", figures.nan)));
    }
    Ok(())
}

/// Reads a picture that must have the size of another.
fn read_like(path: &Path, other_path: &Path, other: &Image) -> Outcome<Image> {
    let image = image_file::read(path)?;
    check_size(path, (image.width, image.height), other_path, other)?;
    Ok(image)
}

/// Reads a mask of a picture's size that counts at least one pixel.
fn read_mask_like(path: &Path, other_path: &Path, other: &Image) -> Outcome<Vec<bool>> {
    let mask = image_file::read_mask(path)?;
    check_size(path, (mask.width, mask.height), other_path, other)?;
    if !mask.counted.contains(&true) {
        return Err(Failure::input(format_args!(
            "{}: is black all over, so no pixel counts",
            path.display()
        )));
    }
    Ok(mask.counted)
}

fn check_size(path: &Path, (width, height): (u32, u32), other_path: &Path, other: &Image) -> Outcome {
    if (width, height) == (other.width, other.height) {
        return Ok(());
    }
    Err(Failure::input(format_args!(
        "{} is {width} x {height} pixels, but {} is {} x {}",
        path.display(),
        other_path.display(),
        other.width,
        other.height
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store(folder: &Path, name: &str, width: u32, value: f32) -> PathBuf {
        let path = folder.join(name);
        let pixels = vec![[value; 3]; 2 * width as usize];
        image_file::write(&path, &Image { width, height: 2, pixels }, 0.0).unwrap();
        path
    }

    #[test]
    fn outcomes_carry_the_exit_code() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let a = store(folder, "a.npy", 2, 1.0);
        let same = store(folder, "same.exr", 2, 1.0);
        let wide = store(folder, "wide.npy", 3, 1.0);
        let broken = store(folder, "broken.npy", 2, f32::NAN);
        let mask = store(folder, "mask.png", 2, 0.0);
        let compare = |a: &PathBuf, b: &PathBuf, mask: Option<&PathBuf>| {
            run(&CompareArgs { a: a.clone(), b: b.clone(), unshadowed: None, mask: mask.cloned() })
        };

        compare(&a, &same, None).unwrap();
        let sizes = compare(&a, &wide, None).unwrap_err();
        assert_eq!(sizes.code(), 2);
        assert!(sizes.to_string().contains("a.npy") && sizes.to_string().contains("wide.npy"), "{sizes}");
        let not_finite = compare(&broken, &a, None).unwrap_err();
        assert_eq!(not_finite.code(), 1);
        assert!(not_finite.to_string().contains("12 values"), "{not_finite}");
        let black = compare(&a, &same, Some(&mask)).unwrap_err();
        assert!(black.code() == 2 && black.to_string().contains("mask.png"), "{black}");
    }
}
