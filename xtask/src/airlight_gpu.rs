//! The airlight of a picture on the GPU: the same stage as on the CPU, from the same view rays and the same maps.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3};
use gpu_backend::{
    Faces, Fog, FogDescriptor, Frame, GpuBvh, GpuContext, Lamp, LightMesh, LightPicture, Lookup, MAX_LIGHTS,
    PassTime, ReadError, Sampling, SceneDepth, ShadowCasters, ShadowMap, ShadowVolume, Shadows, View,
};
use scene::{AirlightModel, Light, WideBvh};
use shadowmap::Bias;

use crate::airlight::{Airlight, Stage, light_volumes};
use crate::failure::{Failure, Outcome};
use crate::froxels;
use crate::gpu;
use crate::maps::MapSurface;
use crate::scene_args::Setup;
use crate::technique::{Extruded, HybridOptions, Technique, Tessellation, VisibilitySource};
use crate::volumes;

/// Why the GPU cannot do what is asked, if so; the CPU can.
pub(crate) fn lacks(setup: &Setup, technique: Technique) -> Option<String> {
    if setup.lights.len() > MAX_LIGHTS && !technique.has_froxels() {
        return Some(format!("{} lights, and {MAX_LIGHTS} fit on the GPU", setup.lights.len()));
    }
    match technique {
        Technique::BruteForce
        | Technique::Hybrid
        | Technique::LightVolume
        | Technique::Froxel
        | Technique::SharedGrid => None,
        Technique::ExactShadowMap => {
            let local = setup.lights.iter().any(|light| !matches!(light, Light::Directional(_)));
            if setup.medium.bounds.is_some() {
                Some(
                    "exact-shadow-map on the GPU cannot take a bounded medium; use brute-force, or the CPU"
                        .into(),
                )
            } else if local && setup.model == AirlightModel::HoffmanPreetham {
                Some("exact-shadow-map on the GPU cannot take Hoffman and Preetham's model for a local light; use brute-force, or the CPU".into())
            } else {
                None
            }
        }
        Technique::Exact => Some("exact runs on the CPU alone".into()),
    }
}

/// A frame that stays on the GPU, to be rendered as often as its time is asked for.
pub(crate) struct GpuFrame<'a> {
    gpu: &'a GpuContext,
    fog: Fog,
    stage: &'a Stage<'a>,
    technique: gpu_backend::Technique,
    sampling: Sampling,
    maps: Vec<Option<ShadowMap>>,
    bvh: Option<GpuBvh>,
    /// Of each light, for techniques that use them.
    volumes: Vec<ShadowVolume>,
    casts: bool,
}

/// One rendering of a frame.
pub(crate) struct GpuTimes {
    /// All that the technique does; the GPU's own clock where it is one of hardware, else the wall clock; units: ms.
    pub(crate) ms: f64,
    /// Each pass by itself, where the device has time stamps.
    pub(crate) passes: Vec<PassTime>,
}

impl<'a> GpuFrame<'a> {
    /// Uploads what the stage has and prepares the frame.
    ///
    /// Fails if the device cannot hold it.
    pub(crate) fn new(gpu: &'a GpuContext, stage: &'a Stage<'a>, technique: Technique) -> Outcome<Self> {
        let options = stage.options;
        let surface = options.map.surface;
        let lookup = match surface {
            MapSurface::Step => Lookup::Nearest,
            MapSurface::Linear => Lookup::LinearSurface,
        };
        let samples = options.samples.unwrap_or(technique.default_samples());
        let sampling = technique.sampling(options.sampling);
        let hybrid = technique == Technique::Hybrid;
        let bvh_diagonal = stage.bvh.bounds().diagonal();
        let technique = match technique {
            Technique::ExactShadowMap => gpu_backend::Technique::ExactShadowMap { surface: surface.into() },
            Technique::Hybrid => {
                gpu_backend::Technique::Hybrid(hybrid_of(&options.hybrid, stage.setup.model, samples, lookup))
            }
            Technique::LightVolume => gpu_backend::Technique::LightVolume {
                tessellation: tessellation_of(options.tessellation, bvh_diagonal),
                kept: options.kept,
            },
            _ => gpu_backend::Technique::BruteForce { samples, lookup },
        };
        let upload = |map: &shadowmap::DepthMap| {
            ShadowMap::upload(&gpu.device, &gpu.queue, map, Bias::NONE)
                .map_err(|e| Failure::input(format!("--shadow-map {}: {e}", options.map.side)))
        };
        let maps = stage.maps.maps.iter().map(|map| map.as_ref().map(upload).transpose());
        let mut maps = maps.collect::<Outcome<Vec<_>>>()?;
        let by_mesh = gpu_backend::Tessellation::Mesh;
        if matches!(technique, gpu_backend::Technique::LightVolume { tessellation, .. } if tessellation == by_mesh)
        {
            add_meshes(gpu, stage, &mut maps)?;
        }
        let casts = options.shadows_in_medium && !stage.bvh.triangles().is_empty();
        let march = matches!(
            technique,
            gpu_backend::Technique::BruteForce { .. } | gpu_backend::Technique::Hybrid(_)
        );
        let bvh = if casts && march && options.visibility == VisibilitySource::Bvh {
            let wide = WideBvh::build(&stage.setup.scene).map_err(Failure::input)?;
            Some(GpuBvh::upload(&gpu.device, &wide).map_err(Failure::input)?)
        } else {
            None
        };
        let volumes = if casts && hybrid { volumes(gpu, stage)? } else { Vec::new() };
        let descriptor = FogDescriptor { pipelines: Some(&gpu.pipelines), ..FogDescriptor::default() };
        let fog = Fog::new(&gpu.device, &descriptor).map_err(Failure::program)?;
        let mut frame = Self { gpu, fog, stage, technique, sampling, maps, bvh, volumes, casts };
        frame.prepare()?;
        Ok(frame)
    }

    fn prepare(&mut self) -> Outcome {
        let Stage { setup, bvh, options, rays, .. } = self.stage;
        let casters = bvh.bounds();
        let lamps: Vec<Lamp<'_>> = setup
            .lights
            .iter()
            .zip(&self.maps)
            .enumerate()
            .map(|(index, (light, map))| {
                let by_map = map.as_ref().map(|map| Shadows::Map { map, casters });
                let by_rays = self.bvh.as_ref().map(|bvh| Shadows::Rays { bvh, casters });
                let shadows = if self.casts { by_rays.or(by_map) } else { None };
                Lamp { light, shadows, volume: self.volumes.get(index) }
            })
            .collect();
        let view = View {
            camera: &setup.camera,
            size: options.size,
            depth: SceneDepth::Distances(&rays.ends),
            max_distance: options.max_distance,
        };
        let frame = Frame {
            views: &[view],
            medium: &setup.medium,
            lamps: &lamps,
            model: setup.model,
            technique: self.technique,
            sampling: self.sampling,
        };
        self.fog.prepare(&self.gpu.device, &self.gpu.queue, &frame).map_err(Failure::input)
    }

    /// Renders the frame; with `rebuild` the pyramids of its maps and the silhouettes are made anew, as if the lights had
    /// moved.
    pub(crate) fn render(&mut self, rebuild: bool) -> Outcome<GpuTimes> {
        if rebuild {
            self.maps.iter().flatten().for_each(ShadowMap::touch);
            self.volumes.iter().for_each(ShadowVolume::touch);
        }
        self.prepare()?;
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        // uploads are no part of the frame
        queue.submit([]);
        device.poll(gpu_backend::wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
        let started = Instant::now();
        let mut encoder = device.create_command_encoder(&Default::default());
        self.fog.encode(&mut encoder);
        queue.submit([encoder.finish()]);
        device.poll(gpu_backend::wgpu::PollType::wait_indefinitely()).map_err(Failure::program)?;
        let wall = started.elapsed().as_secs_f64() * 1e3;
        let passes = self.fog.pass_times(device, queue).map_err(Failure::program)?;
        let stamped = passes.iter().map(|pass| pass.ms).sum::<Option<f64>>().filter(|_| !passes.is_empty());
        Ok(GpuTimes { ms: stamped.filter(|_| gpu::is_hardware(self.gpu)).unwrap_or(wall), passes })
    }

    /// The picture of the last rendering.
    pub(crate) fn read(&self) -> Outcome<Vec<[f32; 3]>> {
        self.fog.read_airlight(&self.gpu.device, &self.gpu.queue, 0).map_err(Failure::program)
    }

    /// What the frame consists of.
    pub(crate) fn stats(&self) -> &gpu_backend::FrameStats {
        self.fog.stats()
    }

    /// View rays that were traced in the last frame.
    fn traced_rays(&self) -> Outcome<u64> {
        self.fog.read_traced_rays(&self.gpu.device, &self.gpu.queue, 0).map_err(Failure::program)
    }

    /// Steps of marches, at most: those of adaptively sampled rays are counted once they are traced.
    fn samples(&self) -> Outcome<u64> {
        let samples = self.stats().samples;
        let Sampling::Adaptive(_) = self.sampling else { return Ok(samples) };
        let steps = match self.technique {
            gpu_backend::Technique::BruteForce { samples, .. } => samples,
            gpu_backend::Technique::Hybrid(hybrid) => hybrid.samples,
            _ => 0,
        };
        let whole = u64::from(steps) * self.stage.setup.lights.len() as u64;
        Ok(whole * self.traced_rays()?)
    }

    /// Triangles that the last frame made of the lights: two for each edge of a silhouette, or the surfaces of light
    /// volumes with what closes them. `None` for techniques without.
    pub(crate) fn mesh_triangles(&self) -> Outcome<Option<u64>> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        match self.technique {
            gpu_backend::Technique::Hybrid(_) => {
                let edges = self.volumes.iter().map(|volume| volume.read_edge_count(device, queue));
                let edges: u64 = edges
                    .map(|count| Ok(u64::from(count.map_err(Failure::program)?)))
                    .sum::<Outcome<u64>>()?;
                Ok(Some(2 * edges))
            }
            gpu_backend::Technique::LightVolume { tessellation, .. } => {
                let maps = self.maps.iter().flatten();
                let counts = maps.map(|map| match tessellation {
                    gpu_backend::Tessellation::Adaptive { .. } => {
                        match map.read_leaf_count(device, queue) {
                            Ok(count) => Ok(u64::from(count.triangles) + seam_triangles(map)),
                            // where nothing scatters none is made
                            Err(ReadError::Nothing(_)) => Ok(0),
                            Err(error) => Err(Failure::program(error)),
                        }
                    }
                    gpu_backend::Tessellation::Mesh => {
                        Ok(map.mesh().map_or(0, |mesh| u64::from(mesh.triangle_count())))
                    }
                    _ => Ok(grid_triangles(map)),
                });
                counts.sum::<Outcome<u64>>().map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Memory of what was made from the maps; units: bytes.
    pub(crate) fn pyramid_bytes(&self) -> u64 {
        let texels = |map: &ShadowMap| {
            4 * u64::from(map.size().0) * u64::from(map.size().1) * map.projection().faces().len() as u64
        };
        self.maps.iter().flatten().map(|map| map.bytes() - texels(map)).sum()
    }
}

/// The hybrid's settings.
fn hybrid_of(
    options: &HybridOptions,
    model: AirlightModel,
    samples: u32,
    lookup: Lookup,
) -> gpu_backend::Hybrid {
    gpu_backend::Hybrid {
        samples,
        lit_samples: options.lit_samples(samples),
        placement: options.placement(model),
        picture: options.mips.map_or(LightPicture::Point, |blur| LightPicture::Mips { blur }),
        lookup,
        faces: if options.tile == 1 { Faces::Pixels } else { Faces::Tiles(options.tile) },
        refine: options.refine,
        partial: matches!(options.extruded, Extruded::RestAsTexture(_)),
        form: options.form,
    }
}

/// Triangles between the faces of a cube's map.
fn seam_triangles(map: &ShadowMap) -> u64 {
    let cube = map.projection().faces().len() > 1;
    if cube { 24 * u64::from(map.size().0.saturating_sub(1)) + 8 } else { 0 }
}

/// Triangles of a surface with all cells of a map, closed.
fn grid_triangles(map: &ShadowMap) -> u64 {
    let (columns, rows) = (u64::from(map.size().0) - 1, u64::from(map.size().1) - 1);
    let faces = map.projection().faces().len() as u64;
    let closing = if faces > 1 { seam_triangles(map) } else { 2 * (columns + rows) };
    2 * columns * rows * faces + closing
}

/// The GPU's name for a tessellation, in a scene with this diagonal (m).
fn tessellation_of(wanted: Tessellation, diagonal: f32) -> gpu_backend::Tessellation {
    match (wanted, wanted.of_scene(diagonal)) {
        (_, lightvolume::Tessellation::Adaptive { criterion, threshold }) => {
            gpu_backend::Tessellation::Adaptive {
                criterion,
                threshold,
                most_leaves: gpu_backend::DEFAULT_MOST_LEAVES,
            }
        }
        (_, lightvolume::Tessellation::Delaunay { .. }) => gpu_backend::Tessellation::Mesh,
        (Tessellation::Static { indexed: false }, _) => gpu_backend::Tessellation::Grid,
        (_, lightvolume::Tessellation::Static) => gpu_backend::Tessellation::IndexedGrid,
    }
}

/// Gives every map the triangles of its light volume.
fn add_meshes(gpu: &GpuContext, stage: &Stage<'_>, maps: &mut [Option<ShadowMap>]) -> Outcome {
    for (map, volume) in maps.iter_mut().zip(light_volumes(stage)?) {
        let (Some(made), Some(volume)) = (map.take(), volume) else { continue };
        let mesh = LightMesh::upload(&gpu.device, &volume).map_err(Failure::input)?;
        *map = Some(made.with_mesh(mesh));
    }
    Ok(())
}

/// A shadow volume for each light, of what the options say.
fn volumes(gpu: &GpuContext, stage: &Stage<'_>) -> Outcome<Vec<ShadowVolume>> {
    let mesh = volumes::extruded_mesh(stage.setup, stage.options.hybrid.extruded)?;
    let casters = ShadowCasters::upload(&gpu.device, &mesh).map_err(Failure::input)?;
    let casters = Arc::new(casters);
    let of_light = |_: &Light| ShadowVolume::new(&gpu.device, Arc::clone(&casters)).map_err(Failure::input);
    stage.setup.lights.iter().map(of_light).collect()
}

/// The airlight by `technique`: the second of two renderings, since the first also compiles.
pub(crate) fn run(gpu: &GpuContext, stage: &Stage<'_>, technique: Technique) -> Outcome<Airlight> {
    if technique.has_froxels() {
        return froxels::airlight(stage, technique, Some(gpu));
    }
    let mut frame = GpuFrame::new(gpu, stage, technique)?;
    frame.render(false)?;
    let times = frame.render(true)?;
    (stage.tick)(u64::from(stage.options.size.1));
    let radiance = frame.read()?;
    let samples = frame.samples()?;
    Ok(Airlight {
        radiance: radiance.into_iter().map(|pixel| Vec3::from(pixel).as_dvec3()).collect::<Vec<DVec3>>(),
        ms: times.ms,
        rays_ms: 0.0,
        samples,
        rays: if frame.bvh.is_some() { samples } else { 0 },
        pyramid_bytes: frame.pyramid_bytes() as usize,
        mesh_triangles: frame.mesh_triangles()?,
        froxels: None,
        passes: times.passes.into_iter().filter_map(|pass| Some((pass.name, pass.ms?))).collect(),
    })
}
