//! A frame of froxels: its memory, its uniforms and its bindings; its passes are recorded in `record`.

use froxel_grid::{
    FroxelError, FroxelView, Froxels, GridReads, Lattice, MAX_LIGHTS, MaskWidth, Near, Slices, Temporal,
    Update,
};
use glam::Vec3;
use scene::{Aabb, AirlightModel, Density, Light, Medium, Refusal};

use super::layout::{FAR_CORNER, FrameUniform, LightUniform, MAX_VIEWS, ViewUniform};
use super::memory::{GridBuffers, ViewVolumes, buffer};
use super::passes::{Masks, MediumKind, Voxels};
use super::{FroxelState, Known};
use crate::checked::{check_size, filled_buffer, prepared};
use crate::fog::{Frame, Sampling, Shadows};
use crate::pass::{Step, bind};
use crate::pipelines::Pipelines;
use crate::{FrameStats, GpuBvh, PrepareError};

/// What a frame of froxels is made from.
pub(crate) struct FroxelContext<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) froxels: &'a Froxels,
    pub(crate) targets: &'a [FroxelTarget],
    pub(crate) density: &'a wgpu::TextureView,
    /// A volume of one texel.
    pub(crate) stand_in: &'a wgpu::TextureView,
}

/// Where a view's rays end, where its airlight goes, and its uniform.
pub(crate) struct FroxelTarget {
    pub(crate) ray_ends: wgpu::TextureView,
    pub(crate) airlight: wgpu::TextureView,
    pub(crate) uniform: wgpu::Buffer,
}

/// What passes bind of a frame.
pub(super) struct Groups {
    pub(super) frame: wgpu::BindGroup,
    pub(super) grid: wgpu::BindGroup,
    pub(super) bvh: Option<wgpu::BindGroup>,
}

/// What a frame is specialised by.
pub(super) struct Kinds {
    pub(super) masks: Masks,
    pub(super) voxels: Voxels,
    pub(super) medium: MediumKind,
    pub(super) grid: bool,
    pub(super) textured: bool,
}

impl FroxelContext<'_> {
    /// Checks all that can be checked without a device.
    ///
    /// # Errors
    /// [`PrepareError`] names what does not fit.
    pub(crate) fn check(frame: &Frame<'_>, froxels: &Froxels) -> Result<(), PrepareError> {
        froxels.check()?;
        if frame.lamps.len() > MAX_LIGHTS {
            return Err(FroxelError::TooManyLights { got: frame.lamps.len(), most: MAX_LIGHTS }.into());
        }
        if frame.views.len() > MAX_VIEWS {
            return Err(PrepareError::TooLarge {
                what: "a frame of froxels",
                needed: frame.views.len() as u64,
                limit: MAX_VIEWS as u64,
                unit: "views",
            });
        }
        let refused = |feature, instead| Err(Refusal { technique: "froxels", feature, instead }.into());
        if frame.sampling != Sampling::Pixels {
            return refused("airlight for some of the pixels", "wider froxels");
        }
        let mut known: Option<&wgpu::Buffer> = None;
        for lamp in frame.lamps {
            match lamp.shadows {
                None => {}
                Some(Shadows::Map { .. }) => return refused("shadow maps", "shadow rays"),
                Some(Shadows::Rays { bvh, .. }) => {
                    if known.is_some_and(|nodes| nodes != bvh.nodes()) {
                        return refused("lights with different casters", "one hierarchy for all");
                    }
                    known = Some(bvh.nodes());
                }
            }
        }
        Ok(())
    }

    /// The hierarchy, and the box around all casters, of lights in which something throws shadows.
    fn casters(&self) -> Option<(&GpuBvh, Aabb)> {
        let mut found: Option<(&GpuBvh, Aabb)> = None;
        for lamp in self.frame.lamps {
            if let Some(Shadows::Rays { bvh, casters }) = lamp.shadows
                && !casters.is_empty()
            {
                let casters = found.map_or(casters, |(_, others)| others.union(&casters));
                found = Some((bvh, casters));
            }
        }
        found
    }

    pub(super) fn filled(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        filled_buffer(self.device, label, contents, wgpu::BufferUsages::UNIFORM)
    }
}

/// The box that a medium fills.
fn extent(medium: &Medium) -> [Vec3; 2] {
    let mut corners = [Vec3::splat(-FAR_CORNER), Vec3::splat(FAR_CORNER)];
    let grid = match &medium.density {
        Some(Density::Grid(grid)) => Some(grid.bounds),
        _ => None,
    };
    for bounds in [medium.bounds, grid].into_iter().flatten() {
        corners = [corners[0].max(bounds.min), corners[1].min(bounds.max)];
    }
    corners
}

fn medium_kind(medium: &Medium, model: AirlightModel) -> MediumKind {
    MediumKind {
        bounded: medium.bounds.is_some(),
        density: match &medium.density {
            None => 0,
            Some(Density::Height { .. }) => 1,
            Some(Density::Grid(_)) => 2,
        },
        isotropic: medium.phase.is_isotropic(),
        hoffman_preetham: model == AirlightModel::HoffmanPreetham,
    }
}

impl FroxelState {
    /// Adds a frame's passes.
    ///
    /// # Errors
    /// [`PrepareError`] if something does not fit on the device, or it is lost.
    pub(crate) fn build(
        &mut self,
        context: &FroxelContext<'_>,
        steps: &mut Vec<Step>,
        stats: &mut FrameStats,
    ) -> Result<(), PrepareError> {
        let FroxelContext { frame, froxels, .. } = *context;
        let casters = context.casters();
        self.notice(context, casters.as_ref());
        let width = match froxels.grid() {
            Some(grid) => grid.lights,
            None => MaskWidth::of(frame.lamps.len()),
        };
        let (near_side, mut near_slices) = froxels.near_volume();
        if casters.is_none() {
            near_slices = 0;
        }
        let lattice = self.reserve_grid(context, casters.as_ref(), width, near_slices)?;
        let views = self.reserve_views(context, width, near_side, near_slices)?;
        let kinds = Kinds {
            masks: Masks {
                bits: width.bits(),
                selects: frame.lamps.len() > width.bits() as usize,
                lights: frame.lamps.len() as u32,
            },
            voxels: froxels.grid().map_or_else(Voxels::default, |grid| Voxels {
                bricks: self.grid.as_ref().is_some_and(|grid| grid.bricks > 0),
                alternates: matches!(grid.update, Update::Marked { alternate: true }),
                trilinear: grid.reads == GridReads::Trilinear,
            }),
            medium: medium_kind(frame.medium, frame.model),
            grid: self.grid.is_some(),
            textured: frame
                .lamps
                .iter()
                .any(|lamp| matches!(lamp.light, Light::Spot(s) if s.texture.is_some())),
        };
        let uniform = self.uniform(context, casters.as_ref(), lattice, near_slices);
        let groups = self.groups(context, &uniform, &views, casters.as_ref())?;
        steps.push(Step::Clear(self.counts.clone()));
        self.find_reaches(context, &groups, &views, steps)?;
        self.trace(context, &groups, &kinds, &uniform, &views, steps)?;
        self.light(context, &groups, &kinds, &views, steps)?;
        self.frames = self.frames.wrapping_add(1);
        self.grid_begun = true;
        stats.bytes += self.bytes() + casters.map_or(0, |(bvh, _)| bvh.bytes());
        stats.triangles += casters.map_or(0, |(bvh, _)| bvh.triangle_count());
        Ok(())
    }

    /// Forgets the history where the scene has changed.
    fn notice(&mut self, context: &FroxelContext<'_>, casters: Option<&(&GpuBvh, Aabb)>) {
        let frame = context.frame;
        let same = self.known.as_ref().is_some_and(|known| {
            known.lights.iter().eq(frame.lamps.iter().map(|lamp| lamp.light))
                && known.medium == *frame.medium
                && known.model == frame.model
                && known.casters == casters.map(|(_, casters)| *casters)
                && known.hierarchy.as_ref() == casters.map(|(bvh, _)| bvh.nodes())
        });
        let same_views = self.known.as_ref().is_some_and(|known| known.views == frame.views.len());
        let keeps = context.froxels.temporal.is_some_and(|temporal| temporal.keeps_changed);
        if !same_views || (!same && !keeps) {
            self.views.iter_mut().for_each(|view| view.frames = 0);
        }
        if !(same && same_views) {
            self.known = Some(Known {
                lights: frame.lamps.iter().map(|lamp| lamp.light.clone()).collect(),
                medium: frame.medium.clone(),
                model: frame.model,
                casters: casters.map(|(_, casters)| *casters),
                hierarchy: casters.map(|(bvh, _)| bvh.nodes().clone()),
                views: frame.views.len(),
            });
        }
    }

    /// Makes the grid fit; the voxels that there are.
    fn reserve_grid(
        &mut self,
        context: &FroxelContext<'_>,
        casters: Option<&(&GpuBvh, Aabb)>,
        width: MaskWidth,
        near_slices: u32,
    ) -> Result<Lattice, PrepareError> {
        let (Some(grid), Some((_, bounds))) = (context.froxels.grid(), casters) else {
            self.grid = None;
            return Ok(Lattice::new(&Aabb::EMPTY, 1.0)?);
        };
        if near_slices == context.froxels.slices {
            // nothing is left for the grid
            self.grid = None;
            return Ok(grid.lattice(bounds)?);
        }
        let lattice = grid.lattice(bounds)?;
        if let Near::FineGrid { ratio, .. } = grid.near {
            lattice.finer(ratio).check_bricks()?;
        }
        if !self.grid.as_ref().is_some_and(|buffers| buffers.fits(grid, &lattice, width)) {
            self.grid = None;
            self.grid = Some(GridBuffers::new(context.device, grid, lattice, width)?);
            self.grid_begun = false;
        }
        Ok(lattice)
    }

    /// Makes volumes and buffers fit the views; the views with their places in those.
    fn reserve_views(
        &mut self,
        context: &FroxelContext<'_>,
        width: MaskWidth,
        near_side: u32,
        near_slices: u32,
    ) -> Result<Vec<ViewUniform>, PrepareError> {
        let FroxelContext { device, frame, froxels, .. } = *context;
        let (mut tile, mut word) = (0_u64, 0_u64);
        let mut views = Vec::new();
        let mut old: Vec<_> = self.views.drain(..).map(Some).collect();
        for (index, view) in frame.views.iter().enumerate() {
            let froxel_view = FroxelView::new(view.camera, view.size, froxels.tile);
            views.push(ViewUniform::new(&froxel_view, tile as u32, word as u32));
            let ((columns, rows), (across, down)) = (froxel_view.tiles(), froxel_view.cells(near_side));
            tile += u64::from(columns) * u64::from(rows);
            word +=
                u64::from(across) * u64::from(down) * u64::from((near_slices * width.bits()).div_ceil(32));
            // a view keeps its own history: that of another place in the list is another's
            let fits = |old: &ViewVolumes| old.tiles == (columns, rows) && old.slices == froxels.slices;
            let kept = old.get_mut(index).and_then(Option::take).filter(fits);
            let mut volumes = match kept {
                Some(volumes) => volumes,
                None => ViewVolumes::new(device, &froxel_view, froxels.slices)?,
            };
            if froxels.temporal.is_some() {
                volumes.reserve_history(device)?;
            }
            self.views.push(volumes);
        }
        let sizes = [("the tiles of all views", 8 * tile), ("the shadows of all views", 4 * word)];
        for (what, bytes) in sizes {
            check_size(device, what, bytes)?;
        }
        let reserve = |slot: &mut Option<wgpu::Buffer>, label, bytes: u64| -> Result<(), PrepareError> {
            if slot.as_ref().is_none_or(|buffer| buffer.size() != bytes.max(16)) {
                *slot = Some(prepared(device, "froxels", || buffer(device, label, bytes))?);
            }
            Ok(())
        };
        reserve(&mut self.reaches, "froxel reaches", 8 * tile)?;
        reserve(&mut self.near, "froxel masks", 4 * word)?;
        Ok(views)
    }

    fn uniform(
        &self,
        context: &FroxelContext<'_>,
        casters: Option<&(&GpuBvh, Aabb)>,
        lattice: Lattice,
        near_slices: u32,
    ) -> FrameUniform {
        let FroxelContext { frame, froxels, .. } = *context;
        let slices = Slices::new(froxels);
        let mut uniform: FrameUniform = bytemuck::Zeroable::zeroed();
        let bounds = casters.map_or(Aabb { min: Vec3::ZERO, max: Vec3::ZERO }, |(_, bounds)| *bounds);
        (uniform.box_min, uniform.box_max) = (bounds.min.to_array(), bounds.max.to_array());
        [uniform.medium_min, uniform.medium_max] = extent(frame.medium).map(|corner| corner.to_array());
        (uniform.light_count, uniform.view_count) = (frame.lamps.len() as u32, frame.views.len() as u32);
        (uniform.slices, uniform.near_slices) = (froxels.slices, near_slices);
        (uniform.dims, uniform.voxel_size) = (lattice.dims.to_array(), lattice.voxel_size);
        (uniform.tile, uniform.near_side) = (froxels.tile, froxels.near_volume().0);
        uniform.fine_slices = froxels.fine_slices();
        uniform.ratio = 1;
        uniform.sigma_t = frame.medium.coefficients.sigma_t();
        uniform.range = froxels.range;
        uniform.curve = froxels.curve;
        uniform.growth = f64::from(froxels.curve).exp_m1() as f32;
        uniform.jitter = if froxels.temporal.is_some() { Temporal::jitter(self.frames) } else { 0.5 };
        if let Some(grid) = froxels.grid() {
            if let Near::FineGrid { ratio, .. } = grid.near {
                uniform.ratio = ratio;
            }
            let (Update::InFrustums { alternate } | Update::Marked { alternate }) = grid.update;
            uniform.parity = self.frames & 1;
            uniform.everything = u32::from(!alternate || !self.grid_begun);
        }
        (uniform.grid_min, uniform.grid_max) = (uniform.box_min, uniform.box_max);
        if let (Some(grid), Some(settings)) = (&self.grid, froxels.grid()) {
            let bounds = settings.bounds(&bounds);
            (uniform.grid_min, uniform.grid_max) = (bounds.min.to_array(), bounds.max.to_array());
            (uniform.bricks, uniform.blocks) = (grid.bricks, grid.blocks);
        }
        for (slot, ends) in uniform.starts.iter_mut().zip(slices.starts.windows(2)) {
            *slot = [ends[0], ends[1], 0.0, 0.0];
        }
        for (slot, lamp) in uniform.lights.iter_mut().zip(frame.lamps) {
            let is_shadowed =
                matches!(lamp.shadows, Some(Shadows::Rays { casters, .. }) if !casters.is_empty());
            *slot = LightUniform::new(lamp.light, is_shadowed);
        }
        self.place_pictures(context, &mut uniform);
        uniform
    }

    /// Says where the lights' pictures are, one behind the other.
    fn place_pictures(&self, context: &FroxelContext<'_>, uniform: &mut FrameUniform) {
        let mut texel = 0;
        for (slot, lamp) in uniform.lights.iter_mut().zip(context.frame.lamps) {
            if let Light::Spot(spot) = lamp.light
                && let Some(picture) = &spot.texture
            {
                (slot.first_texel, slot.picture) = (texel, [picture.width, picture.height]);
                slot.nearest_texel = u32::from(picture.filter == scene::TextureFilter::Nearest);
                texel += picture.width * picture.height;
            }
        }
    }

    /// The pictures of all lights; uploaded again only where they are others.
    pub(super) fn pictures(&mut self, context: &FroxelContext<'_>) -> Result<wgpu::Buffer, PrepareError> {
        let pictures: Vec<_> = context
            .frame
            .lamps
            .iter()
            .filter_map(|lamp| match lamp.light {
                Light::Spot(spot) => spot.texture.clone(),
                Light::Point(_) | Light::Directional(_) => None,
            })
            .collect();
        if pictures.is_empty() {
            self.pictures = None;
            return Ok(self.nothing.clone());
        }
        if let Some((known, buffer)) = &self.pictures
            && *known == pictures
        {
            return Ok(buffer.clone());
        }
        let texels: Vec<[f32; 4]> =
            pictures.iter().flat_map(|picture| &picture.texels).map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        check_size(context.device, "the pictures of all lights", 16 * texels.len() as u64)?;
        let buffer = prepared(context.device, "the pictures of all lights", || {
            let bytes = bytemuck::cast_slice(&texels);
            filled_buffer(context.device, "light pictures", bytes, wgpu::BufferUsages::STORAGE)
        })?;
        self.pictures = Some((pictures, buffer.clone()));
        Ok(buffer)
    }

    fn groups(
        &self,
        context: &FroxelContext<'_>,
        uniform: &FrameUniform,
        views: &[ViewUniform],
        casters: Option<&(&GpuBvh, Aabb)>,
    ) -> Result<Groups, PrepareError> {
        let device = context.device;
        let layouts = &self.passes.layouts;
        let (reaches, near) =
            (self.reaches.as_ref().unwrap_or(&self.nothing), self.near.as_ref().unwrap_or(&self.nothing));
        let mut all = views.to_vec();
        all.resize(MAX_VIEWS, bytemuck::Zeroable::zeroed());
        prepared(device, "froxels", || {
            let frame = context.filled("froxel frame", bytemuck::bytes_of(uniform));
            let views = context.filled("froxel views", bytemuck::cast_slice(&all));
            let whole = |buffer: &'_ wgpu::Buffer| buffer.clone();
            let grid = self.grid.as_ref().map_or_else(
                || [0; 3].map(|_| buffer(device, "no grid", 16)),
                |grid| [whole(&grid.masks[0]), whole(&grid.masks[1]), whole(&grid.keys)],
            );
            Groups {
                frame: bind(
                    device,
                    "froxel frame",
                    &layouts.frame,
                    [
                        frame.as_entire_binding(),
                        views.as_entire_binding(),
                        reaches.as_entire_binding(),
                        near.as_entire_binding(),
                        self.counts.as_entire_binding(),
                    ],
                ),
                grid: bind(
                    device,
                    "froxel grid",
                    &layouts.grid,
                    grid.each_ref().map(wgpu::Buffer::as_entire_binding),
                ),
                bvh: casters.map(|(bvh, _)| {
                    let nodes = [bvh.nodes(), bvh.triangles()].map(wgpu::Buffer::as_entire_binding);
                    bind(device, "froxel bvh", &layouts.bvh, nodes)
                }),
            }
        })
    }
}
