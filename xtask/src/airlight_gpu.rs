//! The airlight of a picture on the GPU: the same stage as on the CPU, from the same view rays and the same maps.

use std::time::Instant;

use glam::{DVec3, Vec3};
use gpu_backend::{
    Fog, FogDescriptor, Frame, GpuBvh, GpuContext, Lamp, Lookup, MAX_LIGHTS, PassTime, SceneDepth, ShadowMap,
    Shadows, View,
};
use scene::{AirlightModel, Light, WideBvh};
use shadowmap::Bias;

use crate::airlight::{Airlight, Stage};
use crate::failure::{Failure, Outcome};
use crate::gpu;
use crate::maps::MapSurface;
use crate::scene_args::Setup;
use crate::technique::{Technique, VisibilitySource};

/// Why the GPU cannot do what is asked, if so; the CPU can.
pub(crate) fn lacks(setup: &Setup, technique: Technique) -> Option<String> {
    if setup.lights.len() > MAX_LIGHTS {
        return Some(format!("{} lights, and {MAX_LIGHTS} fit on the GPU", setup.lights.len()));
    }
    match technique {
        Technique::BruteForce => None,
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
        other => Some(format!("{} runs on the CPU alone", other.name())),
    }
}

/// A frame that stays on the GPU, to be rendered as often as its time is asked for.
pub(crate) struct GpuFrame<'a> {
    gpu: &'a GpuContext,
    fog: Fog,
    stage: &'a Stage<'a>,
    technique: gpu_backend::Technique,
    maps: Vec<Option<ShadowMap>>,
    bvh: Option<GpuBvh>,
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
        let technique = match technique {
            Technique::ExactShadowMap => gpu_backend::Technique::ExactShadowMap { surface: surface.into() },
            _ => gpu_backend::Technique::BruteForce {
                samples: options.samples,
                lookup: match surface {
                    MapSurface::Step => Lookup::Nearest,
                    MapSurface::Linear => Lookup::LinearSurface,
                },
            },
        };
        let upload = |map: &shadowmap::DepthMap| {
            ShadowMap::upload(&gpu.device, &gpu.queue, map, Bias::NONE)
                .map_err(|e| Failure::input(format!("--shadow-map {}: {e}", options.map.side)))
        };
        let maps = stage.maps.maps.iter().map(|map| map.as_ref().map(upload).transpose());
        let maps = maps.collect::<Outcome<Vec<_>>>()?;
        let casts = options.shadows_in_medium && !stage.bvh.triangles().is_empty();
        let march = matches!(technique, gpu_backend::Technique::BruteForce { .. });
        let bvh = if casts && march && options.visibility == VisibilitySource::Bvh {
            let wide = WideBvh::build(&stage.setup.scene).map_err(Failure::input)?;
            Some(GpuBvh::upload(&gpu.device, &wide).map_err(Failure::input)?)
        } else {
            None
        };
        let fog = Fog::new(&gpu.device, &FogDescriptor::default()).map_err(Failure::program)?;
        let mut frame = Self { gpu, fog, stage, technique, maps, bvh, casts };
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
            .map(|(light, map)| {
                let by_map = map.as_ref().map(|map| Shadows::Map { map, casters });
                let by_rays = self.bvh.as_ref().map(|bvh| Shadows::Rays { bvh, casters });
                Lamp { light, shadows: if self.casts { by_rays.or(by_map) } else { None } }
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
        };
        self.fog.prepare(&self.gpu.device, &self.gpu.queue, &frame).map_err(Failure::input)
    }

    /// Renders the frame; with `rebuild` the pyramids of its maps are made anew, as if the lights had moved.
    pub(crate) fn render(&mut self, rebuild: bool) -> Outcome<GpuTimes> {
        if rebuild {
            self.maps.iter().flatten().for_each(ShadowMap::touch);
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

    /// Memory of what was made from the maps; units: bytes.
    pub(crate) fn pyramid_bytes(&self) -> u64 {
        let texels = |map: &ShadowMap| {
            4 * u64::from(map.size().0) * u64::from(map.size().1) * map.projection().faces().len() as u64
        };
        self.maps.iter().flatten().map(|map| map.bytes() - texels(map)).sum()
    }
}

/// The airlight by `technique`: the second of two renderings, since the first also compiles.
pub(crate) fn run(gpu: &GpuContext, stage: &Stage<'_>, technique: Technique) -> Outcome<Airlight> {
    let mut frame = GpuFrame::new(gpu, stage, technique)?;
    frame.render(false)?;
    let times = frame.render(true)?;
    (stage.tick)(u64::from(stage.options.size.1));
    let radiance = frame.read()?;
    Ok(Airlight {
        radiance: radiance.into_iter().map(|pixel| Vec3::from(pixel).as_dvec3()).collect::<Vec<DVec3>>(),
        ms: times.ms,
        samples: frame.stats().samples,
        rays: if frame.bvh.is_some() { frame.stats().samples } else { 0 },
        pyramid_bytes: frame.pyramid_bytes() as usize,
        passes: times.passes.into_iter().filter_map(|pass| Some((pass.name, pass.ms?))).collect(),
    })
}
