//! Pictures of spot lights at every size, for marches whose steps see no more detail than they can resolve.

use std::sync::Arc;

use half::f16;
use hybrid_march::LightMips;
use scene::{Light, LightTexture};

use super::frame::{Frame, Technique};
use crate::PrepareError;
use crate::checked::prepared;
use crate::write_texture::write_texture_level;

/// Format in which pictures are filtered: 32 bits where the device can, else 16.
fn format(device: &wgpu::Device) -> wgpu::TextureFormat {
    if device.features().contains(wgpu::Features::FLOAT32_FILTERABLE) {
        wgpu::TextureFormat::Rgba32Float
    } else {
        wgpu::TextureFormat::Rgba16Float
    }
}

/// A picture at every size on the GPU, and what it was made from.
#[derive(Debug)]
struct Known {
    picture: Arc<LightTexture>,
    blur: u32,
    texture: wgpu::Texture,
}

/// Mip chains of the last frame that used any; one that several lights or frames share is uploaded once.
#[derive(Debug, Default)]
pub(super) struct MipPictures {
    known: Vec<Known>,
}

impl MipPictures {
    /// The mip chain of each light's picture, if it has one and the technique reads it.
    pub(super) fn of(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame<'_>,
    ) -> Result<Vec<Option<wgpu::TextureView>>, PrepareError> {
        let blur = match frame.technique {
            Technique::Hybrid(hybrid) => hybrid.picture.blur(),
            Technique::BruteForce { .. }
            | Technique::ExactShadowMap { .. }
            | Technique::LightVolume { .. }
            | Technique::Froxels(_) => None,
        };
        let mut kept: Vec<Known> = Vec::new();
        let mut views = Vec::new();
        for lamp in frame.lamps {
            let picture = match lamp.light {
                Light::Spot(spot) => spot.texture.clone(),
                Light::Point(_) | Light::Directional(_) => None,
            };
            let (Some(picture), Some(blur)) = (picture, blur) else {
                views.push(None);
                continue;
            };
            let same = |known: &&Known| Arc::ptr_eq(&known.picture, &picture) && known.blur == blur.to_bits();
            let texture = match kept.iter().chain(&self.known).find(same) {
                Some(known) => known.texture.clone(),
                None => upload(device, queue, &picture, blur)?,
            };
            views.push(Some(texture.create_view(&wgpu::TextureViewDescriptor::default())));
            kept.push(Known { picture, blur: blur.to_bits(), texture });
        }
        self.known = kept;
        Ok(views)
    }

    /// Memory; units: bytes.
    pub(super) fn bytes(&self) -> u64 {
        let texel = |texture: &wgpu::Texture| u64::from(texture.format().block_copy_size(None).unwrap_or(16));
        let size = |texture: &wgpu::Texture| u64::from(texture.width()) * u64::from(texture.height());
        // a third more for the smaller levels
        self.known.iter().map(|known| size(&known.texture) * texel(&known.texture) * 4 / 3).sum()
    }
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &LightTexture,
    blur: f32,
) -> Result<wgpu::Texture, PrepareError> {
    let limit = device.limits().max_texture_dimension_2d;
    let side = picture.width.max(picture.height);
    if side > limit {
        return Err(PrepareError::TooLarge {
            what: "the light texture's side",
            needed: side.into(),
            limit: limit.into(),
            unit: "texels",
        });
    }
    let mips = LightMips::new(picture, blur);
    let levels = mips.levels();
    let format = format(device);
    prepared(device, "the light texture", || {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("light texture at every size"),
            size: wgpu::Extent3d { width: picture.width, height: picture.height, depth_or_array_layers: 1 },
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (level, index) in levels.iter().zip(0..) {
            if format == wgpu::TextureFormat::Rgba32Float {
                let texels: Vec<[f32; 4]> = level.texels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
                write_texture_level(queue, &texture, index, bytemuck::cast_slice(&texels), 16);
            } else {
                let half = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32()));
                let texels: Vec<[f16; 4]> =
                    level.texels.iter().map(|&[r, g, b]| [half(r), half(g), half(b), f16::ONE]).collect();
                write_texture_level(queue, &texture, index, bytemuck::cast_slice(&texels), 8);
            }
        }
        texture
    })
}
