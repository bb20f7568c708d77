//! Pictures, how far they are from each other, and the .npy files that hold them.

use std::path::Path;

/// Linear RGB, row 0 at the top.
pub type Pixels = Vec<[f32; 3]>;

/// ‖a − b‖₂/‖b‖₂ over all channels, with 0/0 = 0.
pub fn rel_rmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    quotient(distance(a, b), norm(b))
}

/// ‖a − b‖₂/‖u − b‖₂: the error as a share of what the shadows change, with 0/0 = 0.
pub fn shadow_err(a: &[[f32; 3]], b: &[[f32; 3]], unshadowed: &[[f32; 3]]) -> f64 {
    quotient(distance(a, b), distance(unshadowed, b))
}

/// ‖b‖₂.
pub fn norm(b: &[[f32; 3]]) -> f64 {
    b.as_flattened().iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt()
}

fn distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    assert_eq!(a.len(), b.len(), "pictures of different sizes");
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum::<f64>().sqrt()
}

fn quotient(x: f64, y: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / y }
}

/// The values of a .npy file of f32 with shape (H, W, 3), and that size as (W, H).
pub fn read_npy(path: &Path) -> (Pixels, (u32, u32)) {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let file = npyz::NpyFile::new(&bytes[..]).unwrap();
    let &[height, width, 3] = file.shape() else { panic!("{:?} is no picture's shape", file.shape()) };
    let values: Vec<f32> = file.into_vec().unwrap();
    (values.as_chunks().0.to_vec(), (u32::try_from(width).unwrap(), u32::try_from(height).unwrap()))
}

/// Writes a picture of `size` = (W, H) as a .npy file of f32.
pub fn write_npy(path: &Path, (width, height): (u32, u32), pixels: &[[f32; 3]]) {
    use npyz::WriterBuilder as _;
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[u64::from(height), u64::from(width), 3])
        .writer(&mut bytes)
        .begin_nd()
        .unwrap();
    writer.extend(pixels.as_flattened().iter().copied()).unwrap();
    writer.finish().unwrap();
    std::fs::write(path, bytes).unwrap();
}
