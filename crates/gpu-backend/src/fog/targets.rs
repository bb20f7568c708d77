//! What a view owns on the GPU: where its rays end, and its airlight so far.

use scene::Camera;

use super::frame::{SceneDepth, View};
use super::sampling::Samples;
use crate::PrepareError;
use crate::checked::{check_size, prepared};
use crate::layout::ENDLESS;
use crate::lightvolume::{kept_bytes, sums_texture};
use crate::map::check_depth_texture;

/// Textures of one view.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) size: (u32, u32),
    pub(crate) ray_ends: wgpu::Texture,
    /// Written in turns; the second is there only if the frame needs two dispatches or more.
    pub(crate) airlight: [Option<wgpu::Texture>; 2],
    /// Sums over the surface of a light volume, one light after the other.
    pub(crate) sums: Option<wgpu::Texture>,
    /// Crossings with it that are kept.
    pub(crate) kept: Option<wgpu::Buffer>,
    /// What adaptive sampling is kept in.
    pub(crate) samples: Option<Samples>,
}

impl Targets {
    pub(crate) fn new(device: &wgpu::Device, size: (u32, u32)) -> Result<Self, PrepareError> {
        let ray_ends = prepared(device, "a view's textures", || {
            texture(device, "ray ends", size, wgpu::TextureFormat::R32Float)
        })?;
        Ok(Self { size, ray_ends, airlight: [None, None], sums: None, kept: None, samples: None })
    }

    /// Makes sure that there are `count` textures for airlight.
    pub(crate) fn reserve(&mut self, device: &wgpu::Device, count: usize) -> Result<(), PrepareError> {
        let size = self.size;
        for slot in self.airlight.iter_mut().take(count).filter(|slot| slot.is_none()) {
            *slot = Some(prepared(device, "a view's textures", || {
                texture(device, "airlight", size, wgpu::TextureFormat::Rgba32Float)
            })?);
        }
        Ok(())
    }

    /// Makes sure that there is room for the crossings with light volumes: `kept` of each pixel, or as many as fit.
    pub(crate) fn reserve_crossings(&mut self, device: &wgpu::Device, kept: u32) -> Result<(), PrepareError> {
        if self.sums.is_none() {
            self.sums = Some(sums_texture(device, self.size)?);
        }
        let needed = kept_bytes(device, self.size, kept);
        if self.kept.as_ref().is_none_or(|buffer| buffer.size() < needed) {
            check_size(device, "the crossings with a light volume", needed)?;
            self.kept = Some(prepared(device, "the crossings with a light volume", || {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("light volume crossings"),
                    size: needed,
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })?);
        }
        Ok(())
    }

    /// Makes sure that there is room to sample from every `spacing`-th pixel on.
    pub(crate) fn reserve_samples(
        &mut self,
        device: &wgpu::Device,
        spacing: u32,
    ) -> Result<(), PrepareError> {
        if !self.samples.as_ref().is_some_and(|samples| samples.fits(spacing)) {
            self.samples = Some(Samples::new(device, self.size, spacing)?);
        }
        Ok(())
    }

    /// Memory; units: bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let pixels = u64::from(self.size.0) * u64::from(self.size.1);
        let textures = self.airlight.iter().chain([&self.sums]).flatten().count() as u64;
        let samples = self.samples.as_ref().map_or(0, Samples::bytes);
        pixels * (4 + 16 * textures) + self.kept.as_ref().map_or(0, wgpu::Buffer::size) + samples
    }
}

pub(super) fn texture(
    device: &wgpu::Device,
    label: &str,
    size: (u32, u32),
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Checks a view before anything is made for it.
pub(crate) fn check_view(index: usize, view: &View<'_>, largest: u32) -> Result<(), PrepareError> {
    let (width, height) = view.size;
    if width == 0 || height == 0 {
        return Err(PrepareError::EmptyView { view: index });
    }
    if width.max(height) > largest {
        return Err(PrepareError::TooLarge {
            what: "a view's side",
            needed: width.max(height).into(),
            limit: largest.into(),
            unit: "pixels",
        });
    }
    let value = |name, value, valid| Err(PrepareError::Value { view: index, name, value, valid });
    let Camera { position, fov_y, .. } = view.camera;
    if !(position.is_finite() && fov_y.is_finite() && *fov_y > 0.0) {
        return value("the camera's field of view", f64::from(*fov_y), "be positive, at a finite position");
    }
    if !(view.max_distance > 0.0) {
        return value("max_distance", view.max_distance, "be positive");
    }
    match view.depth {
        SceneDepth::Nothing => Ok(()),
        SceneDepth::Distances(distances) => {
            let pixels = u64::from(width) * u64::from(height);
            let got = distances.len() as u64;
            if got != pixels {
                return Err(PrepareError::Distances { view: index, pixels, got });
            }
            match distances.iter().find(|distance| !(**distance >= 0.0)) {
                Some(&bad) => value("a distance", bad.into(), "be at least 0"),
                None => Ok(()),
            }
        }
        SceneDepth::Buffer { texture, near, far, .. } => {
            check_depth_texture("the view's depth texture", texture, 1)?;
            if (texture.width(), texture.height()) != view.size {
                return Err(PrepareError::Texture {
                    what: "the view's depth texture",
                    got: format!("{} x {} pixels", texture.width(), texture.height()),
                    wanted: format!("{width} x {height} pixels"),
                });
            }
            if !(near > 0.0 && near < far && near.is_finite()) {
                return value("the near plane", near.into(), "be positive and less than the far plane");
            }
            Ok(())
        }
    }
}

/// Distances that the shaders read: no infinity, and nothing beyond `max_distance`, which ends rays that hit nothing.
pub(crate) fn ends(view: &View<'_>) -> Vec<f32> {
    let most = (view.max_distance as f32).min(ENDLESS);
    match view.depth {
        SceneDepth::Distances(distances) => {
            // a surface ends a ray wherever it is
            distances.iter().map(|&d| if d.is_finite() { d.min(ENDLESS) } else { most }).collect()
        }
        SceneDepth::Nothing | SceneDepth::Buffer { .. } => {
            vec![most; view.size.0 as usize * view.size.1 as usize]
        }
    }
}
