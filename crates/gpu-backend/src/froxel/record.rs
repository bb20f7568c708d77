//! Recording the passes of a frame of froxels: how far rays reach, what is in shadow, what is lit.

use froxel_grid::Update;

use super::FroxelState;
use super::frame::{FroxelContext, Groups, Kinds};
use super::layout::{FrameUniform, ViewUniform, WhichUniform};
use super::passes::{Memory, Pass};
use crate::PrepareError;
use crate::checked::prepared;
use crate::pass::{ComputePass, Dispatch, Step, bind};

/// `SLICES_A_THREAD` of `shaders/shared/froxel.wgsl`.
const SLICES_A_THREAD: u32 = 8;

/// Most groups of a dispatch over marked blocks, which they take in turns: more than any GPU runs at once.
const MARKED_GROUPS: u32 = 1024;

/// Groups along x of a dispatch over blocks of voxels; as many rows as it takes.
const BLOCKS_IN_A_ROW: u32 = 32_768;

impl FroxelState {
    /// How far froxels are lit.
    pub(super) fn find_reaches(
        &mut self,
        context: &FroxelContext<'_>,
        groups: &Groups,
        views: &[ViewUniform],
        steps: &mut Vec<Step>,
    ) -> Result<(), PrepareError> {
        let device = context.device;
        let pipeline = self.passes.of(context.pipelines, Pass::TileEnds)?;
        for (index, (view, target)) in views.iter().zip(context.targets).enumerate() {
            let which = self.which(context, index)?;
            let entries = [which.as_entire_binding(), wgpu::BindingResource::TextureView(&target.ray_ends)];
            let group = bind(device, "froxel tile ends", &self.passes.layouts.tile_ends, entries);
            let [columns, rows] = view.tiles;
            steps.push(Step::Compute(ComputePass {
                label: "froxels: ray ends".into(),
                pipeline: pipeline.clone(),
                groups: vec![groups.frame.clone(), groups.grid.clone(), group],
                dispatch: Dispatch::Groups([columns.div_ceil(8), rows.div_ceil(8), 1]),
            }));
        }
        let [columns, rows] = largest(views.iter().map(|view| view.tiles));
        steps.push(Step::Compute(ComputePass {
            label: "froxels: reach".into(),
            pipeline: self.passes.of(context.pipelines, Pass::Reach)?,
            groups: vec![groups.frame.clone()],
            dispatch: Dispatch::Groups([columns.div_ceil(8), rows.div_ceil(8), views.len() as u32]),
        }));
        Ok(())
    }

    /// Shadow rays of all views: of their own volumes, and of the grid.
    pub(super) fn trace(
        &mut self,
        context: &FroxelContext<'_>,
        groups: &Groups,
        kinds: &Kinds,
        uniform: &FrameUniform,
        views: &[ViewUniform],
        steps: &mut Vec<Step>,
    ) -> Result<(), PrepareError> {
        let Some(bvh) = &groups.bvh else { return Ok(()) };
        let froxels = context.froxels;
        let count = views.len() as u32;
        let [columns, rows] = largest(views.iter().map(|view| view.tiles));
        if uniform.near_slices > 0 {
            let side = uniform.near_side;
            let [x, y] = [columns, rows].map(|tiles| tiles.div_ceil(side).div_ceil(4));
            let words = (uniform.near_slices * kinds.masks.bits).div_ceil(32);
            steps.push(Step::Compute(ComputePass {
                label: "froxels: near shadows".into(),
                pipeline: self.passes.of(context.pipelines, Pass::Near(kinds.masks))?,
                groups: vec![groups.frame.clone(), groups.grid.clone(), bvh.clone()],
                dispatch: Dispatch::Groups([x, y, count * words.div_ceil(4)]),
            }));
        }
        let (Some(buffers), Some(grid)) = (self.grid.clone(), froxels.grid()) else { return Ok(()) };
        let marked = matches!(grid.update, Update::Marked { .. });
        if marked || !self.grid_begun {
            steps.extend(buffers.masks.iter().filter(|buffer| buffer.size() > 16).cloned().map(Step::Clear));
            steps.push(Step::Clear(buffers.keys.clone()));
        }
        if marked {
            let layers = (uniform.slices - uniform.near_slices).div_ceil(4 * SLICES_A_THREAD);
            steps.push(Step::Compute(ComputePass {
                label: "froxels: marks".into(),
                pipeline: self.passes.of(context.pipelines, Pass::Mark(kinds.masks, kinds.voxels))?,
                groups: vec![groups.frame.clone(), groups.grid.clone()],
                dispatch: Dispatch::Groups([columns.div_ceil(4), rows.div_ceil(4), count * layers]),
            }));
        }
        let [across, rows] = if marked {
            [buffers.blocks.clamp(1, MARKED_GROUPS), 1]
        } else {
            let across = buffers.blocks.clamp(1, BLOCKS_IN_A_ROW);
            [across, buffers.blocks.div_ceil(across)]
        };
        let pass = Pass::Grid { masks: kinds.masks, bricks: kinds.voxels.bricks, marked };
        steps.push(Step::Compute(ComputePass {
            label: "froxels: grid shadows".into(),
            pipeline: self.passes.of(context.pipelines, pass)?,
            groups: vec![groups.frame.clone(), groups.grid.clone(), bvh.clone()],
            dispatch: Dispatch::Groups([across, rows, 1]),
        }));
        Ok(())
    }

    /// Lights the froxels of each view, sums them up and applies them.
    pub(super) fn light(
        &mut self,
        context: &FroxelContext<'_>,
        groups: &Groups,
        kinds: &Kinds,
        views: &[ViewUniform],
        steps: &mut Vec<Step>,
    ) -> Result<(), PrepareError> {
        let FroxelContext { device, froxels, .. } = *context;
        let pictures = self.pictures(context)?;
        let sigma_t = context.frame.medium.coefficients.sigma_t();
        let achromatic = sigma_t[0] == sigma_t[1] && sigma_t[1] == sigma_t[2];
        let most = froxels.temporal.map_or(1, |temporal| temporal.frames);
        let [accumulate, apply] = [
            self.passes.of(context.pipelines, Pass::Accumulate { achromatic })?,
            self.passes.of(context.pipelines, Pass::Apply)?,
        ];
        for (index, (view, target)) in views.iter().zip(context.targets).enumerate() {
            let which = self.which(context, index)?;
            let memory = match self.views[index].frames {
                _ if most == 1 => Memory::None,
                0 => Memory::Written,
                _ => Memory::Read,
            };
            let lighting = Pass::Lighting {
                masks: kinds.masks,
                voxels: kinds.voxels,
                grid: kinds.grid,
                textured: kinds.textured,
                medium: kinds.medium,
                memory,
                achromatic,
            };
            let lighting = self.passes.of(context.pipelines, lighting)?;
            let volumes = &mut self.views[index];
            let next = if froxels.temporal.is_some() { 1 - volumes.current } else { volumes.current };
            let view_of =
                |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
            let lit = volumes.lit[next].as_ref().map(view_of);
            let history = volumes.lit[1 - next].as_ref().map(view_of);
            let accumulated = view_of(&volumes.accumulated);
            let Some(lit) = lit else { continue };
            let history = history.as_ref().filter(|_| froxels.temporal.is_some()).unwrap_or(context.stand_in);
            let layouts = &self.passes.layouts;
            let texture = wgpu::BindingResource::TextureView;
            let group = bind(
                device,
                "froxel lighting",
                &layouts.lighting,
                [
                    which.as_entire_binding(),
                    target.uniform.as_entire_binding(),
                    texture(context.density),
                    texture(history),
                    texture(&lit),
                    pictures.as_entire_binding(),
                ],
            );
            let [columns, rows] = view.tiles;
            steps.push(Step::Compute(ComputePass {
                label: "froxels: lighting".into(),
                pipeline: lighting,
                groups: vec![groups.frame.clone(), groups.grid.clone(), group],
                dispatch: Dispatch::Groups(
                    [columns, rows, froxels.slices.div_ceil(SLICES_A_THREAD)].map(|side| side.div_ceil(4)),
                ),
            }));
            let entries = [which.as_entire_binding(), texture(&lit), texture(&accumulated)];
            let group = bind(device, "froxel march", &layouts.accumulate, entries);
            steps.push(Step::Compute(ComputePass {
                label: "froxels: march".into(),
                pipeline: accumulate.clone(),
                groups: vec![groups.frame.clone(), groups.grid.clone(), group],
                dispatch: Dispatch::Groups([columns.div_ceil(8), rows.div_ceil(8), 1]),
            }));
            let entries = [
                which.as_entire_binding(),
                texture(&target.ray_ends),
                texture(&accumulated),
                texture(&target.airlight),
            ];
            let group = bind(device, "froxel apply", &layouts.apply, entries);
            let [width, height] = view.size;
            steps.push(Step::Compute(ComputePass {
                label: "froxels: apply".into(),
                pipeline: apply.clone(),
                groups: vec![groups.frame.clone(), groups.grid.clone(), group],
                dispatch: Dispatch::Groups([width.div_ceil(8), height.div_ceil(8), 1]),
            }));
            volumes.current = next;
            volumes.before = *view;
            volumes.frames = volumes.frames.saturating_add(1);
        }
        Ok(())
    }

    /// Which view a pass is for, and what is left of it.
    fn which(&self, context: &FroxelContext<'_>, index: usize) -> Result<wgpu::Buffer, PrepareError> {
        let volumes = &self.views[index];
        let most = context.froxels.temporal.map_or(1, |temporal| temporal.frames);
        let which = WhichUniform {
            view: index as u32,
            _pad0: 0,
            newest: 1.0 / volumes.frames.saturating_add(1).min(most) as f32,
            _pad1: 0,
            before: volumes.before,
        };
        prepared(context.device, "froxels", || context.filled("froxel view", bytemuck::bytes_of(&which)))
    }
}

/// The largest of pairs, one by one.
fn largest(pairs: impl Iterator<Item = [u32; 2]>) -> [u32; 2] {
    pairs.fold([0; 2], |[a, b], [c, d]| [a.max(c), b.max(d)])
}
