//! Front-to-back accumulation along each column of froxels (section 3.1.4; Hillaire 2015).

use glam::{DVec3, Vec3};
use media_math::phi;

use crate::lighting::transmittance;
use crate::volume::Volume;
use crate::{Counts, Lit, Slices, parallel};

/// Airlight between the eye and the end of each slice; slice fastest, then column, then row; units: W/(m²·sr).
///
/// Source radiance and density are constant over a slice, and integrated exactly there: it keeps energy whatever the
/// optical depth of a slice. Behind the last froxel that has a value airlight stays what it is.
pub(crate) fn accumulate(volume: &Volume, lit: &[Lit], slices: &Slices, sigma_t: DVec3) -> Vec<Vec3> {
    let columns = volume.reach.len();
    let count = slices.count() as usize;
    let mut ends = vec![Vec3::ZERO; columns * count];
    parallel::rows(&mut ends, count, |column, ends| {
        let (mut airlight, mut path) = (DVec3::ZERO, 0.0);
        for (k, end) in ends.iter_mut().enumerate() {
            let lit = lit[column + columns * k];
            if lit.is_some() {
                let depth = f64::from(slices.depth(k as u32));
                let through = f64::from(lit.density) * depth;
                let mean = DVec3::from_array(sigma_t.to_array().map(|s| phi(s * through)));
                airlight += transmittance(sigma_t, path) * lit.source.as_dvec3() * depth * mean;
                path += through;
            }
            *end = airlight.as_vec3();
        }
        Counts::default()
    });
    ends
}
