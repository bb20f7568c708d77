//! Lights the froxels of a view with the shadows of its frustum and of the grid (section 3.1.3).

use crate::grid::{Grid, Read};
use crate::lighting::{Lighting, Place, checked};
use crate::near::NearMasks;
use crate::needs::bits;
use crate::strongest::bit_of;
use crate::volume::{Setup, Volume};
use crate::{Counts, Lit, parallel};

/// Values of a view's froxels; column fastest, then row, then slice.
pub(crate) fn light_up(
    setup: &Setup<'_>,
    lighting: &Lighting<'_>,
    volume: &Volume,
    near: &NearMasks,
    grid: Option<&Grid>,
) -> (Vec<Lit>, Counts) {
    let [columns, rows, _] = volume.dims();
    let near_slices = setup.froxels.near_volume().1;
    let mut lit = vec![Lit::NONE; volume.needs.len()];
    let counts = parallel::rows(&mut lit, columns as usize, |index, row| {
        let (k, y) = (index as u32 / rows, index as u32 % rows);
        let mut counts = Counts::default();
        for (x, lit) in (0..columns).zip(row) {
            let froxel = [x, y, k];
            if !volume.in_front(setup.slices, froxel) {
                continue;
            }
            let place = place(setup, volume, froxel);
            let density = lighting.density(place.point);
            let needs = volume.needs_of(froxel);
            let mut visibilities = [0.0_f64; 32];
            bits(needs.free).for_each(|light| visibilities[light] = 1.0);
            if k < near_slices && needs.rays != 0 {
                let (mask, chosen) = near.read(setup, volume, froxel);
                for light in bits(needs.rays) {
                    match bit_of(chosen, light) {
                        Some(bit) => visibilities[light] = f64::from(u8::from(mask.lit & bit != 0)),
                        None => counts.dropped += 1,
                    }
                }
            } else {
                for light in bits(needs.rays) {
                    let read =
                        grid.map_or_else(Read::default, |grid| grid.read(setup, k, place.point, light));
                    visibilities[light] = f64::from(read.visibility);
                    counts.missed += u64::from(read.missed);
                    counts.dropped += u64::from(read.dropped);
                }
            }
            let shining = bits(needs.rays | needs.free).map(|light| (light, visibilities[light]));
            let (value, mended) = checked(lighting.source(&place, density, shining), density);
            counts.not_finite += u64::from(mended);
            *lit = value;
        }
        counts
    });
    (lit, counts)
}

fn place(setup: &Setup<'_>, volume: &Volume, [x, y, k]: [u32; 3]) -> Place {
    let layout = &volume.layout;
    let start = |k: u32| f64::from(setup.slices.starts[k as usize]);
    Place {
        eye: layout.eye.as_dvec3(),
        direction: layout.direction(x, y, 1).as_dvec3().normalize(),
        point: setup.point(layout, [x, y, k], 1),
        slice: [start(k), start(k + 1)],
        width: f64::from(layout.tile_width()) * f64::from(setup.slices.distance(k, setup.jitter)),
    }
}
