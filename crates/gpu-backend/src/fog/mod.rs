//! Fog for a renderer: prepared from plain values, encoded into the host's commands, drawn over the host's picture.

mod composite;
mod frame;
pub(crate) mod grid;
pub(crate) mod layout;
pub(crate) mod lights;
mod low;
mod mips;
mod plan;
mod prepare;
mod ray_ends;
mod sampling;
pub(crate) mod targets;
mod view;

use std::collections::HashMap;

use froxel_grid::Counts;

pub use composite::CompositeTarget;
use composite::CompositeVariant;
pub use frame::{
    Adaptive, AirlightForm, Frame, Hybrid, Lamp, LightPicture, Lookup, MAX_LIGHTS, Placement, Sampling,
    SceneDepth, Shadows, Technique, View,
};
use layout::{Layouts, StandIns};
use low::{LowPasses, MOST_SCALE};
use plan::Variant;
use ray_ends::RayEnds;
use sampling::{SamplePasses, TRACED};
use targets::{Targets, check_view};
use view::ViewPasses;

use crate::capabilities::check_limits;
use crate::checked::{created, prepared, read_words};
use crate::froxel::FroxelState;
use crate::lightvolume::{Leaves, LightVolumePasses};
use crate::map::{HostConverter, Pyramid, PyramidBuilder};
use crate::pass::{Step, encode_all};
use crate::read_radiance::{read_radiance, read_texels};
use crate::timing::PassTimer;
use crate::volume::{Key, ShadowVolume, VolumePasses};
use crate::{CreateError, FrameStats, PassTime, Pipelines, PrepareError, ReadError, ShadowMap};

/// How a [`Fog`] is made.
#[derive(Debug, Clone, Copy, Default)]
pub struct FogDescriptor<'a> {
    /// Name in front of all labels.
    pub label: Option<&'a str>,
    /// What [`Fog::composite`] draws into; `None` if it is not used.
    pub target: Option<CompositeTarget>,
    /// Where pipelines are taken from and kept, for other fogs of the same device; `None` if there are none. Devices of
    /// different instances of wgpu cannot be told apart: it is the host's to keep those separate.
    pub pipelines: Option<&'a Pipelines>,
}

/// Airlight with volumetric shadows on a device that is the host's or one's own.
///
/// [`Fog::new`], then for every frame [`Fog::prepare`], [`Fog::encode`] into the host's encoder and [`Fog::composite`]
/// inside the host's render pass. Nothing here submits, but for [`Fog::read_airlight`].
pub struct Fog {
    label: String,
    target: Option<CompositeTarget>,
    pipelines: Pipelines,
    layouts: Layouts,
    stand_ins: StandIns,
    scatter: HashMap<Variant, wgpu::ComputePipeline>,
    composite: HashMap<CompositeVariant, wgpu::RenderPipeline>,
    pyramids: PyramidBuilder,
    converter: HostConverter,
    /// Made when a frame first needs shadow volumes.
    volumes: Option<VolumePasses>,
    /// Made when a frame first draws a light volume.
    light_volumes: Option<LightVolumePasses>,
    /// Made when a frame first computes airlight for blocks of pixels.
    low: Option<LowPasses>,
    /// Made when a frame is first sampled adaptively.
    sampling: Option<SamplePasses>,
    /// Made when a frame first has froxels.
    froxels: Option<FroxelState>,
    ray_ends: RayEnds,
    timer: Option<PassTimer>,
    views: Vec<ViewState>,
    steps: Vec<Step>,
    /// What the passes make of the maps.
    building: Vec<MapChange>,
    /// Shadow volumes whose silhouette the steps find, and for which light.
    moved: Vec<(ShadowVolume, Key)>,
    pictures: lights::Pictures,
    mips: mips::MipPictures,
    grid: grid::DensityTexture,
    stats: FrameStats,
}

impl std::fmt::Debug for Fog {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fog").field("label", &self.label).field("stats", &self.stats).finish_non_exhaustive()
    }
}

/// A map that is up to date once the frame's passes are encoded.
#[derive(Debug)]
struct MapChange {
    map: ShadowMap,
    version: u64,
    pyramid: Option<Pyramid>,
    leaves: Option<Leaves>,
}

/// A view as the last frame left it.
#[derive(Debug)]
struct ViewState {
    targets: Targets,
    /// Nearest and farthest layer of scattering at a lower resolution.
    low: Vec<Targets>,
    /// Which of the airlight textures holds the result.
    result: usize,
    /// Whether it is sampled adaptively.
    is_sampled: bool,
    /// Draws of the composite, in order.
    draws: Vec<(CompositeVariant, wgpu::BindGroup)>,
}

impl ViewState {
    fn into_targets(self) -> impl Iterator<Item = Targets> {
        std::iter::once(self.targets).chain(self.low)
    }

    /// Memory; units: bytes.
    fn bytes(&self) -> u64 {
        std::iter::once(&self.targets).chain(&self.low).map(Targets::bytes).sum()
    }
}

impl Fog {
    /// Makes what every frame needs; pipelines for particular lights and media are made when a frame first needs them.
    ///
    /// # Errors
    /// [`CreateError`] if the device was made with less than [`required_limits`](crate::required_limits), the target
    /// cannot be blended into, the pipelines that were given are of another device, or the driver refuses one.
    pub fn new(device: &wgpu::Device, descriptor: &FogDescriptor<'_>) -> Result<Self, CreateError> {
        check_limits(device)?;
        if let Some(target) = &descriptor.target {
            let features = target.format.guaranteed_format_features(device.features());
            let blendable = features.flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
            if !blendable || !features.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
                return Err(CreateError::Format(target.format));
            }
        }
        let pipelines = descriptor.pipelines.cloned().unwrap_or_else(|| Pipelines::new(device));
        if pipelines.device() != device {
            return Err(CreateError::OtherDevice);
        }
        let (layouts, stand_ins) = created(device, "fog", || (Layouts::new(device), StandIns::new(device)))?;
        Ok(Self {
            label: descriptor.label.unwrap_or("fog").to_owned(),
            target: descriptor.target,
            layouts,
            stand_ins,
            scatter: HashMap::new(),
            composite: HashMap::new(),
            pyramids: PyramidBuilder::new(&pipelines)?,
            converter: HostConverter::new(&pipelines)?,
            volumes: None,
            light_volumes: None,
            low: None,
            sampling: None,
            froxels: None,
            ray_ends: RayEnds::new(&pipelines)?,
            pipelines,
            timer: None,
            views: Vec::new(),
            steps: Vec::new(),
            building: Vec::new(),
            moved: Vec::new(),
            pictures: lights::Pictures::default(),
            mips: mips::MipPictures::default(),
            grid: grid::DensityTexture::default(),
            stats: FrameStats::default(),
        })
    }

    /// Uploads a frame and decides what it needs; nothing is submitted.
    ///
    /// The commands of the frame before should be submitted by then: what is uploaded here (ends of rays that are no
    /// depth buffer, light textures, density) is there before any commands that are submitted later.
    ///
    /// # Errors
    /// [`PrepareError`] names what does not fit: too many lights, a view or map that is too large, a texture of the
    /// wrong format, a feature that the technique cannot take, a device that is lost. Nothing of the frame before is left.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame<'_>,
    ) -> Result<(), PrepareError> {
        // whatever fails below, nothing of this frame or the one before can be encoded or drawn
        self.steps.clear();
        self.building.clear();
        self.moved.clear();
        self.stats = FrameStats::default();
        let mut old: Vec<Targets> = self.views.drain(..).flat_map(ViewState::into_targets).collect();
        let froxels = match &frame.technique {
            Technique::Froxels(froxels) => Some(froxels),
            _ => None,
        };
        if froxels.is_none() && frame.lamps.len() > MAX_LIGHTS {
            return Err(PrepareError::TooManyLights { got: frame.lamps.len(), most: MAX_LIGHTS });
        }
        let scale = frame.sampling.scale();
        if !(1..=MOST_SCALE).contains(&scale) {
            return Err(PrepareError::ScatteringScale { got: scale, most: MOST_SCALE });
        }
        if scale > 1 && self.low.is_none() {
            self.low = Some(LowPasses::new(&self.pipelines)?);
        }
        if let Sampling::Adaptive(adaptive) = &frame.sampling {
            adaptive.check()?;
        }
        let largest = device.limits().max_texture_dimension_2d;
        for (index, view) in frame.views.iter().enumerate() {
            check_view(index, view, largest)?;
        }
        if let Some(froxels) = froxels {
            return self.prepare_froxels(device, queue, frame, froxels, old);
        }
        let mut work = plan::plan(frame)?;
        lights::check_maps(frame)?;
        if self.volumes.is_none() && work.iter().any(|work| work.faces.is_some()) {
            self.volumes = Some(VolumePasses::new(&self.pipelines)?);
        }
        self.reserve_light_volumes(&mut work)?;
        for work in &work {
            match frame.sampling {
                Sampling::Adaptive(_) => {
                    self.scatter_pipeline(work.variant.of_list())?;
                    self.scatter_pipeline(work.variant.unlit_list())?;
                }
                _ => self.scatter_pipeline(work.variant)?,
            }
            if work.table_size > 0 {
                self.scatter_pipeline(work.variant.of_table())?;
            }
        }
        if frame.sampling.adaptive().is_some() && self.sampling.is_none() {
            self.sampling = Some(SamplePasses::new(&self.pipelines)?);
        }
        let grid = self.grid.of(device, queue, frame.medium, &self.stand_ins)?;
        let plain = self.pictures.of(device, queue, frame.lamps)?;
        let mips = self.mips.of(device, queue, frame)?;
        let pictures = lights::LightPictures { plain: &plain, mips: &mips };
        let mut stats = FrameStats::default();
        let mut steps = Vec::new();
        let building =
            prepared(device, "the maps", || self.map_passes(device, frame, &work, &mut steps, &mut stats))??;
        let moved = self.silhouettes(device, frame, &work, &mut steps, &mut stats)?;
        let mut views = Vec::new();
        for view in frame.views {
            let passes =
                ViewPasses { fog: self, device, queue, frame, view, work: &work, grid: &grid, pictures };
            views.push(passes.build(&mut old, &mut steps, &mut stats)?);
        }
        stats.bytes += self.pictures.bytes() + self.mips.bytes();
        self.finish(device, views, steps, stats)?;
        (self.building, self.moved) = (building, moved);
        Ok(())
    }

    /// Encodes the prepared frame's passes; may be called again for the same frame.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) {
        encoder.push_debug_group(&self.label);
        encode_all(&self.steps, encoder, self.timer.as_ref());
        encoder.pop_debug_group();
        if let Some(timer) = &mut self.timer {
            timer.resolve(encoder, self.steps.iter().filter_map(Step::label));
        }
        for change in &self.building {
            change.map.mark_converted(change.version);
            if let Some(pyramid) = &change.pyramid {
                pyramid.mark(change.version);
            }
            if let Some(leaves) = &change.leaves {
                leaves.mark(change.version);
            }
        }
        for (volume, key) in &self.moved {
            volume.mark(*key);
        }
    }

    /// Draws a view's fog over the picture that `pass` draws, which covers the whole view; to be called after the
    /// commands of [`Fog::encode`], once for each view.
    ///
    /// Does nothing for a view that was not prepared, or without a target.
    pub fn composite(&self, pass: &mut wgpu::RenderPass<'_>, view: usize) {
        let Some(view) = self.views.get(view) else { return };
        pass.push_debug_group(&self.label);
        for (variant, group) in &view.draws {
            if let Some(pipeline) = self.composite.get(variant) {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, group, &[]);
                pass.draw(0..3, 0..1);
            }
        }
        pass.pop_debug_group();
    }

    /// The airlight of a view: rgba32float, radiance in rgb; `None` if the view was not prepared.
    pub fn airlight(&self, view: usize) -> Option<&wgpu::Texture> {
        let view = self.views.get(view)?;
        view.targets.airlight[view.result].as_ref()
    }

    /// What the prepared frame consists of.
    pub fn stats(&self) -> &FrameStats {
        &self.stats
    }

    /// Times of the passes of the last encoded frame, once its commands are submitted; waits for the device.
    ///
    /// Empty if the frame was read before or the device has no timestamps; a time that came back as zero is `None`.
    ///
    /// # Errors
    /// [`ReadError::Device`] if the device is lost.
    pub fn pass_times(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<PassTime>, ReadError> {
        self.timer.as_mut().map_or(Ok(Vec::new()), |timer| timer.read(device, queue))
    }

    /// Airlight of a view, row-major, once the frame's commands are submitted; submits a copy and waits for it.
    ///
    /// # Errors
    /// [`ReadError::Nothing`] if the view was not prepared, [`ReadError::Device`] if the device is lost.
    pub fn read_airlight(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        view: usize,
    ) -> Result<Vec<[f32; 3]>, ReadError> {
        let texture = self.airlight(view).ok_or(ReadError::Nothing("such view"))?;
        read_radiance(device, queue, texture, "the airlight")
    }

    /// What was taken away from the negative sums of light volumes in each pixel, row-major, once the frame's commands are
    /// submitted: 0 in most; units: W/(m²·sr). Submits a copy and waits for it. Of frames by
    /// [`Technique::LightVolume`] for every pixel; others leave something else there.
    ///
    /// # Errors
    /// As [`Fog::read_airlight`].
    pub fn read_clamped(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        view: usize,
    ) -> Result<Vec<f32>, ReadError> {
        let texture = self.airlight(view).ok_or(ReadError::Nothing("such view"))?;
        let texels = read_texels(device, queue, texture, "what was clamped")?;
        Ok(texels.into_iter().map(|texel| texel[3]).collect())
    }

    /// View rays of a view that were traced, once the frame's commands are submitted: all, or with [`Sampling::Adaptive`] those
    /// around which airlight changes. Submits a copy and waits for it.
    ///
    /// # Errors
    /// As [`Fog::read_airlight`].
    pub fn read_traced_rays(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        view: usize,
    ) -> Result<u64, ReadError> {
        let view = self.views.get(view).ok_or(ReadError::Nothing("such view"))?;
        let (width, height) = view.targets.size;
        let Some(samples) = view.targets.samples.as_ref().filter(|_| view.is_sampled) else {
            return Ok(u64::from(width) * u64::from(height));
        };
        let words = read_words(device, queue, &samples.state, "the rays that were traced")?;
        Ok(words.get(TRACED as usize / 4).copied().unwrap_or(0).into())
    }

    /// What froxels counted in the last frame, once its commands are submitted; submits a copy and waits for it.
    ///
    /// # Errors
    /// [`ReadError::Nothing`] if no frame had froxels, [`ReadError::Device`] if the device is lost.
    pub fn read_froxel_counts(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Counts, ReadError> {
        self.froxels.as_ref().ok_or(ReadError::Nothing("frame of froxels"))?.read_counts(device, queue)
    }

    /// Shadow masks of the froxels that views trace for themselves, once the frame is submitted: views behind each other,
    /// the words of a cell's column hold its slices, as many bits each as masks have, and those of all cells in the same slices lie
    /// side by side. For tests.
    ///
    /// # Errors
    /// As [`Fog::read_froxel_counts`].
    pub fn read_near_masks(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<u32>, ReadError> {
        self.froxels.as_ref().ok_or(ReadError::Nothing("frame of froxels"))?.read_near_masks(device, queue)
    }

    /// Shadow masks of the shared grid, once the frame is submitted, and the keys of its bricks: 0 where there is none, else
    /// 1 + x + 2¹⁰ y + 2²⁰ z of the brick, and 2³⁰ more in the finer of two grids; behind those as many words of no
    /// interest. For tests.
    ///
    /// # Errors
    /// As [`Fog::read_froxel_counts`].
    pub fn read_shadow_grid(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<(Vec<u32>, Vec<u32>), ReadError> {
        self.froxels.as_ref().ok_or(ReadError::Nothing("frame of froxels"))?.read_grid(device, queue)
    }

    /// Forgets what froxels have accumulated over frames, and what the shadow grid holds: for a camera that cuts to another
    /// place, and casters that were changed in place.
    pub fn forget(&mut self) {
        if let Some(froxels) = &mut self.froxels {
            froxels.forget();
        }
    }
}
