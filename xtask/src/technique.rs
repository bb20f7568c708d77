//! Rendering one picture with one technique, and what it cost.

use std::time::Instant;

use clap::ValueEnum;
use ground_truth::{Reference, Settings, render_rows};
use hybrid_march::{BruteForce, Occluders};
use scene::{Bvh, BvhVisibility};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::failure::{Failure, Outcome};
use crate::image_file::Image;
use crate::progress::Progress;
use crate::scene_args::Setup;

/// `--technique`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Technique {
    /// Analytic shadows and f64 integration: the reference.
    Exact,
    /// Exact with respect to a shadow map.
    ExactShadowMap,
    /// A march that asks for visibility at every step.
    BruteForce,
    /// Shadow volumes and marching (Wyman and Ramsey).
    Hybrid,
    /// Polygonal light volume (Billeter et al.).
    LightVolume,
    /// Froxels, a shadow ray each (Hillaire).
    Froxel,
    /// Froxels and the shared shadow grid.
    SharedGrid,
}

impl Technique {
    /// The flag's value.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

/// What a picture shows, beside its scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    pub(crate) size: (u32, u32),
    pub(crate) airlight_only: bool,
    pub(crate) shadows_in_medium: bool,
    pub(crate) max_distance: f64,
    /// Steps along a ray for each light, for techniques that march.
    pub(crate) samples: u32,
}

/// A finished picture.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub(crate) image: Image,
    /// Wall time of the render, the hierarchy's construction excluded; units: ms.
    pub(crate) ms: f64,
    /// Steps marched, in all.
    pub(crate) samples: u64,
    /// Shadow rays cast by a march.
    pub(crate) rays: u64,
}

/// Fails if this version does not have the technique, or the technique cannot take the medium.
///
/// `flag` is what asked for it.
pub(crate) fn check(setup: &Setup, technique: Technique, flag: &str) -> Outcome {
    match technique {
        Technique::Exact => Reference::check(&setup.medium).map_err(|refusal| refused(refusal, flag)),
        Technique::BruteForce => Ok(()),
        other => Err(Failure::input(format!(
            "{flag} {}: not in this version, which has exact and brute-force",
            other.name()
        ))),
    }
}

fn refused(refusal: scene::Refusal, flag: &str) -> Failure {
    Failure::input(format!("{flag}: {refusal}"))
}

/// Renders `setup` with `technique`.
///
/// Progress is shown under `label`, and not at all without one.
///
/// Fails as [`check`] does.
pub(crate) fn render(
    setup: &Setup,
    bvh: &Bvh,
    technique: Technique,
    options: &Options,
    label: &str,
) -> Outcome<Picture> {
    check(setup, technique, "--technique")?;
    let settings = Settings {
        airlight_only: options.airlight_only,
        shadows_in_medium: options.shadows_in_medium,
        max_distance: options.max_distance,
        model: setup.model,
    };
    let size = options.size;
    let materials = &setup.scene.materials;
    let progress = Progress::new(label, u64::from(size.1));
    let tick = |rows| progress.inc(rows);
    let started;
    let (pixels, samples, rays) = match technique {
        Technique::Exact => {
            let reference = Reference::new(materials, bvh, &setup.medium, &setup.lights, settings)
                .map_err(|refusal| refused(refusal, "--technique"))?;
            started = Instant::now();
            (reference.render(&setup.camera, size, &tick), 0, 0)
        }
        Technique::BruteForce => {
            let surfaces = Reference::surfaces(materials, bvh, &setup.medium, &setup.lights, settings);
            let visibility = BvhVisibility::new(bvh, &setup.lights);
            let casts = options.shadows_in_medium && !bvh.triangles().is_empty();
            let march = BruteForce {
                medium: &setup.medium,
                lights: &setup.lights,
                occluders: casts.then_some(Occluders { visibility: &visibility, bounds: bvh.bounds() }),
                samples: options.samples,
                model: setup.model,
            };
            let (samples, rays) = (AtomicU64::new(0), AtomicU64::new(0));
            started = Instant::now();
            let pixels = render_rows(size, &tick, |x, y| {
                let ray = setup.camera.pixel_ray(x, y, size);
                let (hit, end) = surfaces.end_of(&ray);
                let marched = march.airlight(&ray, end);
                samples.fetch_add(marched.samples, Ordering::Relaxed);
                rays.fetch_add(marched.rays, Ordering::Relaxed);
                let surface = hit
                    .filter(|_| !options.airlight_only)
                    .map_or(glam::Vec3::ZERO, |hit| surfaces.surface_radiance(&ray, &hit).as_vec3());
                (marched.airlight + surface).to_array()
            });
            (pixels, samples.into_inner(), rays.into_inner())
        }
        other => {
            return check(setup, other, "--technique")
                .and(Err(Failure::program("a technique without a renderer")));
        }
    };
    let ms = started.elapsed().as_secs_f64() * 1e3;
    progress.finish();
    Ok(Picture { image: Image { width: size.0, height: size.1, pixels }, ms, samples, rays })
}

/// What the scene needs: the exact reference, unless its medium has no analytic integral.
pub(crate) fn choose(setup: &Setup) -> (Technique, &'static str) {
    if setup.medium.is_homogeneous() {
        (Technique::Exact, "homogeneous medium: exact shadows and integrals on the CPU")
    } else {
        (Technique::BruteForce, "a medium of varying density or with emission has no analytic integral")
    }
}
