//! Lookups in the shadow map, counted by the implementations of the CPU: bisections included, no bound.

use hybrid_march::{BruteForce, FaceBounds, Occluders, ShadowVolume};
use scene::Visibility;
use shadowmap::{Bias, Filter, MapVisibility};

use super::super::measure::{Arena, Setting};
use crate::failure::Outcome;
use crate::technique::{Extruded, Technique};
use crate::volumes::extruded_mesh;

/// Steps with which the march is counted; its lookups are proportional to them.
const COUNTED: u32 = 8;

/// Counts of one scene.
pub(super) struct Lookups {
    /// Pixels in which a face of a shadow volume lies before the surface.
    pub(super) covered: u64,
    /// Lookups of a march of one step in those pixels alone.
    march: f64,
}

impl Lookups {
    /// Finds the covered pixels of a picture and counts the march there.
    pub(super) fn count(arena: &Arena) -> Outcome<Self> {
        let (setup, size) = (&arena.setup, arena.base.size);
        let mesh = extruded_mesh(setup, Extruded::Scene)?;
        let faces: Vec<FaceBounds> = setup
            .lights
            .iter()
            .map(|light| FaceBounds::draw(&ShadowVolume::new(&mesh, light), &setup.camera, size, 1))
            .collect();
        let visibility: &dyn Visibility =
            &MapVisibility::new(&arena.map.maps.maps, Filter::Nearest, Bias::NONE);
        let march = BruteForce {
            medium: &setup.medium,
            lights: &setup.lights,
            occluders: Some(Occluders { visibility, bounds: arena.bvh.bounds() }),
            samples: COUNTED,
            model: setup.model,
        };
        let (mut covered, mut lookups) = (0, 0);
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            let end = arena.rays.end(y as usize * size.0 as usize + x as usize, f64::INFINITY);
            if faces.iter().any(|faces| faces.at(x, y).is_some_and(|face| face.start < end)) {
                covered += 1;
                lookups += march.airlight(&setup.camera.pixel_ray(x, y, size), end).rays;
            }
        }
        Ok(Self { covered, march: lookups as f64 / f64::from(COUNTED) })
    }

    /// Lookups of a setting for each covered pixel: of the march those in covered pixels alone, of the hybrid all, also
    /// those in pixels that merely share a tile with a face.
    pub(super) fn of(&self, arena: &Arena, setting: &Setting) -> Outcome<f64> {
        let samples = setting.options.samples.unwrap_or(setting.technique.default_samples());
        let all = match setting.technique {
            Technique::Hybrid => arena.stage(setting)?.run(Technique::Hybrid)?.rays as f64,
            _ => self.march * f64::from(samples),
        };
        Ok(all / self.covered.max(1) as f64)
    }
}
