//! The airlight of a picture by each technique of the CPU: what a frame with fog has beyond one without.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glam::DVec3;
use ground_truth::{Reference, Settings, render_rows};
use hybrid_march::{BruteForce, Occluders};
use scene::{Bvh, BvhVisibility, DRay, Visibility};
use shadowmap::{Bias, ExactShadowMap, Filter, MapVisibility, SurfaceVisibility};

use crate::failure::{Failure, Outcome};
use crate::maps::{MapSurface, Maps};
use crate::scene_args::Setup;
use crate::technique::{self, Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;

/// What the stages before left for the airlight.
pub(crate) struct Stage<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) bvh: &'a Bvh,
    pub(crate) options: &'a Options,
    pub(crate) rays: &'a ViewRays,
    pub(crate) maps: &'a Maps,
    /// Told of every finished row.
    pub(crate) tick: &'a (dyn Fn(u64) + Sync),
}

/// The airlight of all pixels, and what it cost.
#[derive(Debug, Clone, Default)]
pub(crate) struct Airlight {
    /// Row by row from the top; units: W/(m²·sr).
    pub(crate) radiance: Vec<DVec3>,
    /// Wall time, with all that the technique prepares for itself (pyramids), without maps and view rays; units: ms.
    pub(crate) ms: f64,
    /// Steps marched, in all.
    pub(crate) samples: u64,
    /// Times that a march asked for visibility: shadow rays, or lookups.
    pub(crate) rays: u64,
    /// Memory of what was prepared from the maps; units: bytes.
    pub(crate) pyramid_bytes: usize,
    /// Passes on the GPU and their times in ms, where there are any.
    pub(crate) passes: Vec<(String, f64)>,
}

impl Stage<'_> {
    /// The airlight by `technique`.
    ///
    /// Fails as [`technique::check`] does.
    pub(crate) fn run(&self, technique: Technique) -> Outcome<Airlight> {
        let started = Instant::now();
        let found = match technique {
            Technique::Exact => self.exact(self.reference()?),
            Technique::ExactShadowMap => {
                let surface = self.options.map.surface.into();
                let shadows = ExactShadowMap::new(&self.maps.maps, &self.setup.lights, surface, Bias::NONE)
                    .map_err(Failure::program)?;
                let found = self.exact(self.reference()?.with_shadows(&shadows));
                Airlight { pyramid_bytes: shadows.bytes(), ..found }
            }
            Technique::BruteForce => self.brute_force(),
            other => {
                return technique::check(self.setup, other, "--technique")
                    .and(Err(Failure::program("a technique without a renderer")));
            }
        };
        Ok(Airlight { ms: started.elapsed().as_secs_f64() * 1e3, ..found })
    }

    fn reference(&self) -> Outcome<Reference<'_>> {
        let Setup { scene, medium, lights, .. } = self.setup;
        let settings = settings(self.setup, self.options);
        Reference::new(&scene.materials, self.bvh, medium, lights, settings).map_err(Failure::input)
    }

    /// Calls `pixel` with every pixel's ray and where it ends.
    fn rows(&self, pixel: impl Fn(&DRay, f64) -> DVec3 + Sync) -> Vec<DVec3> {
        let (size, far) = (self.options.size, self.options.max_distance);
        render_rows(size, self.tick, |x, y| {
            let end = self.rays.end(y as usize * size.0 as usize + x as usize, far);
            pixel(&self.setup.camera.pixel_ray(x, y, size), end)
        })
    }

    /// Closed forms and quadrature over the pieces that the reference's shadows leave.
    fn exact(&self, reference: Reference<'_>) -> Airlight {
        Airlight { radiance: self.rows(|ray, end| reference.airlight(ray, end)), ..Airlight::default() }
    }

    fn brute_force(&self) -> Airlight {
        let Setup { medium, lights, model, .. } = self.setup;
        let maps = &self.maps.maps;
        let visibility: Box<dyn Visibility + '_> = match (self.options.visibility, self.options.map.surface) {
            (VisibilitySource::Bvh, _) => Box::new(BvhVisibility::new(self.bvh, lights)),
            (VisibilitySource::Map, MapSurface::Step) => {
                Box::new(MapVisibility::new(maps, Filter::Nearest, Bias::NONE))
            }
            (VisibilitySource::Map, surface @ MapSurface::Linear) => {
                Box::new(SurfaceVisibility::new(maps, surface.into(), Bias::NONE))
            }
        };
        let casts = self.options.shadows_in_medium && !self.bvh.triangles().is_empty();
        let march = BruteForce {
            medium,
            lights,
            occluders: casts.then_some(Occluders { visibility: &*visibility, bounds: self.bvh.bounds() }),
            samples: self.options.samples,
            model: *model,
        };
        let (samples, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let radiance = self.rows(|ray, end| {
            let marched = march.airlight(ray, end);
            samples.fetch_add(marched.samples, Ordering::Relaxed);
            rays.fetch_add(marched.rays, Ordering::Relaxed);
            marched.airlight.as_dvec3()
        });
        let (samples, rays) = (samples.into_inner(), rays.into_inner());
        Airlight { radiance, samples, rays, ..Airlight::default() }
    }
}

/// What the exact reference and the surfaces are told.
pub(crate) fn settings(setup: &Setup, options: &Options) -> Settings {
    Settings {
        airlight_only: options.airlight_only,
        shadows_in_medium: options.shadows_in_medium,
        max_distance: options.max_distance,
        model: setup.model,
    }
}
