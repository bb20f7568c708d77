//! One picture by one technique, stage by stage, and what each stage cost.
//!
//! View rays, shadow maps and surfaces belong to a frame without fog as well. So they are stages of their own, alike for
//! every technique, and a technique's time is that of its airlight alone.

use gpu_backend::{GpuContext, MAX_LIGHTS};
use scene::Bvh;

use crate::airlight::Stage;
use crate::airlight_gpu;
use crate::failure::Outcome;
use crate::froxels::FroxelCost;
use crate::image_file::Image;
use crate::maps::Maps;
use crate::progress::Progress;
use crate::scene_args::Setup;
use crate::surfaces;
use crate::surfaces_gpu;
use crate::technique::{Options, Technique, check};
use crate::view_rays::ViewRays;
use crate::viewers::{self, Viewer};

/// A finished picture; times are wall times in ms, the hierarchy's construction excluded.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub(crate) image: Image,
    /// Time of the technique: all that it adds to a frame without fog, its preparation included.
    pub(crate) ms: f64,
    /// Time of finding where the view rays of all viewers end.
    pub(crate) ms_view_rays: f64,
    /// Time of drawing the shadow maps; absent where none was drawn.
    pub(crate) ms_map: Option<f64>,
    /// Time of lighting the surfaces; absent where they are black.
    pub(crate) ms_surfaces: Option<f64>,
    /// Steps marched, in all.
    pub(crate) samples: u64,
    /// Times that a march asked for visibility: shadow rays, or lookups.
    pub(crate) rays: u64,
    /// The technique's own passes on the GPU with their times in ms.
    pub(crate) gpu_passes: Vec<(String, f64)>,
    /// Memory of the view rays' ends; units: bytes.
    pub(crate) view_ray_bytes: usize,
    /// Memory of the shadow maps; units: bytes.
    pub(crate) map_bytes: usize,
    /// Memory of what the technique prepared from the maps; units: bytes.
    pub(crate) pyramid_bytes: usize,
    /// Of techniques with froxels.
    pub(crate) froxels: Option<FroxelCost>,
    /// Triangles of what the technique made from the maps, where there are any.
    pub(crate) mesh_triangles: Option<u64>,
}

impl Picture {
    /// Time of everything; units: ms.
    pub(crate) fn ms_frame(&self) -> f64 {
        self.ms_view_rays + self.ms_map.unwrap_or(0.0) + self.ms + self.ms_surfaces.unwrap_or(0.0)
    }

    /// The stages that ran, in order, with their times in ms; the technique's own is called `technique`.
    pub(crate) fn passes(&self, technique: &str) -> Vec<(String, f64)> {
        let mut passes = vec![("view rays".to_owned(), self.ms_view_rays)];
        passes.extend(self.ms_map.map(|ms| ("shadow map".into(), ms)));
        if self.gpu_passes.is_empty() {
            passes.push((technique.to_owned(), self.ms));
        }
        passes.extend(self.gpu_passes.iter().cloned());
        passes.extend(self.ms_surfaces.map(|ms| ("surfaces".into(), ms)));
        passes
    }

    /// Memory of everything that the frame held, the hierarchy excluded; units: bytes.
    pub(crate) fn bytes(&self) -> usize {
        let image = size_of_val(&*self.image.pixels);
        let froxels = self.froxels.map_or(0, |cost| cost.bytes as usize);
        image + self.view_ray_bytes + self.map_bytes + self.pyramid_bytes + froxels
    }
}

/// Whether shadow maps are drawn for a picture; what no light is scattered by shows no shadow.
pub(crate) fn draws_maps(setup: &Setup, technique: Technique, options: &Options) -> bool {
    let visible = options.shadows_in_medium && !setup.medium.coefficients.is_clear();
    visible && technique.reads_maps(options.visibility)
}

/// Renders `setup` with `technique`, its airlight and surfaces on `gpu` if one is given.
///
/// Progress is shown under `label`, and not at all without one.
///
/// Fails as [`check`] does, if a shadow map cannot be drawn, and if the GPU cannot hold the frame.
pub(crate) fn render(
    setup: &Setup,
    bvh: &Bvh,
    technique: Technique,
    options: &Options,
    gpu: Option<&GpuContext>,
    label: &str,
) -> Outcome<Picture> {
    check(setup, technique, "--technique")?;
    let options = &options.of(technique);
    let rays = ViewRays::trace(&setup.camera, bvh, options.size);
    let near = options.froxels.range.map(|range| rays.up_to(range));
    let further = further_viewers(setup, bvh, technique, options);
    let maps = if draws_maps(setup, technique, options) {
        Maps::draw(setup, &options.map)?
    } else {
        Maps::none(setup.lights.len())
    };
    // neither a GPU nor froxels have rows to tell of, and what they cannot hold is refused in one line
    let silent = gpu.is_some() || technique.has_froxels();
    let progress = Progress::new(if silent { "" } else { label }, u64::from(options.size.1));
    let tick = |rows| progress.inc(rows);
    let stage = Stage {
        setup,
        bvh,
        options,
        rays: near.as_ref().unwrap_or(&rays),
        maps: &maps,
        further: &further,
        tick: &tick,
    };
    let airlight = match gpu {
        Some(gpu) => airlight_gpu::run(gpu, &stage, technique)?,
        None => stage.run(technique)?,
    };
    let lit = match gpu {
        _ if options.airlight_only => None,
        // froxels take more lights than surfaces do there
        Some(gpu) if setup.lights.len() <= MAX_LIGHTS && !options.surfaces_on_cpu => {
            Some(surfaces_gpu::run(gpu, setup, bvh, &rays, options.size)?)
        }
        _ => Some(surfaces::run(setup, bvh, &rays, options)),
    };
    let mut radiance = airlight.radiance;
    if let Some(lit) = &lit {
        radiance.iter_mut().zip(&lit.radiance).for_each(|(sum, &surface)| *sum += surface);
    }
    let pixels = radiance.into_iter().map(|pixel| pixel.as_vec3().to_array()).collect();
    progress.finish();
    Ok(Picture {
        image: Image { width: options.size.0, height: options.size.1, pixels },
        ms: airlight.ms,
        ms_view_rays: rays.ms + further.iter().map(|viewer| viewer.rays.ms).sum::<f64>(),
        ms_map: maps.any().then_some(maps.ms),
        ms_surfaces: lit.map(|lit| lit.ms),
        samples: airlight.samples,
        rays: airlight.rays,
        gpu_passes: airlight.passes,
        view_ray_bytes: rays.bytes() + further.iter().map(|viewer| viewer.rays.bytes()).sum::<usize>(),
        map_bytes: maps.bytes(),
        pyramid_bytes: airlight.pyramid_bytes,
        froxels: airlight.froxels,
        mesh_triangles: airlight.mesh_triangles,
    })
}

/// The viewers beside the first that the options ask for, if the technique takes any.
fn further_viewers(setup: &Setup, bvh: &Bvh, technique: Technique, options: &Options) -> Vec<Viewer> {
    let count = options.froxels.viewers as usize;
    if count < 2 || !technique.has_froxels() {
        return Vec::new();
    }
    let cameras = viewers::scattered(&setup.cameras(), bvh, count).into_iter().skip(1);
    let mut all: Vec<Viewer> = cameras.map(|camera| Viewer::new(camera, bvh, options.size)).collect();
    if let Some(range) = options.froxels.range {
        all.iter_mut().for_each(|viewer| viewer.rays = viewer.rays.up_to(range));
    }
    all
}
