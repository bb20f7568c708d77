//! The airlight of a picture by each technique of the CPU: what a frame with fog has beyond one without.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glam::DVec3;
use ground_truth::{Reference, Settings, render_rows};
use hybrid_march::{
    Adaptive, BruteForce, FaceBounds, Hybrid, LightMips, LowResolution, Marched, Occluders, Sampling,
    ShadowVolume,
};
use lightvolume::{LightVolume, LightVolumes};
use rayon::prelude::*;
use scene::{Bvh, BvhVisibility, DRay, Interval, Light, Visibility};
use shadowmap::{Bias, DepthMap, ExactShadowMap, Filter, MapVisibility, SurfaceVisibility};

use crate::failure::{Failure, Outcome};
use crate::froxels::{self, FroxelCost};
use crate::maps::{MapSurface, Maps};
use crate::scene_args::Setup;
use crate::technique::{Extruded, Options, Technique, VisibilitySource};
use crate::view_rays::ViewRays;
use crate::viewers::Viewer;
use crate::volumes::extruded_mesh;

/// What the stages before left for the airlight.
#[derive(Clone, Copy)]
pub(crate) struct Stage<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) bvh: &'a Bvh,
    pub(crate) options: &'a Options,
    pub(crate) rays: &'a ViewRays,
    pub(crate) maps: &'a Maps,
    /// Viewers beside the first, for techniques that take any.
    pub(crate) further: &'a [Viewer],
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
    /// What of that goes by view rays, where it is known; the rest is prepared, whatever their number. Units: ms.
    pub(crate) rays_ms: f64,
    /// Steps marched, in all.
    pub(crate) samples: u64,
    /// Times that a march asked for visibility: shadow rays, or lookups.
    pub(crate) rays: u64,
    /// Memory of what was prepared from the maps; units: bytes.
    pub(crate) pyramid_bytes: usize,
    /// Triangles of what was made from the maps, where there are any.
    pub(crate) mesh_triangles: Option<u64>,
    /// Of techniques with froxels.
    pub(crate) froxels: Option<FroxelCost>,
    /// Passes on the GPU and their times in ms, where there are any.
    pub(crate) passes: Vec<(String, f64)>,
}

impl Stage<'_> {
    /// The airlight by `technique`.
    ///
    /// Fails as [`check`](crate::technique::check) does.
    pub(crate) fn run(&self, technique: Technique) -> Outcome<Airlight> {
        let started = Instant::now();
        let found = match technique {
            Technique::Exact => self.exact(self.reference()?, technique)?,
            Technique::ExactShadowMap => {
                let surface = self.options.map.surface.into();
                let shadows = ExactShadowMap::new(&self.maps.maps, &self.setup.lights, surface, Bias::NONE)
                    .map_err(Failure::program)?;
                let found = self.exact(self.reference()?.with_shadows(&shadows), technique)?;
                Airlight { pyramid_bytes: shadows.bytes(), ..found }
            }
            Technique::BruteForce => self.brute_force()?,
            Technique::Hybrid => self.hybrid()?,
            Technique::LightVolume => self.light_volume()?,
            // its time is that of the frame, without the hierarchy
            Technique::Froxel | Technique::SharedGrid => return froxels::airlight(self, technique, None),
        };
        Ok(Airlight { ms: ms_since(started), ..found })
    }

    fn reference(&self) -> Outcome<Reference<'_>> {
        let Setup { scene, medium, lights, .. } = self.setup;
        let settings = settings(self.setup, self.options);
        Reference::new(&scene.materials, self.bvh, medium, lights, settings).map_err(Failure::input)
    }

    /// Calls `pixel` with every pixel's column, row and ray, and where it ends.
    fn rows(&self, pixel: impl Fn(u32, u32, &DRay, f64) -> DVec3 + Sync) -> Vec<DVec3> {
        let (size, far) = (self.options.size, self.options.max_distance);
        render_rows(size, self.tick, |x, y| {
            let end = self.rays.end(y as usize * size.0 as usize + x as usize, far);
            pixel(x, y, &self.setup.camera.pixel_ray(x, y, size), end)
        })
    }

    /// The airlight of all pixels, from that of those which the options say.
    fn picture(
        &self,
        technique: Technique,
        pixel: impl Fn(u32, u32, &DRay, f64) -> DVec3 + Sync,
    ) -> Outcome<Vec<DVec3>> {
        match technique.sampling(self.options.sampling) {
            Sampling::Blocks { scale, .. } if scale > 1 => self.blocks(pixel),
            Sampling::Adaptive(adaptive) => self.adaptive(&adaptive, pixel),
            Sampling::Pixels | Sampling::Blocks { .. } => Ok(self.rows(pixel)),
        }
    }

    /// The airlight of the pixels around which it changes, and from theirs that of the others.
    fn adaptive(
        &self,
        adaptive: &Adaptive,
        pixel: impl Fn(u32, u32, &DRay, f64) -> DVec3 + Sync,
    ) -> Outcome<Vec<DVec3>> {
        let (size, camera, far) = (self.options.size, &self.setup.camera, self.options.max_distance);
        let ends: Vec<f32> =
            (0..self.rays.ends.len()).map(|index| self.rays.end(index, far) as f32).collect();
        let of = |pixels: &[(u32, u32)], pixel: &(dyn Fn(u32, u32, &DRay, f64) -> DVec3 + Sync)| {
            let at = |&(x, y): &(u32, u32)| {
                let end = self.rays.end(y as usize * size.0 as usize + x as usize, far);
                pixel(x, y, &camera.pixel_ray(x, y, size), end)
            };
            pixels.par_iter().map(at).collect()
        };
        let Setup { medium, lights, model, .. } = self.setup;
        let samples = self.options.samples.unwrap_or(Technique::BruteForce.default_samples());
        // in closed form where there is one
        let open = BruteForce { medium, lights, occluders: None, samples, model: *model };
        let unlit = |_: u32, _: u32, ray: &DRay, end| open.airlight(ray, end).airlight.as_dvec3();
        let (picture, _) = adaptive
            .picture(size, &ends, |pixels| of(pixels, &pixel), |pixels| of(pixels, &unlit))
            .map_err(Failure::input)?;
        (self.tick)(size.1.into());
        Ok(picture)
    }

    /// The same for blocks of pixels in two layers, spread over the pixels by their depth.
    fn blocks(&self, pixel: impl Fn(u32, u32, &DRay, f64) -> DVec3 + Sync) -> Outcome<Vec<DVec3>> {
        let (size, scale, camera) = (self.options.size, self.options.sampling.scale(), &self.setup.camera);
        let low = LowResolution::new(size, scale).map_err(Failure::input)?;
        let far = self.options.max_distance as f32;
        let full: Vec<f32> =
            self.rays.ends.iter().map(|&end| if end.is_finite() { end } else { far }).collect();
        let ends = low.ends(camera, &full).map_err(Failure::program)?;
        let columns = low.low_size().0 as usize;
        let mut layers = Vec::new();
        for (ends, rows) in ends.iter().zip([self.tick, &|_| ()]) {
            let layer = render_rows(low.low_size(), rows, |x, y| {
                let end = f64::from(ends[y as usize * columns + x as usize]);
                let middle = |at: u32, most: u32| (at * scale + scale / 2).min(most - 1);
                if end == 0.0 {
                    return DVec3::ZERO;
                }
                pixel(middle(x, size.0), middle(y, size.1), &low.low_ray(camera, x, y), end)
            });
            layers.push(layer.into_iter().map(|value| value.as_vec3()).collect::<Vec<_>>());
        }
        let low_ends = [&ends[0][..], &ends[1][..]];
        let picture =
            low.upsample(camera, &full, low_ends, [&layers[0], &layers[1]]).map_err(Failure::program)?;
        if !matches!(self.options.sampling, Sampling::Blocks { anew_at_edges: true, .. }) {
            return Ok(picture.into_iter().map(|value| value.as_dvec3()).collect());
        }
        let edges = low.edges(camera, &full, low_ends).map_err(Failure::program)?;
        Ok(render_rows(size, &|_| (), |x, y| {
            let index = y as usize * size.0 as usize + x as usize;
            if edges[index] {
                let end = self.rays.end(index, self.options.max_distance);
                pixel(x, y, &camera.pixel_ray(x, y, size), end)
            } else {
                picture[index].as_dvec3()
            }
        }))
    }

    /// Closed forms and quadrature over the pieces that the reference's shadows leave.
    fn exact(&self, reference: Reference<'_>, technique: Technique) -> Outcome<Airlight> {
        let started = Instant::now();
        let radiance = self.picture(technique, |_, _, ray, end| reference.airlight(ray, end))?;
        Ok(Airlight { radiance, rays_ms: ms_since(started), ..Airlight::default() })
    }

    /// What a march asks.
    fn visibility(&self) -> Box<dyn Visibility + '_> {
        let maps = &self.maps.maps;
        match (self.options.visibility, self.options.map.surface) {
            (VisibilitySource::Bvh, _) => Box::new(BvhVisibility::new(self.bvh, &self.setup.lights)),
            (VisibilitySource::Map, MapSurface::Step) => {
                Box::new(MapVisibility::new(maps, Filter::Nearest, Bias::NONE))
            }
            (VisibilitySource::Map, surface @ MapSurface::Linear) => {
                Box::new(SurfaceVisibility::new(maps, surface.into(), Bias::NONE))
            }
        }
    }

    /// The same integrals over the pieces between the crossings of light volumes.
    fn light_volume(&self) -> Outcome<Airlight> {
        let volumes = light_volumes(self)?;
        let shadows = LightVolumes::new(&volumes, &self.setup.lights).map_err(Failure::program)?;
        let found = self.exact(self.reference()?.with_shadows(&shadows), Technique::LightVolume)?;
        let meshes = volumes.iter().flatten();
        let bytes = meshes.clone().map(LightVolume::bytes).sum::<usize>() + shadows.bytes();
        let triangles = meshes.map(|volume| volume.triangles().len() as u64).sum();
        Ok(Airlight { pyramid_bytes: bytes, mesh_triangles: Some(triangles), ..found })
    }

    fn occluders<'v>(&self, visibility: &'v dyn Visibility) -> Option<Occluders<'v>> {
        let casts = self.options.shadows_in_medium && !self.bvh.triangles().is_empty();
        casts.then_some(Occluders { visibility, bounds: self.bvh.bounds() })
    }

    fn brute_force(&self) -> Outcome<Airlight> {
        let Setup { medium, lights, model, .. } = self.setup;
        let visibility = self.visibility();
        let march = BruteForce {
            medium,
            lights,
            occluders: self.occluders(&*visibility),
            samples: self.options.samples.unwrap_or(Technique::BruteForce.default_samples()),
            model: *model,
        };
        self.marched(Technique::BruteForce, |_, _, ray, end| march.airlight(ray, end))
    }

    fn hybrid(&self) -> Outcome<Airlight> {
        let Setup { medium, lights, model, camera, .. } = self.setup;
        let options = &self.options.hybrid;
        let samples = self.options.samples.unwrap_or(Technique::Hybrid.default_samples());
        let visibility = self.visibility();
        let occluders = self.occluders(&*visibility);
        let mut bounds = Vec::new();
        if occluders.is_some() {
            let mesh = extruded_mesh(self.setup, options.extruded)?;
            let tile = options.tile.max(self.options.sampling.scale());
            for (light, map) in lights.iter().zip(&self.maps.maps) {
                let volume = ShadowVolume::new(&mesh, light);
                let margin = if tile > 1 {
                    map.as_ref().map_or(0.0, |map| map.projection().texel(map.size()))
                } else {
                    0.0
                };
                bounds.push(FaceBounds::draw_with_margin(&volume, camera, self.options.size, tile, margin));
            }
        }
        let mips: Vec<Option<LightMips>> = lights
            .iter()
            .map(|light| match (light, options.mips) {
                (Light::Spot(spot), Some(blur)) => {
                    spot.texture.as_ref().map(|picture| LightMips::new(picture, blur))
                }
                _ => None,
            })
            .collect();
        let mut march = Hybrid::new(medium, lights, occluders, samples, options.refine, *model)
            .map_err(Failure::input)?;
        march.lit_samples = options.lit_samples(samples);
        march.placement = options.placement(*model);
        march.mips = &mips;
        march.partial = matches!(options.extruded, Extruded::RestAsTexture(_));
        let (size, forward) = (self.options.size, camera.forward.as_dvec3());
        self.marched(Technique::Hybrid, |x, y, ray, end| {
            // the distances of faces belong to the pixel's own ray
            let own = camera.pixel_ray(x, y, size);
            let stretch = own.direction.dot(forward) / ray.direction.dot(forward);
            let face = |bounds: &FaceBounds| {
                let found = bounds.at(x, y)?;
                Some(Interval::new(found.start * stretch, found.end * stretch))
            };
            let faces: Vec<Option<Interval>> = bounds.iter().map(face).collect();
            march.airlight(ray, end, &faces)
        })
    }

    /// The airlight of a march, with its costs.
    fn marched(
        &self,
        technique: Technique,
        march: impl Fn(u32, u32, &DRay, f64) -> Marched + Sync,
    ) -> Outcome<Airlight> {
        let (samples, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let pixel = |x, y, ray: &DRay, end| {
            let marched = march(x, y, ray, end);
            samples.fetch_add(marched.samples, Ordering::Relaxed);
            rays.fetch_add(marched.rays, Ordering::Relaxed);
            marched.airlight.as_dvec3()
        };
        let started = Instant::now();
        let radiance = self.picture(technique, pixel)?;
        let (samples, rays) = (samples.into_inner(), rays.into_inner());
        Ok(Airlight { radiance, samples, rays, rays_ms: ms_since(started), ..Airlight::default() })
    }
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// The light volume of every light with a map, tessellated as the options say.
pub(crate) fn light_volumes(stage: &Stage<'_>) -> Outcome<Vec<Option<LightVolume>>> {
    let tessellation = stage.options.tessellation.of_scene(stage.bvh.bounds().diagonal());
    let options = lightvolume::Options::new(tessellation);
    let build = |map: &DepthMap| LightVolume::build(map, &options);
    let volumes = stage.maps.maps.iter().map(|map| map.as_ref().map(build).transpose());
    volumes.collect::<Result<_, _>>().map_err(|e| Failure::input(format!("--tessellation: {e}")))
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
