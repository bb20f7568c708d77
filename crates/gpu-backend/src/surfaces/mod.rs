//! Surfaces lit by every light and attenuated on both ways: the picture that fog is drawn over, for a view without a
//! renderer of its own. Twin of `shaders/frame/surfaces.wgsl`.

mod frame;
mod triangles;

use std::collections::HashMap;

use scene::{Density, Light, Medium, Refusal, WideBvh};

pub use frame::{SurfaceFrame, VisibleSurfaces};
pub use triangles::{SurfaceTriangle, SurfaceTriangles};

use crate::capabilities::check_limits;
use crate::checked::{check_size, filled_buffer, prepared};
use crate::fog::grid::DensityTexture;
use crate::fog::layout::{Layouts, StandIns};
use crate::fog::lights::{Pictures, light_group, rays_group};
use crate::fog::targets::{Targets, check_view, ends};
use crate::layout::{Basis, ImagePlane, LightUniform, ViewUniform};
use crate::pass::{ComputePass, Dispatch, compute_pipeline, storage};
use crate::pipelines::Pipelines;
use crate::read_radiance::read_radiance;
use crate::timing::PassTimer;
use crate::write_texture::write_texture;
use crate::{
    CreateError, GpuBvh, Lamp, MAX_LIGHTS, PassTime, PrepareError, ReadError, SceneDepth, Shadows, View,
};

const PASS: &str = "frame/surfaces";

/// The override constants of a light's pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    /// 0 point, 1 spot, 2 directional.
    light: u8,
    textured: bool,
    shadowed: bool,
    bounded: bool,
    /// 0 none, 1 height, 2 grid.
    density: u8,
}

impl Variant {
    /// The pass of a lamp.
    ///
    /// # Errors
    /// [`Refusal`] if a map shadows it.
    fn new(lamp: &Lamp<'_>, medium: &Medium) -> Result<Self, Refusal> {
        if let Some(Shadows::Map { .. }) = lamp.shadows {
            return Err(Refusal {
                technique: "lighting of surfaces on the GPU",
                feature: "a shadow map",
                instead: "shadow rays",
            });
        }
        let (light, textured) = match lamp.light {
            Light::Point(_) => (0, false),
            Light::Spot(spot) => (1, spot.texture.is_some()),
            Light::Directional(_) => (2, false),
        };
        let density = match &medium.density {
            None => 0,
            Some(Density::Height { .. }) => 1,
            Some(Density::Grid(_)) => 2,
        };
        Ok(Self {
            light,
            textured,
            shadowed: lamp.shadows.is_some(),
            bounded: medium.bounds.is_some(),
            density,
        })
    }

    fn constants(&self) -> [(&'static str, f64); 5] {
        let flag = |value: bool| f64::from(u8::from(value));
        [
            ("LIGHT", f64::from(self.light)),
            ("TEXTURED", flag(self.textured)),
            ("SHADOWED", flag(self.shadowed)),
            ("BOUNDED", flag(self.bounded)),
            ("DENSITY", f64::from(self.density)),
        ]
    }

    fn label(&self, index: usize) -> String {
        let kind = match self.light {
            0 => "point",
            1 => "spot",
            _ => "directional",
        };
        format!("{kind} light {index}, surfaces")
    }
}

/// Surfaces in view, lit on a device that is the host's or one's own.
///
/// [`Surfaces::new`], then for every frame [`Surfaces::prepare`] and [`Surfaces::encode`] into the host's encoder. Nothing
/// here submits, but for [`Surfaces::read`].
#[derive(Debug)]
pub struct Surfaces {
    layouts: Layouts,
    /// The triangles and which of them each pixel sees.
    surface_layout: wgpu::BindGroupLayout,
    stand_ins: StandIns,
    /// What a light without shadows is bound to.
    no_bvh: GpuBvh,
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
    pictures: Pictures,
    density: DensityTexture,
    timer: Option<PassTimer>,
    passes: Vec<ComputePass>,
    targets: Option<Targets>,
    /// Which of the targets' textures holds the result.
    result: usize,
}

impl Surfaces {
    /// Makes what every frame needs; pipelines for particular lights and media are made when a frame first needs them.
    ///
    /// # Errors
    /// [`PrepareError::Create`] if the device was made with less than
    /// [`required_limits`](crate::required_limits), [`PrepareError::Device`] if it is lost.
    pub fn new(device: &wgpu::Device) -> Result<Self, PrepareError> {
        check_limits(device)?;
        let no_bvh = GpuBvh::upload(device, &WideBvh::default())?;
        prepared(device, "the surfaces' layouts", || Self {
            layouts: Layouts::new(device),
            surface_layout: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("surfaces"),
                entries: &[storage(0), storage(1)],
            }),
            stand_ins: StandIns::new(device),
            no_bvh,
            pipelines: HashMap::new(),
            pictures: Pictures::default(),
            density: DensityTexture::default(),
            timer: None,
            passes: Vec::new(),
            targets: None,
            result: 0,
        })
    }

    /// Uploads a frame and decides what it needs; nothing is submitted.
    ///
    /// # Errors
    /// [`PrepareError`] names what does not fit: too many lights, a view that is too large or has not one distance and
    /// one triangle a pixel, a light with a shadow map, a device that is lost. Nothing of the frame before is left.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &SurfaceFrame<'_>,
    ) -> Result<(), PrepareError> {
        self.passes.clear();
        let old = self.targets.take();
        let view = checked_view(device, frame)?;
        let pictures = self.pictures.of(device, queue, frame.lamps)?;
        let density = self.density.of(device, queue, frame.medium, &self.stand_ins)?;
        let mut targets = match old.filter(|targets| targets.size == frame.size) {
            Some(targets) => targets,
            None => Targets::new(device, frame.size)?,
        };
        targets.reserve(device, frame.lamps.len().clamp(1, 2))?;
        let mut variants = Vec::new();
        for lamp in frame.lamps {
            let variant = Variant::new(lamp, frame.medium)?;
            self.make_pipeline(device, variant)?;
            variants.push(variant);
        }
        self.timer = PassTimer::reserve(device, self.timer.take(), variants.len())?;
        self.passes = prepared(device, "the surfaces", || {
            write_texture(queue, &targets.ray_ends, bytemuck::cast_slice(&ends(&view)), 4);
            if let (Some(dark), true) = (&targets.airlight[0], frame.lamps.is_empty()) {
                write_texture(queue, dark, &vec![0; 16 * frame.visible.triangles.len()], 16);
            }
            self.passes(device, frame, &variants, &targets, &density, &pictures)
        })?;
        self.result = (self.passes.len() + 1) % 2;
        if self.passes.is_empty() {
            self.result = 0;
        }
        self.targets = Some(targets);
        Ok(())
    }

    /// Encodes the prepared frame's passes; may be called again for the same frame.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) {
        encoder.push_debug_group("surfaces");
        for (pass, index) in self.passes.iter().zip(0..) {
            pass.encode(encoder, self.timer.as_ref().map(|timer| timer.writes(index)));
        }
        encoder.pop_debug_group();
        if let Some(timer) = &mut self.timer {
            timer.resolve(encoder, self.passes.iter().map(|pass| pass.label.as_str()));
        }
    }

    /// The lit surfaces: rgba32float, radiance in rgb as it arrives at the eye, 0 where there is none; `None` before a
    /// frame was prepared.
    pub fn radiance(&self) -> Option<&wgpu::Texture> {
        self.targets.as_ref()?.airlight[self.result].as_ref()
    }

    /// Radiance of all pixels, row by row from the top, once the frame's commands are submitted; submits a copy and waits
    /// for it; units: W/(m²·sr).
    ///
    /// # Errors
    /// [`ReadError::Nothing`] if no frame was prepared, [`ReadError::Device`] if the device is lost.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[f32; 3]>, ReadError> {
        let texture = self.radiance().ok_or(ReadError::Nothing("such surfaces"))?;
        read_radiance(device, queue, texture, "the surfaces")
    }

    /// Times of the passes of the last encoded frame, one a light, once its commands are submitted; waits for the device.
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

    fn make_pipeline(&mut self, device: &wgpu::Device, variant: Variant) -> Result<(), CreateError> {
        if !self.pipelines.contains_key(&variant) {
            let Layouts { view, light, bvh, .. } = &self.layouts;
            let layouts = [view, light, bvh, &self.surface_layout];
            let pipeline = compute_pipeline(&Pipelines::new(device), PASS, &layouts, &variant.constants())?;
            self.pipelines.insert(variant, pipeline);
        }
        Ok(())
    }

    /// A pass a light; each adds to what the one before has written.
    fn passes(
        &self,
        device: &wgpu::Device,
        frame: &SurfaceFrame<'_>,
        variants: &[Variant],
        targets: &Targets,
        density: &wgpu::TextureView,
        pictures: &[Option<wgpu::TextureView>],
    ) -> Vec<ComputePass> {
        use wgpu::BindingResource::TextureView;
        let image = ImagePlane::new(frame.camera, frame.size);
        let basis = Basis::new(frame.camera, &image);
        let buffer = |label, contents: &[u8], usage| filled_buffer(device, label, contents, usage);
        let group = |label, layout, entries: &[(u32, wgpu::BindingResource<'_>)]| {
            let entries: Vec<_> = entries
                .iter()
                .map(|(binding, resource)| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: resource.clone(),
                })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries: &entries,
            })
        };
        let view = ViewUniform::new(frame.camera, &image, f64::INFINITY, frame.medium);
        let view = buffer("surfaces view", bytemuck::bytes_of(&view), wgpu::BufferUsages::UNIFORM);
        let hits = bytemuck::cast_slice(frame.visible.triangles);
        let hits = buffer("surfaces hits", hits, wgpu::BufferUsages::STORAGE);
        let surfaces = group(
            "surfaces",
            &self.surface_layout,
            &[(0, frame.triangles.buffer.as_entire_binding()), (1, hits.as_entire_binding())],
        );
        let ray_ends = targets.ray_ends.create_view(&wgpu::TextureViewDescriptor::default());
        let radiance = targets
            .airlight
            .each_ref()
            .map(|texture| texture.as_ref().map(|t| t.create_view(&wgpu::TextureViewDescriptor::default())));
        let mut passes = Vec::new();
        for (index, (lamp, variant)) in frame.lamps.iter().zip(variants).enumerate() {
            let before = radiance[(index + 1) % 2].as_ref().filter(|_| index > 0);
            let Some(to) = &radiance[index % 2] else { continue };
            let mut light = LightUniform::new(&basis, lamp.light);
            light.adds = u32::from(index > 0);
            if let Some(shadows) = lamp.shadows {
                light = light.with_occluders(&basis, shadows.casters());
            }
            let light = buffer("surfaces light", bytemuck::bytes_of(&light), wgpu::BufferUsages::UNIFORM);
            let stand_ins = &self.stand_ins;
            let (array, flat) = (&stand_ins.array, &stand_ins.flat);
            let picture = pictures[index].as_ref().unwrap_or(flat);
            let textures = [array, array, array, picture, flat, &stand_ins.filtered, flat];
            let bvh = lamp.shadows.and_then(|shadows| shadows.bvh()).unwrap_or(&self.no_bvh);
            let view = group(
                "surfaces view",
                &self.layouts.view,
                &[
                    (0, view.as_entire_binding()),
                    (1, TextureView(&ray_ends)),
                    (2, TextureView(before.unwrap_or(&self.stand_ins.flat))),
                    (3, TextureView(to)),
                    (4, TextureView(density)),
                ],
            );
            passes.push(ComputePass {
                label: variant.label(index),
                pipeline: self.pipelines[variant].clone(),
                groups: vec![
                    view,
                    light_group(device, &self.layouts, &stand_ins.sampler, &light, textures),
                    rays_group(device, &self.layouts, bvh),
                    surfaces.clone(),
                ],
                dispatch: Dispatch::Groups([frame.size.0.div_ceil(8), frame.size.1.div_ceil(8), 1]),
            });
        }
        passes
    }
}

/// The frame's view, if it can be taken.
fn checked_view<'a>(device: &wgpu::Device, frame: &SurfaceFrame<'a>) -> Result<View<'a>, PrepareError> {
    if frame.lamps.len() > MAX_LIGHTS {
        return Err(PrepareError::TooManyLights { got: frame.lamps.len(), most: MAX_LIGHTS });
    }
    let view = View {
        camera: frame.camera,
        size: frame.size,
        depth: SceneDepth::Distances(frame.visible.distances),
        max_distance: f64::INFINITY,
    };
    check_view(0, &view, device.limits().max_texture_dimension_2d)?;
    let pixels = frame.visible.distances.len() as u64;
    let got = frame.visible.triangles.len() as u64;
    if got != pixels {
        return Err(PrepareError::Triangles { pixels, got });
    }
    check_size(device, "the visibility buffer", 4 * pixels)?;
    Ok(view)
}
