//! Memory that masks take on a GPU: packed into words of 32 bits along x.

use crate::{Froxels, Lattice, MaskWidth};

/// Rows of `columns` masks in whole words; units: bytes.
fn packed(columns: u64, rows: u64, width: MaskWidth) -> u64 {
    (columns * u64::from(width.bits())).div_ceil(32) * 4 * rows
}

/// A dense grid over all of a lattice; units: bytes.
pub fn dense_bytes(lattice: &Lattice, width: MaskWidth) -> u64 {
    let [x, y, z] = lattice.dims.to_array().map(u64::from);
    packed(x, y * z, width)
}

/// Masks of a view of `size` pixels: those of its shadow frustum, or all of the reference, whose masks count with
/// eight bits; units: bytes.
pub fn near_bytes(froxels: &Froxels, size: (u32, u32)) -> u64 {
    let (side, slices) = froxels.near_volume();
    let cells = |pixels: u32| u64::from(pixels.div_ceil(froxels.tile).div_ceil(side));
    let width = froxels.grid().map_or(MaskWidth::Eight, |grid| grid.lights);
    packed(cells(size.0), cells(size.1) * u64::from(slices), width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SharedGrid;
    use glam::Vec3;
    use scene::Aabb;

    #[test]
    fn the_papers_sizes() {
        // section 4.3: about 27 MB and 0.4 MB
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(100.0) };
        let lattice = SharedGrid::paper(1.0 / 3.0).lattice(&bounds).unwrap();
        let bytes = dense_bytes(&lattice, MaskWidth::Eight);
        assert!((27_000_000..=28_000_000).contains(&bytes), "{bytes}");
        let froxels = Froxels::new(100.0).with_grid(SharedGrid::paper(1.0 / 3.0));
        let bytes = near_bytes(&froxels, (1920, 1080));
        assert_eq!(bytes, 120 * 68 * 43);
        assert!(bytes <= 450_000);
        assert_eq!(near_bytes(&Froxels::new(1.0), (1920, 1080)), 240 * 135 * 128);
    }
}
