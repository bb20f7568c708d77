//! One view of a frame: its passes in order, and the draws that composite it.

use super::frame::{Adaptive, Frame, Sampling, SceneDepth, View};
use super::plan::{Shader, Work};
use super::sampling::{SampledView, Samples, lattice};
use super::targets::{self, Targets, ends};
use super::{Fog, ViewState, lights};
use crate::checked::{filled_buffer, prepared};
use crate::layout::{Basis, ImagePlane, LightUniform, MeshUniform, ViewUniform};
use crate::lightvolume::{VolumeTarget, fitting};
use crate::pass::{ComputePass, Dispatch, Step, bind};
use crate::volume::FaceTarget;
use crate::write_texture::write_texture;
use crate::{Faces, FrameStats, PrepareError};

/// What becomes of what was there before, as the shaders know it: `shaders/shared/light.wgsl`.
const REFINES: u32 = 2;
const REFINES_FURTHER: u32 = 3;

/// What a view's passes are made from.
pub(super) struct ViewPasses<'a> {
    pub(super) fog: &'a Fog,
    pub(super) device: &'a wgpu::Device,
    pub(super) queue: &'a wgpu::Queue,
    pub(super) frame: &'a Frame<'a>,
    pub(super) view: &'a View<'a>,
    pub(super) work: &'a [Work],
    pub(super) grid: &'a wgpu::TextureView,
    pub(super) pictures: lights::LightPictures<'a>,
}

/// An image that airlight is computed for.
pub(super) struct Image {
    plane: ImagePlane,
    basis: Basis,
    pub(super) uniform: wgpu::Buffer,
    /// Pixels of the view along the side of a pixel of the image.
    scale: u32,
    /// The same for the image that faces were found for.
    faces_scale: u32,
    /// Faces of the shadow volume of each piece of work that has one.
    faces: Vec<Option<wgpu::TextureView>>,
}

/// The rays of a list, and the passes that trace them.
struct ListedRays<'a> {
    image: &'a Image,
    samples: &'a Samples,
    ray_ends: &'a wgpu::TextureView,
    traced: Vec<ComputePass>,
}

/// The crossings of rays with the surface of a light's volume.
struct Crossings {
    /// What finds them.
    steps: Vec<Step>,
    /// What is left of those that are not kept.
    sums: wgpu::TextureView,
    /// Those that are kept.
    group: wgpu::BindGroup,
}

pub(super) fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl ViewPasses<'_> {
    /// Adds the view's steps; takes textures of the right size out of `old`.
    pub(super) fn build(
        &self,
        old: &mut Vec<Targets>,
        steps: &mut Vec<Step>,
        stats: &mut FrameStats,
    ) -> Result<ViewState, PrepareError> {
        let scale = self.frame.sampling.scale();
        let mut targets = self.targets(old, self.view.size)?;
        let dispatches: usize = self.work.iter().map(|work| work.parts.len()).sum();
        let layers = dispatches.clamp(1, 2);
        let anew = matches!(self.frame.sampling, Sampling::Blocks { anew_at_edges: true, .. });
        let refines = scale > 1 && anew && self.can_refine();
        let count = match self.frame.sampling {
            Sampling::Pixels => layers,
            _ if refines => 2,
            Sampling::Blocks { .. } if scale == 1 => layers,
            _ => 1,
        };
        targets.reserve(self.device, count)?;
        let mut image = self.image(ImagePlane::new(self.view.camera, self.view.size), 1)?;
        self.find_ends(&image, &targets, steps)?;
        let adaptive = self.frame.sampling.adaptive().filter(|_| !self.work.is_empty());
        let (low, result) = match (&self.fog.low, adaptive) {
            (_, Some(adaptive)) => {
                targets.reserve_samples(self.device, adaptive.spacing)?;
                self.find_faces(&mut image, steps)?;
                let tables = self.fill_tables(&image, steps)?;
                self.sample(&image, &targets, &tables, adaptive, steps)?;
                // how many more there are the GPU finds out
                self.count(lattice(self.view.size, adaptive.spacing), 2, stats);
                (Vec::new(), 0)
            }
            (Some(passes), None) if scale > 1 => {
                let mut coarse = self.image(image.plane.coarser(scale), scale)?;
                let mut low =
                    vec![self.targets(old, coarse.plane.size)?, self.targets(old, coarse.plane.size)?];
                low.iter_mut().try_for_each(|layer| layer.reserve(self.device, layers))?;
                let (device, uniform) = (self.device, &image.uniform);
                let down =
                    prepared(device, "a view", || passes.down(device, uniform, scale, &targets, &low))?;
                steps.push(Step::Compute(down));
                self.find_faces(&mut coarse, steps)?;
                let tables = self.fill_tables(&coarse, steps)?;
                let mut result = 0;
                for layer in &low {
                    result = self.scatter(&coarse, layer, &tables, false, steps)?;
                }
                let up = prepared(device, "a view", || {
                    passes.up(device, uniform, scale, &targets, &low, result, refines)
                })?;
                steps.push(Step::Compute(up));
                self.count(coarse.plane.size, 2, stats);
                let mut result = 0;
                if refines {
                    (image.faces, image.faces_scale) = (coarse.faces, scale);
                    result = self.scatter(&image, &targets, &tables, true, steps)?;
                    self.count(image.plane.size, 1, stats);
                }
                (low, result)
            }
            _ => {
                self.find_faces(&mut image, steps)?;
                let tables = self.fill_tables(&image, steps)?;
                let result = self.scatter(&image, &targets, &tables, false, steps)?;
                self.count(self.view.size, 1, stats);
                (Vec::new(), result)
            }
        };
        let fog = self.fog;
        let draws = prepared(self.device, "a view", || {
            let airlight = targets.airlight[result].as_ref().map(view_of);
            let ends = view_of(&targets.ray_ends);
            fog.draws(self.device, self.frame.medium, &image.uniform, &ends, &airlight, self.grid)
        })?;
        if fog.target.is_some() {
            stats.fragments += draws.len() as u64 * u64::from(self.view.size.0) * u64::from(self.view.size.1);
        }
        Ok(ViewState { targets, low, result, is_sampled: adaptive.is_some(), draws })
    }

    /// Textures of `size`: those of the frame before, if there are any.
    pub(super) fn targets(&self, old: &mut Vec<Targets>, size: (u32, u32)) -> Result<Targets, PrepareError> {
        let mut targets = match old.iter().position(|targets| targets.size == size) {
            Some(index) => old.swap_remove(index),
            None => Targets::new(self.device, size)?,
        };
        let volumes = self.work.iter().filter(|work| work.tessellation.is_some());
        if let Some(kept) = volumes.map(|work| work.kept).max() {
            targets.reserve_crossings(self.device, kept)?;
        }
        Ok(targets)
    }

    /// Whether pixels at depth edges can be computed by themselves: not where alpha holds the way of a march so far, nor
    /// where faces are those of the blocks' own rays, nor where all rays are drawn at once.
    fn can_refine(&self) -> bool {
        let fits = |work: &Work| {
            work.variant.shader != Shader::MarchVarying
                && work.faces != Some(Faces::Pixels)
                && work.tessellation.is_none()
        };
        !self.work.is_empty() && self.work.iter().all(fits)
    }

    pub(super) fn image(&self, plane: ImagePlane, scale: u32) -> Result<Image, PrepareError> {
        let View { camera, max_distance, .. } = self.view;
        let uniform = ViewUniform::new(camera, &plane, *max_distance, self.frame.medium);
        let uniform = prepared(self.device, "a view", || {
            let bytes = bytemuck::bytes_of(&uniform);
            filled_buffer(self.device, "fog view", bytes, wgpu::BufferUsages::UNIFORM)
        })?;
        Ok(Image {
            plane,
            basis: Basis::new(camera, &plane),
            uniform,
            scale,
            faces_scale: scale,
            faces: Vec::new(),
        })
    }

    /// Where the rays of all pixels end.
    pub(super) fn find_ends(
        &self,
        image: &Image,
        targets: &Targets,
        steps: &mut Vec<Step>,
    ) -> Result<(), PrepareError> {
        prepared(self.device, "a view", || {
            if let SceneDepth::Buffer { texture, order, near, far } = self.view.depth {
                steps.push(Step::Compute(self.fog.ray_ends.pass(
                    self.device,
                    image.uniform.as_entire_binding(),
                    texture,
                    (order, near, far),
                    &targets.ray_ends,
                )));
            } else {
                write_texture(self.queue, &targets.ray_ends, bytemuck::cast_slice(&ends(self.view)), 4);
            }
        })
    }

    /// The outermost faces of each light's shadow volume.
    fn find_faces(&self, image: &mut Image, steps: &mut Vec<Step>) -> Result<(), PrepareError> {
        for work in self.work {
            let lamp = work.lamp.map(|index| &self.frame.lamps[index]);
            let (Some(volumes), Some(faces), Some(lamp)) = (&self.fog.volumes, work.faces, lamp) else {
                image.faces.push(None);
                continue;
            };
            let Some(volume) = lamp.volume else {
                image.faces.push(None);
                continue;
            };
            let target = FaceTarget {
                camera: self.view.camera,
                light: lamp.light,
                faces: faces.at_scale(image.scale),
                image: image.plane.coarser(faces.at_scale(image.scale).side()),
                margin: lamp
                    .shadows
                    .and_then(|shadows| shadows.map())
                    .map_or(0.0, |map| map.projection().texel(map.size())),
            };
            let (found, texture) = volumes.faces(self.device, volume, &target)?;
            steps.extend(found);
            image.faces.push(Some(view_of(&texture)));
        }
        Ok(())
    }

    /// The table of each piece of work that reads one, made for the view's eye.
    fn fill_tables(
        &self,
        image: &Image,
        steps: &mut Vec<Step>,
    ) -> Result<Vec<Option<wgpu::TextureView>>, PrepareError> {
        let (fog, device) = (self.fog, self.device);
        let flat = &fog.stand_ins.flat;
        let fill = |work: &Work| {
            let size = (work.table_size, work.table_size);
            let texture = targets::texture(device, "frame table", size, wgpu::TextureFormat::Rgba32Float);
            let table = view_of(&texture);
            let light = lights::uniform(device, self.frame, work, &image.basis);
            let pictures = self.pictures;
            let unlit = Work { variant: work.variant.of_table(), ..work.clone() };
            let group = lights::group(
                device,
                &fog.layouts,
                &fog.stand_ins,
                self.frame,
                &unlit,
                &light,
                pictures,
                [None, None],
            );
            let side = work.table_size.div_ceil(8);
            let pass = ComputePass {
                label: format!("{}, table", work.label),
                pipeline: fog.scatter[&unlit.variant].clone(),
                groups: vec![self.view_group(image, flat, flat, &table), group],
                dispatch: Dispatch::Groups([side, side, 1]),
            };
            (pass, table)
        };
        let mut tables = Vec::new();
        for work in self.work {
            if work.table_size == 0 {
                tables.push(None);
                continue;
            }
            let (pass, table) = prepared(device, "a frame's table", || fill(work))?;
            steps.push(Step::Compute(pass));
            tables.push(Some(table));
        }
        Ok(tables)
    }

    /// What a pass over an image reads and writes of the view.
    fn view_group(
        &self,
        image: &Image,
        ray_ends: &wgpu::TextureView,
        before: &wgpu::TextureView,
        to: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let entries = [
            (0, image.uniform.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(ray_ends)),
            (2, wgpu::BindingResource::TextureView(before)),
            (3, wgpu::BindingResource::TextureView(to)),
            (4, wgpu::BindingResource::TextureView(self.grid)),
        ]
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("fog view"),
            layout: &self.fog.layouts.view,
            entries: &entries,
        })
    }

    /// The airlight of an image, light by light; which of the airlight textures holds the result. With `refines` that of
    /// the pixels alone which the first texture says are to be computed anew.
    fn scatter(
        &self,
        image: &Image,
        targets: &Targets,
        tables: &[Option<wgpu::TextureView>],
        refines: bool,
        steps: &mut Vec<Step>,
    ) -> Result<usize, PrepareError> {
        let (fog, device, frame) = (self.fog, self.device, self.frame);
        let (width, height) = image.plane.size;
        prepared(device, "a view", || {
            let ray_ends = view_of(&targets.ray_ends);
            let airlight = targets.airlight.each_ref().map(|texture| texture.as_ref().map(view_of));
            let first_dispatch = usize::from(refines);
            let mut done = first_dispatch;
            for (index, (work, faces)) in self.work.iter().zip(&image.faces).enumerate() {
                for &(first, end) in &work.parts {
                    let (to, before) = (done % 2, (done + 1) % 2);
                    let before = airlight[before].as_ref().filter(|_| done > 0);
                    let before = before.unwrap_or(&fog.stand_ins.flat);
                    let Some(to) = &airlight[to] else { continue };
                    let mut light = lights::uniform(device, frame, work, &image.basis);
                    let wider = image.faces_scale / image.scale;
                    light.face_scale =
                        work.faces.map_or(1, |faces| faces.at_scale(image.faces_scale).side() * wider);
                    (light.first_sample, light.end_sample) = (first, end);
                    light.adds = match (refines, done > first_dispatch) {
                        (false, adds) => u32::from(adds),
                        (true, false) => REFINES,
                        (true, true) => REFINES_FURTHER,
                    };
                    let layouts = &fog.layouts;
                    let mut crossings = self.crossings(image, targets, work, &light, &ray_ends);
                    if let Some(crossings) = &mut crossings {
                        steps.append(&mut crossings.steps);
                    }
                    let sums = crossings.as_ref().map(|crossings| &crossings.sums);
                    let textures = [sums.or(faces.as_ref()), tables[index].as_ref()];
                    let pictures = self.pictures;
                    let light_group = lights::group(
                        device,
                        layouts,
                        &fog.stand_ins,
                        frame,
                        work,
                        &light,
                        pictures,
                        textures,
                    );
                    let view_group = self.view_group(image, &ray_ends, before, to);
                    let mut groups = vec![view_group, light_group];
                    groups.extend(lights::bvh_group(device, layouts, frame, work));
                    groups.extend(crossings.map(|crossings| crossings.group));
                    steps.push(Step::Compute(ComputePass {
                        label: work.label.clone(),
                        pipeline: fog.scatter[&work.variant].clone(),
                        groups,
                        dispatch: Dispatch::Groups([width.div_ceil(8), height.div_ceil(8), 1]),
                    }));
                    done += 1;
                }
            }
            if done == 0
                && let Some(texture) = &targets.airlight[0]
            {
                write_texture(self.queue, texture, &vec![0; 16 * width as usize * height as usize], 16);
            }
            let result = (done + 1) % 2;
            if targets.airlight[result].is_some() { result } else { 0 }
        })
    }

    /// The airlight of rays around which it changes, and from theirs that of all pixels, in the first of the textures.
    fn sample(
        &self,
        image: &Image,
        targets: &Targets,
        tables: &[Option<wgpu::TextureView>],
        adaptive: &Adaptive,
        steps: &mut Vec<Step>,
    ) -> Result<(), PrepareError> {
        let (Some(passes), Some(samples)) = (&self.fog.sampling, &targets.samples) else { return Ok(()) };
        prepared(self.device, "a view", || {
            let ray_ends = view_of(&targets.ray_ends);
            let Some(picture) = &targets.airlight[0] else { return };
            let mut rays = ListedRays { image, samples, ray_ends: &ray_ends, traced: Vec::new() };
            let mut unlit = ListedRays { traced: Vec::new(), ..rays };
            for ((work, faces), table) in self.work.iter().zip(&image.faces).zip(tables) {
                let lit = Work { variant: work.variant.of_list(), ..work.clone() };
                self.trace(&mut rays, &lit, [faces.as_ref(), table.as_ref()]);
                let variant = work.variant.unlit_list();
                let parts = if variant.shader == Shader::Exact { vec![(0, 0)] } else { work.parts.clone() };
                let label = format!("{}, unshadowed", work.label);
                let open = Work { variant, parts, label, faces: None, ..work.clone() };
                self.trace(&mut unlit, &open, [None, table.as_ref()]);
            }
            let view = SampledView {
                uniform: &image.uniform,
                size: image.plane.size,
                ray_ends: &ray_ends,
                samples,
                picture,
            };
            steps.extend(passes.steps(self.device, &view, adaptive, &rays.traced, &unlit.traced));
        })
    }

    /// Adds the passes of a light over the rays of a list.
    fn trace(&self, rays: &mut ListedRays<'_>, work: &Work, textures: [Option<&wgpu::TextureView>; 2]) {
        let (fog, device, frame) = (self.fog, self.device, self.frame);
        let [list, values] = rays.samples.list();
        let view_group = bind(
            device,
            "fog listed pixels",
            &fog.layouts.listed,
            [
                rays.image.uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(rays.ray_ends),
                list.as_entire_binding(),
                values.as_entire_binding(),
                wgpu::BindingResource::TextureView(self.grid),
            ],
        );
        for &(first, end) in &work.parts {
            let mut light = lights::uniform(device, frame, work, &rays.image.basis);
            light.face_scale = work.faces.map_or(1, |faces| faces.at_scale(1).side());
            (light.first_sample, light.end_sample) = (first, end);
            light.adds = u32::from(!rays.traced.is_empty());
            let (layouts, stand_ins) = (&fog.layouts, &fog.stand_ins);
            let light_group =
                lights::group(device, layouts, stand_ins, frame, work, &light, self.pictures, textures);
            let mut groups = vec![view_group.clone(), light_group];
            groups
                .extend(work.variant.rays.then(|| lights::bvh_group(device, layouts, frame, work)).flatten());
            rays.traced.push(ComputePass {
                label: work.label.clone(),
                pipeline: fog.scatter[&work.variant].clone(),
                groups,
                dispatch: rays.samples.dispatch(),
            });
        }
    }

    /// The crossings of an image's rays with the surface of a light's volume.
    fn crossings(
        &self,
        image: &Image,
        targets: &Targets,
        work: &Work,
        light: &LightUniform,
        ray_ends: &wgpu::TextureView,
    ) -> Option<Crossings> {
        let (passes, sums) = (self.fog.light_volumes.as_ref()?, targets.sums.as_ref()?);
        let kept = targets.kept.as_ref()?;
        let pool = fitting(self.device, image.plane.size, work.kept);
        let tessellation = work.tessellation?;
        let shadows = self.frame.lamps[work.lamp?].shadows?;
        let map = shadows.map()?;
        let leaves = lights::tessellation(self.frame, work)
            .and_then(|settings| map.tessellation(self.device, settings).ok());
        let mut steps = Vec::new();
        let stand_in = &self.fog.stand_ins.flat;
        let unshadowed = work.variant.fixed.then(|| self.unshadowed(image, work, ray_ends, &mut steps));
        steps.extend(passes.steps(
            self.device,
            &VolumeTarget {
                variant: work.volume_variant(),
                map,
                tessellation,
                leaves: leaves.as_ref(),
                mesh: MeshUniform::new(
                    &image.basis,
                    map.projection(),
                    map.size(),
                    lights::far_of(&shadows),
                    pool,
                ),
                light,
                view: &image.uniform,
                size: image.plane.size,
                ray_ends,
                unshadowed: unshadowed.as_ref().unwrap_or(stand_in),
                stand_in,
                sums,
                kept,
                label: &work.label,
            },
        ));
        let pool = filled_buffer(
            self.device,
            "room for crossings",
            bytemuck::bytes_of(&[pool, 0, 0, 0]),
            wgpu::BufferUsages::UNIFORM,
        );
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("fog crossings"),
            layout: &self.fog.layouts.crossings,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: kept.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: pool.as_entire_binding() },
            ],
        });
        Some(Crossings { steps, sums: view_of(sums), group })
    }

    /// Adds the pass that finds the airlight of a light as if nothing shadowed it; where that is left.
    fn unshadowed(
        &self,
        image: &Image,
        work: &Work,
        ray_ends: &wgpu::TextureView,
        steps: &mut Vec<Step>,
    ) -> wgpu::TextureView {
        let (fog, device, frame) = (self.fog, self.device, self.frame);
        let (width, height) = image.plane.size;
        let texture = targets::texture(
            device,
            "unshadowed airlight",
            (width, height),
            wgpu::TextureFormat::Rgba32Float,
        );
        let to = view_of(&texture);
        let unlit = Work { variant: work.variant.unshadowed(), tessellation: None, ..work.clone() };
        let light = lights::uniform(device, frame, &unlit, &image.basis);
        let (stand_ins, pictures) = (&fog.stand_ins, self.pictures);
        let group =
            lights::group(device, &fog.layouts, stand_ins, frame, &unlit, &light, pictures, [None, None]);
        steps.push(Step::Compute(ComputePass {
            label: format!("{}, unshadowed", work.label),
            pipeline: fog.scatter[&unlit.variant].clone(),
            groups: vec![self.view_group(image, ray_ends, &stand_ins.flat, &to), group],
            dispatch: Dispatch::Groups([width.div_ceil(8), height.div_ceil(8), 1]),
        }));
        to
    }

    /// Adds what an image of `size` pixels in so many layers costs.
    fn count(&self, (width, height): (u32, u32), layers: u64, stats: &mut FrameStats) {
        for work in self.work {
            let steps = layers * u64::from(work.samples) * u64::from(width) * u64::from(height);
            stats.samples += steps;
            stats.rays += if work.variant.rays { steps } else { 0 };
            stats.closed_forms += u32::from(work.variant.shader == Shader::Exact && !work.variant.shadowed);
        }
    }
}
