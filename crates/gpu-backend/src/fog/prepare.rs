//! What [`Fog::prepare`] makes of a frame: the passes of its maps, silhouettes and froxels, pipelines, and draws.

use froxel_grid::Froxels;
use scene::{Density, Medium};

use super::composite::{self, CompositeVariant};
use super::lights;
use super::plan::{Shader, Variant, Work};
use super::targets::Targets;
use super::view::{ViewPasses, view_of};
use super::{Fog, Frame, Lamp, MapChange, ViewState};
use crate::checked::prepared;
use crate::froxel::{FroxelContext, FroxelState, FroxelTarget};
use crate::layout::ImagePlane;
use crate::lightvolume::LightVolumePasses;
use crate::pass::{Step, compute_pipeline, listed_pipeline};
use crate::timing::PassTimer;
use crate::volume::{Key, ShadowVolume, key_of};
use crate::write_texture::write_texture;
use crate::{CreateError, FrameStats, PrepareError};

impl Fog {
    /// [`Fog::prepare`] of a frame of froxels.
    pub(super) fn prepare_froxels(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame<'_>,
        froxels: &Froxels,
        mut old: Vec<Targets>,
    ) -> Result<(), PrepareError> {
        FroxelContext::check(frame, froxels)?;
        if self.froxels.is_none() {
            self.froxels = Some(FroxelState::new(device)?);
        }
        let density = self.grid.of(device, queue, frame.medium, &self.stand_ins)?;
        let (mut stats, mut steps) = (FrameStats::default(), Vec::new());
        let (mut views, mut targets) = (Vec::new(), Vec::new());
        let pictures = lights::LightPictures { plain: &[], mips: &[] };
        for view in frame.views {
            let passes =
                ViewPasses { fog: self, device, queue, frame, view, work: &[], grid: &density, pictures };
            let mut own = passes.targets(&mut old, view.size)?;
            own.reserve(device, 1)?;
            let image = passes.image(ImagePlane::new(view.camera, view.size), 1)?;
            passes.find_ends(&image, &own, &mut steps)?;
            let draws = prepared(device, "a view", || {
                let airlight = own.airlight[0].as_ref().map(view_of);
                let ends = view_of(&own.ray_ends);
                if let Some(airlight) = &airlight {
                    targets.push(FroxelTarget {
                        ray_ends: ends.clone(),
                        airlight: airlight.clone(),
                        uniform: image.uniform.clone(),
                    });
                }
                self.draws(device, frame.medium, &image.uniform, &ends, &airlight, &density)
            })?;
            views.push(ViewState { targets: own, low: Vec::new(), result: 0, is_sampled: false, draws });
        }
        let Medium { coefficients, emission, .. } = frame.medium;
        if *emission == [0.0; 3] && (coefficients.is_clear() || frame.lamps.is_empty()) {
            // nothing glows and nothing is lit
            prepared(device, "a view", || {
                for texture in views.iter().filter_map(|view| view.targets.airlight[0].as_ref()) {
                    let texels = texture.width() as usize * texture.height() as usize;
                    write_texture(queue, texture, &vec![0; 16 * texels], 16);
                }
            })?;
            return self.finish(device, views, steps, stats);
        }
        let context = FroxelContext {
            device,
            pipelines: &self.pipelines,
            frame,
            froxels,
            targets: &targets,
            density: &density,
            stand_in: &self.stand_ins.volume,
        };
        if let Some(state) = &mut self.froxels {
            state.build(&context, &mut steps, &mut stats)?;
        }
        self.finish(device, views, steps, stats)
    }

    /// Keeps what a frame was prepared to, with what draws and times it.
    pub(super) fn finish(
        &mut self,
        device: &wgpu::Device,
        views: Vec<ViewState>,
        steps: Vec<Step>,
        mut stats: FrameStats,
    ) -> Result<(), PrepareError> {
        if let (Some(target), Some(view)) = (self.target, views.first()) {
            for (variant, _) in &view.draws {
                if !self.composite.contains_key(variant) {
                    let pipeline =
                        composite::pipeline(&self.pipelines, &self.layouts.composite, &target, *variant)?;
                    self.composite.insert(*variant, pipeline);
                }
            }
        }
        stats.passes = steps.iter().filter_map(|step| step.label().map(str::to_owned)).collect();
        self.timer = PassTimer::reserve(device, self.timer.take(), stats.passes.len())?;
        stats.bytes += views.iter().map(ViewState::bytes).sum::<u64>();
        (self.views, self.steps, self.stats) = (views, steps, stats);
        Ok(())
    }

    /// Makes what the light volumes of a frame are drawn with, and says how their sums come.
    pub(super) fn reserve_light_volumes(&mut self, work: &mut [Work]) -> Result<(), CreateError> {
        for work in work {
            let Some(tessellation) = work.tessellation else { continue };
            let passes = match &mut self.light_volumes {
                Some(passes) => passes,
                slot => slot.insert(LightVolumePasses::new(&self.pipelines)?),
            };
            passes.reserve(&self.pipelines, work.volume_variant(), tessellation)?;
            work.variant.fixed = !passes.blends();
            if work.variant.fixed {
                self.scatter_pipeline(work.variant.unshadowed())?;
            }
        }
        Ok(())
    }

    pub(super) fn scatter_pipeline(&mut self, variant: Variant) -> Result<(), CreateError> {
        if !self.scatter.contains_key(&variant) {
            let view = if variant.listed { &self.layouts.listed } else { &self.layouts.view };
            let mut layouts = vec![view, &self.layouts.light];
            layouts.extend(variant.rays.then_some(&self.layouts.bvh));
            layouts.extend((variant.shader == Shader::LightVolume).then_some(&self.layouts.crossings));
            let made = if variant.listed { listed_pipeline } else { compute_pipeline };
            let pipeline = made(&self.pipelines, variant.file(), &layouts, &variant.constants())?;
            self.scatter.insert(variant, pipeline);
        }
        Ok(())
    }

    /// The passes that convert and refine maps.
    pub(super) fn map_passes(
        &self,
        device: &wgpu::Device,
        frame: &Frame<'_>,
        work: &[Work],
        steps: &mut Vec<Step>,
        stats: &mut FrameStats,
    ) -> Result<Vec<MapChange>, PrepareError> {
        let mut building = Vec::new();
        for work in work {
            let shadows = work.lamp.and_then(|index| frame.lamps[index].shadows);
            if let Some(bvh) = shadows.and_then(|shadows| shadows.bvh()) {
                stats.bytes += bvh.bytes();
                stats.triangles += bvh.triangle_count();
            }
            let Some(map) = shadows.and_then(|shadows| shadows.map()) else { continue };
            stats.maps += 1;
            let version = map.version();
            let mut change = MapChange { map: map.clone(), version, pyramid: None, leaves: None };
            if let Some(source) = map.unconverted() {
                steps.push(Step::Compute(self.converter.pass(device, map, source)));
            }
            if work.variant.shader == Shader::Exact {
                let surface = lights::surface(&work.variant);
                let pyramid = map.pyramid(device, surface)?;
                if !pyramid.is_current(version) {
                    steps.extend(self.pyramids.passes(device, map, &pyramid).into_iter().map(Step::Compute));
                    stats.pyramids_built += 1;
                    change.pyramid = Some(pyramid);
                }
            }
            if let (Some(passes), Some(settings)) = (&self.light_volumes, lights::tessellation(frame, work)) {
                let leaves = map.tessellation(device, settings)?;
                if !leaves.is_current(version) {
                    steps.extend(passes.tessellation.steps(device, map, &leaves));
                    stats.tessellations_built += 1;
                    change.leaves = Some(leaves);
                }
            }
            building.push(change);
            stats.bytes += map.bytes();
        }
        Ok(building)
    }

    /// The steps that find the silhouettes of shadow volumes whose light has moved, and which those are.
    pub(super) fn silhouettes(
        &self,
        device: &wgpu::Device,
        frame: &Frame<'_>,
        work: &[Work],
        steps: &mut Vec<Step>,
        stats: &mut FrameStats,
    ) -> Result<Vec<(ShadowVolume, Key)>, PrepareError> {
        let Some(volumes) = &self.volumes else { return Ok(Vec::new()) };
        let mut moved = Vec::new();
        for lamp in work.iter().filter(|work| work.faces.is_some()).filter_map(|work| work.lamp) {
            let Lamp { light, volume: Some(volume), .. } = &frame.lamps[lamp] else { continue };
            stats.bytes += volume.bytes() + volume.casters().bytes();
            let key = key_of(light);
            if !volume.is_current(&key) {
                let found = prepared(device, "a silhouette", || volumes.silhouette(device, volume, light))?;
                steps.extend(found);
                stats.silhouettes_found += 1;
                moved.push(((*volume).clone(), key));
            }
        }
        Ok(moved)
    }

    /// The draws that composite a view.
    pub(super) fn draws(
        &self,
        device: &wgpu::Device,
        medium: &Medium,
        uniform: &wgpu::Buffer,
        ray_ends: &wgpu::TextureView,
        airlight: &Option<wgpu::TextureView>,
        grid: &wgpu::TextureView,
    ) -> Vec<(CompositeVariant, wgpu::BindGroup)> {
        let Some(airlight) = airlight else { return Vec::new() };
        let sigma_t = medium.coefficients.sigma_t();
        let achromatic = sigma_t[0] == sigma_t[1] && sigma_t[1] == sigma_t[2];
        let variant = CompositeVariant {
            bounded: medium.bounds.is_some(),
            density: match &medium.density {
                None => 0,
                Some(Density::Height { .. }) => 1,
                Some(Density::Grid(_)) => 2,
            },
            attenuates: false,
            adds: !achromatic,
        };
        let entries = [
            (0, uniform.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(ray_ends)),
            (2, wgpu::BindingResource::TextureView(airlight)),
            (4, wgpu::BindingResource::TextureView(grid)),
        ]
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("fog composite"),
            layout: &self.layouts.composite,
            entries: &entries,
        });
        let mut draws = Vec::new();
        if !achromatic {
            draws.push((CompositeVariant { attenuates: true, adds: false, ..variant }, group.clone()));
        }
        draws.push((variant, group));
        draws
    }
}
