//! The surfaces of a picture, lit on the CPU.

use std::time::Instant;

use glam::DVec3;
use ground_truth::{Reference, render_rows};
use scene::Bvh;

use crate::airlight::settings;
use crate::scene_args::Setup;
use crate::technique::Options;
use crate::view_rays::ViewRays;

/// Lit surfaces, and what they cost.
pub(crate) struct Lit {
    /// Row by row from the top, as it arrives at the eye; units: W/(m²·sr).
    pub(crate) radiance: Vec<DVec3>,
    /// Time of lighting them; units: ms.
    pub(crate) ms: f64,
}

/// Lights what the view rays hit, in parallel over rows.
pub(crate) fn run(setup: &Setup, bvh: &Bvh, rays: &ViewRays, options: &Options) -> Lit {
    let started = Instant::now();
    let Setup { scene, medium, lights, .. } = setup;
    let reference = Reference::surfaces(&scene.materials, bvh, medium, lights, settings(setup, options));
    let size = options.size;
    let radiance = render_rows(size, &|_| (), |x, y| {
        let pixel = y as usize * size.0 as usize + x as usize;
        rays.hit(pixel, bvh)
            .map_or(DVec3::ZERO, |hit| reference.surface_radiance(&setup.camera.pixel_ray(x, y, size), &hit))
    });
    Lit { radiance, ms: started.elapsed().as_secs_f64() * 1e3 }
}
